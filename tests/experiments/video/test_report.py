import json

import numpy as np
import pytest

from experiments.video.report import write_report
from experiments.video.results import read_results
from experiments.video.tables import affine_table, score_table

AFFINE_HEADER = (
    "run,frame,corner_error_px,scale_error,aspect_error,rotation_error_rad,shear_error,"
    "nees,ess,ancestor_count,resampling_distance,visible\n"
)


def write(out, protocol, tracker, sequence, boxes, seed=0):
    path = out / "boxes" / protocol / tracker / str(seed) / f"{sequence}.csv"
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = [f"1,{k},{','.join(map(str, box))}\n" for k, box in enumerate(boxes, start=1)]
    path.write_text("run,frame,x,y,w,h\n" + "".join(rows))


@pytest.fixture
def folder(tmp_path, paint):
    """gpf misses from frame 5 of 8 on, igpf never on A and always on B, seed 1 is like gpf."""
    root, out = tmp_path / "root", tmp_path / "out"
    for number, name in enumerate("AB"):
        true = paint(root / name, seed=number)
        (root / name / "attrs.txt").write_text("SV\n" if name == "A" else "SV FM\n")
        half, none = true.copy(), true.copy()
        half[4:, 0] += 100
        none[1:, 0] += 100
        write(out, "ope", "gpf", name, half)
        write(out, "ope", "igpf", name, true if name == "A" else none)
        write(out, "ope", "igpf", name, half, seed=1)
    write(out, "tre", "igpf", "A", true)
    (out / "manifest.json").write_text(json.dumps({"root": "../root"}))
    return out


@pytest.fixture
def without_figures(monkeypatch):
    """Drawing takes long."""
    monkeypatch.setattr("experiments.video.figures.write_figures", lambda *_: [])


def test_means_are_over_seeds_then_sequences_and_gains_over_gpf(folder):
    """gpf: 4 of 8 frames on both. igpf: (8/8 + 4/8)/2 on A, (1/8 + 4/8)/2 on B: 0.53125."""
    table = score_table(read_results(folder, None), "dp")
    igpf, gpf = table.rows
    assert (igpf["tracker"], igpf["ope"]) == ("igpf", pytest.approx(0.53125))
    assert gpf["ope"] == 0.5
    assert gpf["ope_gain"] is None
    assert igpf["ope_gain"] == pytest.approx(0.0625)
    assert igpf["ope_gain_low"] == pytest.approx(0.3125 / 0.5 - 1)
    assert igpf["ope_gain_high"] == pytest.approx(0.75 / 0.5 - 1)
    assert (igpf["tre"], gpf["tre"]) == (1.0, None)
    overlap = score_table(read_results(folder, None), "os")
    assert overlap.rows[1]["ope"] == pytest.approx(0.5 * 20 / 21)
    assert score_table(read_results(folder, None), "dp").rows == table.rows


def test_means_are_over_sequences_that_all_have_finished(folder, without_figures):
    (folder / "boxes" / "ope" / "gpf" / "0" / "B.csv").unlink()
    results = read_results(folder, None)
    assert results.sequences("ope") == ["A"]
    assert results.left_out("ope") == ["B"]
    assert results.sequences("ope", "FM") == []
    assert "ope: left out, as not every tracker has finished them: B" in write_report(folder).text


def test_a_report_has_tables_and_figures_and_repeats(folder):
    report = write_report(folder, pictures=True)
    names = {path.name for path in report.paths}
    assert {"precision.csv", "overlap.md", "sequences.csv", "attributes.csv"} < names
    assert {"curves_ope.png", "curves_tre.pdf", "success_by_attribute.png"} < names
    assert "boxes_ope.png" in names
    assert "affine.csv" not in names
    first = {path: path.read_bytes() for path in report.paths}
    assert {path: path.read_bytes() for path in write_report(folder, pictures=True).paths} == first
    lines = (folder / "tables" / "sequences.csv").read_text().splitlines()
    assert lines[:2] == ["protocol,sequence,tracker,seeds,dp,os", "ope,A,igpf,2,0.75,0.714285714"]
    attributes = (folder / "tables" / "attributes.md").read_text()
    assert "| FM | 1 | igpf | 0.312 | 0.298 |" in attributes


def test_a_report_needs_no_images(folder, without_figures):
    for path in (folder.parent / "root").glob("*/img/*"):
        path.unlink()
    assert write_report(folder).paths


def test_affine_errors_are_over_visible_frames(folder, without_figures):
    path = folder / "affine" / "ope" / "igpf" / "0" / "A.csv"
    path.parent.mkdir(parents=True)
    rows = ["1,2,1,0.1,0,-0.2,0,6,50,,,1\n", "1,3,3,-0.3,0,0.4,0,8,70,,,0.5\n"]
    hidden = "1,4,99,9,9,9,9,99,1,,,0.4\n"
    path.write_text(AFFINE_HEADER + "".join(rows) + hidden)
    (row,) = affine_table(read_results(folder, None)).rows
    assert row["frames"] == 2
    assert row["mean_corner_error_px"] == 2
    assert row["median_rotation_error_rad"] == pytest.approx(0.3)
    assert row["mean_scale_error"] == pytest.approx(0.2)
    assert row["mean_nees"] == 7
    assert row["mean_ancestor_count"] is None
    assert "affine.csv" in {found.name for found in write_report(folder).paths}


def test_boxes_that_do_not_fit_the_truth_are_refused(folder):
    path = folder / "boxes" / "ope" / "gpf" / "0" / "A.csv"
    whole = path.read_text()
    path.write_text("".join(whole.splitlines(keepends=True)[:-1]))
    with pytest.raises(ValueError, match=r"run 1 does not end with frame 8 of the ground truth"):
        read_results(folder, None)
    path.write_text(whole)
    write(folder, "ope", "gpf", "Elsewhere", np.ones((3, 4)))
    with pytest.raises(ValueError, match="no sequence 'Elsewhere' in"):
        read_results(folder, None)


def test_a_folder_without_results_is_refused(tmp_path):
    with pytest.raises(ValueError, match="holds no results of `beltgrasp otb run`"):
        read_results(tmp_path, None)
    with pytest.raises(ValueError, match="holds no finished boxes yet"):
        read_results(tmp_path, tmp_path)
