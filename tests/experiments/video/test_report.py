import shutil

import pytest
from toy_study import left_by

from experiments.study.folder import ResultsFolder, read_results
from experiments.study.manifest import Request, claim
from experiments.study.study import Result
from experiments.video.job import AFFINE, HITS, VideoJob, VideoRow
from experiments.video.report import write_report
from experiments.video.results import OtbResults
from experiments.video.scores import sequence_curves
from experiments.video.study import get_study
from experiments.video.tables import affine_table, score_table

STUDY = get_study("video/otb")
ATTRIBUTES = {"A": "SV", "B": "SV FM"}


def result_of(job, boxes, true, affine=""):
    """What a tracker leaves that gave these boxes."""
    curves = sequence_curves([boxes], [true])
    key = f"{job.protocol},{job.sequence},{job.tracker},{job.seed}"
    hits = ",".join(map(str, curves.hits(len(true))))
    row = VideoRow(
        *(job.protocol, job.sequence, job.tracker, job.seed, "done", 1, len(true)),
        distance_precision=curves.distance_precision,
        overlap_score=curves.overlap_score,
        attributes=ATTRIBUTES[job.sequence],
    )
    lines = [f"1,{k},{','.join(map(str, box))}\n" for k, box in enumerate(boxes, start=1)]
    return Result(
        (row,),
        curves={HITS: f"{key},{hits}\n", AFFINE: "".join(f"{key},{a}\n" for a in affine.split())},
        files={job.boxes_path: "run,frame,x,y,w,h\n" + "".join(lines)},
    )


AFFINE_OF_A = """1,2,1,0.1,0,-0.2,0,6,50,,,1
1,3,3,-0.3,0,0.4,0,8,70,,,0.5
1,4,99,9,9,9,9,99,1,,,0.4"""


def write_folder(tmp_path, paint, left_out=(), affine=""):
    """gpf misses from frame 5 of 8 on, igpf never on A and always on B, seed 1 is like gpf."""
    root, out = tmp_path / "root", tmp_path / "out"
    selection = {"root": str(root), "protocols": ["ope", "tre"], "trackers": ["igpf", "gpf"]}
    selection |= {"sequences": ["A", "B"], "seeds": [0, 1]}
    truths = {name: paint(root / name, seed=number) for number, name in enumerate("AB")}
    jobs = STUDY.jobs(selection)
    out.mkdir()
    claim(out, STUDY, Request.of(STUDY, selection, None), 1)
    folder = ResultsFolder(out, STUDY, jobs)
    for name, true in truths.items():
        half, none = true.copy(), true.copy()
        half[4:, 0] += 100
        none[1:, 0] += 100
        best = true if name == "A" else none
        for protocol, tracker, seed, boxes in (
            ("ope", "gpf", 0, half),
            ("ope", "igpf", 0, best),
            ("ope", "igpf", 1, half),
            *([("tre", "igpf", 0, true)] if name == "A" else []),
        ):
            job = VideoJob(protocol, name, tracker, seed, str(root))
            if (protocol, tracker, name) not in left_out:
                warps = affine if (protocol, tracker, name, seed) == ("ope", "igpf", "A", 0) else ""
                folder.add(job, result_of(job, boxes, true, warps))
    folder.close()
    return out


@pytest.fixture
def folder(tmp_path, paint):
    """See `write_folder`."""
    return write_folder(tmp_path, paint)


def collect(folder):
    return OtbResults.collect(read_results(folder, STUDY))


def report_on(folder):
    return write_report(read_results(folder, STUDY))


@pytest.fixture
def without_figures(monkeypatch):
    """Drawing takes long."""
    monkeypatch.setattr("experiments.video.figures.write_figures", lambda *_: [])


def test_means_are_over_seeds_then_sequences_and_gains_over_gpf(folder):
    """gpf: 4 of 8 frames on both. igpf: (8/8 + 4/8)/2 on A, (1/8 + 4/8)/2 on B: 0.53125."""
    table = score_table(collect(folder), "dp")
    igpf, gpf = table.rows
    assert (igpf["tracker"], igpf["ope"]) == ("igpf", pytest.approx(0.53125))
    assert gpf["ope"] == 0.5
    assert gpf["ope_gain"] is None
    assert igpf["ope_gain"] == pytest.approx(0.0625)
    assert igpf["ope_gain_low"] == pytest.approx(0.3125 / 0.5 - 1)
    assert igpf["ope_gain_high"] == pytest.approx(0.75 / 0.5 - 1)
    assert (igpf["tre"], gpf["tre"]) == (1.0, None)
    overlap = score_table(collect(folder), "os")
    assert overlap.rows[1]["ope"] == pytest.approx(0.5 * 20 / 21)
    assert score_table(collect(folder), "dp").rows == table.rows


def test_means_are_over_sequences_that_all_have_finished(tmp_path, paint, without_figures):
    folder = write_folder(tmp_path, paint, left_out={("ope", "gpf", "B")})
    results = collect(folder)
    assert results.sequences("ope") == ["A"]
    assert results.left_out("ope") == ["B"]
    assert results.sequences("ope", "FM") == []
    assert "ope: left out, as not every tracker has finished them: B" in report_on(folder).text


def test_a_report_has_tables_and_figures_and_repeats(folder):
    report = report_on(folder)
    names = {path.name for path in report.paths}
    assert {"precision.csv", "overlap.md", "sequences.csv", "attributes.csv"} < names
    assert {"curves_ope.png", "curves_tre.pdf", "success_by_attribute.png"} < names
    assert "boxes_ope.png" in names
    assert "affine.csv" not in names
    first = {path: path.read_bytes() for path in report.paths}
    assert {path: path.read_bytes() for path in report_on(folder).paths} == first
    lines = (folder / "tables" / "sequences.csv").read_text().splitlines()
    assert lines[:2] == ["protocol,sequence,tracker,seeds,dp,os", "ope,A,igpf,2,0.75,0.714285714"]
    attributes = (folder / "tables" / "attributes.md").read_text()
    assert "| FM | 1 | igpf | 0.312 | 0.298 |" in attributes


def test_a_report_needs_no_images(folder, without_figures):
    for path in (folder.parent / "root").glob("*/img/*"):
        path.unlink()
    assert report_on(folder).paths
    shutil.rmtree(folder.parent / "root" / "A")
    assert report_on(folder).paths


def test_affine_errors_are_over_visible_frames(tmp_path, paint, without_figures):
    folder = write_folder(tmp_path, paint, affine=AFFINE_OF_A)
    (row,) = affine_table(collect(folder)).rows
    assert row["frames"] == 2
    assert row["mean_corner_error_px"] == 2
    assert row["median_rotation_error_rad"] == pytest.approx(0.3)
    assert row["mean_scale_error"] == pytest.approx(0.2)
    assert row["mean_nees"] == 7
    assert row["mean_ancestor_count"] is None
    assert "affine.csv" in {found.name for found in report_on(folder).paths}


def test_a_report_needs_rows_and_curves_alone(folder, tmp_path):
    """Sequences and boxes may be elsewhere, and the report changes no row."""
    shutil.rmtree(folder.parent / "root")
    shutil.rmtree(folder / "boxes")
    before = left_by(folder)
    names = {path.name for path in report_on(folder).paths}
    assert "curves_ope.png" in names and "boxes_ope.png" not in names
    assert left_by(folder) == before
