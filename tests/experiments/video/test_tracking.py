"""Trackers on sequences as a study: what a job leaves, which jobs there are, and what is faulty."""

import cv2
import pytest
from toy_study import ThisProcess

from experiments.study.folder import read_results
from experiments.study.manifest import Manifest, jobs_of
from experiments.study.run import Work, run
from experiments.video.commands import Run
from experiments.video.job import AFFINE, HITS, VideoJob
from experiments.video.sequences import SequenceError
from experiments.video.study import get_study
from experiments.video.trackers import VIDEO_TRACKERS, VideoTracker
from experiments.video.tracking import run_jobs

STUDY = get_study("video/otb")


def selection(root, **changes):
    names = {"trackers": ["pf"], "protocols": ["ope", "tre"], "sequences": ["One", "Two"]}
    return {"root": str(root), "seeds": [0, 1]} | names | changes


@pytest.fixture(scope="module")
def finished(tmp_path_factory, paint):
    """The results of two sequences; not to be written to."""
    folder = tmp_path_factory.mktemp("finished")
    paint(folder / "root" / "One")
    paint(folder / "root" / "Two", seed=1)
    run(STUDY, selection(folder / "root"), folder / "out", ThisProcess())
    return folder / "out"


def boxes(out):
    return {p.relative_to(out).as_posix(): p.read_bytes() for p in out.rglob("boxes/*/*/*/*.csv")}


def test_each_job_has_a_row_and_a_file_with_a_line_for_each_frame(finished):
    found = boxes(finished)
    assert len(found) == len(read_results(finished, STUDY).rows) == 8
    assert {"boxes/ope/pf/0/One.csv", "boxes/tre/pf/1/Two.csv"} < set(found)
    lines = found["boxes/ope/pf/0/One.csv"].decode().splitlines()
    assert lines[:2] == ["run,frame,x,y,w,h", "1,1,11.0000,13.0000,20.0000,16.0000"]
    assert [line.split(",")[:2] for line in lines[1:]] == [["1", str(k)] for k in range(1, 9)]


def test_seeds_sequences_and_protocols_have_draws_of_their_own(finished):
    found = boxes(finished)
    assert len(set(found.values())) == len(found)


def test_a_row_counts_runs_and_frames(root):
    ope, sre = run_jobs([VideoJob(name, "One", "pf", 0, str(root)) for name in ("ope", "sre")])
    counts = [(r.rows[0].run_count, r.rows[0].frame_count) for r in (ope, sre)]
    assert counts == [(1, 8), (12, 12 * 8)]
    (row,) = ope.rows
    assert row.attributes == "SV FM"
    assert 0.0 <= row.overlap_score <= 1.0 and 0.0 <= row.distance_precision <= 1.0
    assert STUDY.is_failure([row]) == (row.overlap_score < 0.5)


def test_errors_of_the_warp_are_kept_where_it_is_known(root):
    one, two = run_jobs([VideoJob("ope", name, "pf", 0, str(root)) for name in ("One", "Two")])
    assert one.curves[AFFINE].startswith("ope,One,pf,0,1,2,")
    assert one.curves[AFFINE].count("\n") == 7
    assert two.curves[AFFINE] == ""
    header = STUDY.curves[HITS].count(",")
    assert [r.curves[HITS].count(",") for r in (one, two)] == [header, header]


def test_trackers_without_chance_run_once(root, monkeypatch):
    known = VIDEO_TRACKERS["pf"]
    monkeypatch.setitem(VIDEO_TRACKERS, "steady", VideoTracker("", known.make, is_random=False))
    asked = selection(root, trackers=["pf", "steady"], protocols=["sre", "ope"], seeds=[0, 1, 2])
    jobs = jobs_of(STUDY, [asked | {"sequences": ["One"]}], None)
    assert [(j.protocol, j.tracker, j.seed) for j in jobs] == [
        (p, *rest)
        for p in ("ope", "sre")
        for rest in (("pf", 0), ("pf", 1), ("pf", 2), ("steady", 0))
    ]


def test_other_images_are_other_settings(root, tmp_path):
    """The same sequences at another place are not."""
    out = tmp_path / "out"
    run(STUDY, selection(root), out, ThisProcess())
    (tmp_path / "linked").symlink_to(root)
    run(STUDY, selection(tmp_path / "linked"), out, ThisProcess())
    assert len(Manifest.read(out).selections) == 1
    path = root / "Two" / "groundtruth_rect.txt"
    path.write_text(path.read_text().replace("11,13,20,16", "11,13,20,17"))
    with pytest.raises(ValueError, match=r"other settings: sequence Two was \w+, is \w+; choose"):
        run(STUDY, selection(root), out, ThisProcess())


def test_faulty_sequences_are_told_once_each_and_the_others_run(root, tmp_path, capsys):
    (root / "Bare" / "img").mkdir(parents=True)
    path = root / "Two" / "groundtruth_rect.txt"
    path.write_text("0,0,0,0\n" + path.read_text().partition("\n")[2])
    names = tmp_path / "names.txt"
    names.write_text("# mine\n\nXX\n")
    command = Run(
        root=root,
        out=tmp_path / "out",
        trackers=("pf",),
        only=("One,Bare,Two",),
        list=names,
        seeds=2,
        workers=1,
    )
    assert command.run() == 1
    lines = [line.split("error: ")[1] for line in capsys.readouterr().err.splitlines()
             if "error: " in line]  # fmt: skip
    assert len(lines) == 3
    assert lines[0].startswith(f"{names}, line 3: no sequence or attribute 'XX'")
    assert lines[1].endswith("Bare/groundtruth_rect.txt: No such file or directory")
    assert "Two/groundtruth_rect.txt, line 1: the box 0,0,0,0 that ope starts" in lines[2]
    rows = read_results(tmp_path / "out", STUDY).rows
    assert [(row.sequence, row.seed, row.outcome) for row in rows] == [
        ("One", 0, "done"),
        ("One", 1, "done"),
    ]


def test_a_damaged_image_ends_the_sequence_and_leaves_no_boxes(root, tmp_path, capsys):
    (root / "One" / "img" / "0006.png").write_text("no image")
    done = run(STUDY, selection(root, protocols=["ope"]), tmp_path / "out", ThisProcess())
    assert (done.job_count, done.error_count) == (4, 2)
    bad = [row for row in read_results(tmp_path / "out", STUDY).rows if row.outcome == "error"]
    assert {row.sequence for row in bad} == {"One"}
    assert all(row.detail.endswith("One/img/0006.png: not a readable image") for row in bad)
    assert "One/img/0006.png: not a readable image\n" in capsys.readouterr().err
    assert {name.rpartition("/")[2] for name in boxes(tmp_path / "out")} == {"Two.csv"}


def test_a_start_on_a_constant_patch_is_refused_with_the_reason(root):
    for path in (root / "Two" / "img").iterdir():
        cv2.imwrite(str(path), cv2.imread(str(path)) * 0 + 90)
    message = r"Two/groundtruth_rect\.txt, line 1: pf refuses to start.* texture"
    with pytest.raises(SequenceError, match=message):
        run_jobs([VideoJob("ope", "Two", "pf", 0, str(root))])


def test_a_sequence_that_has_gone_is_named(root):
    with pytest.raises(SequenceError, match="holds no sequence 'Three'"):
        run_jobs([VideoJob("ope", "Three", "pf", 0, str(root))])


def test_a_tracker_that_breaks_is_a_row(root, monkeypatch):
    def crash(rng):
        raise ZeroDivisionError("on purpose")

    monkeypatch.setitem(VIDEO_TRACKERS, "pf", VideoTracker("", crash))
    ((_, result),) = Work(STUDY)((VideoJob("ope", "Two", "pf", 0, str(root)),))
    assert "Traceback" in result.error
    (row,) = result.rows
    assert (row.sequence, row.tracker, row.outcome) == ("Two", "pf", "error")
    assert row.overlap_score is None and not STUDY.is_failure([row])
    assert STUDY.score.of(row) is None
