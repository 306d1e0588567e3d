import json
import shutil

import cv2
import pytest
from experiments.video.contestants import CONTESTANTS
from experiments.video.jobs import plan
from experiments.video.run import OtbRun, run_otb

from experiments.video import run
from experiments.video.sequences import find_sequences, load_sequence
from experiments.video.tracking import Tracking


def files(folder):
    return {
        path.relative_to(folder): path.read_bytes()
        for part in ("boxes", "affine")
        for path in sorted((folder / part).rglob("*"))
        if path.is_file()
    }


@pytest.fixture(scope="module")
def finished(tmp_path_factory, paint):
    """A folder of sequences and the results of one worker on it; not to be written to."""
    folder = tmp_path_factory.mktemp("finished")
    paint(folder / "root" / "One")
    paint(folder / "root" / "Two", seed=1)
    request = OtbRun(folder / "root", ("pf",), ("ope", "tre"), seed_count=2)
    assert run_otb(request, folder / "out", 1) == (8, 0)
    return request, folder / "out"


def test_each_job_has_its_file_with_a_line_for_each_frame(finished):
    _, out = finished
    places = {path.as_posix() for path in files(out)}
    assert len(places) == 8
    assert {"boxes/ope/pf/0/One.csv", "boxes/tre/pf/1/Two.csv"} < places
    lines = (out / "boxes/ope/pf/0/One.csv").read_text().splitlines()
    assert lines[:2] == ["run,frame,x,y,w,h", "1,1,11.0000,13.0000,20.0000,16.0000"]
    assert [line.split(",")[:2] for line in lines[1:]] == [["1", str(k)] for k in range(1, 9)]


def test_seeds_sequences_and_protocols_have_draws_of_their_own(finished):
    _, out = finished
    found = files(out / "boxes")
    assert len(set(found.values())) == len(found)


def copied(finished, folder):
    """A copy of the finished folder that knows where the sequences are."""
    request, out = finished
    copy = shutil.copytree(out, folder)
    content = json.loads((copy / "manifest.json").read_text())
    (copy / "manifest.json").write_text(json.dumps(content | {"root": str(request.root)}))
    return request, out, copy


def test_two_workers_and_a_resumed_run_leave_the_same_bytes(finished, tmp_path):
    request, out, copy = copied(finished, tmp_path / "copy")
    for path in (copy / "boxes" / "ope").rglob("*.csv"):
        path.unlink()
    (copy / "boxes" / "tre" / "pf" / "0" / ".One.csv.new").write_text("torn")
    assert run_otb(request, copy, 2) == (8, 0)
    (copy / "boxes" / "tre" / "pf" / "0" / ".One.csv.new").unlink(missing_ok=True)
    assert files(copy) == files(out)
    assert len(json.loads((copy / "manifest.json").read_text())["sessions"]) == 2


def test_results_of_other_sequences_or_settings_do_not_mix(finished, tmp_path):
    request, _, copy = copied(finished, tmp_path / "copy")
    content = json.loads((copy / "manifest.json").read_text())
    for change, message in (
        ({"root": "../elsewhere"}, "holds results of the sequences in .*/elsewhere"),
        ({"settings": {"pf": "of yesterday"}}, "holds results of other settings of 'pf'"),
    ):
        (copy / "manifest.json").write_text(json.dumps(content | change))
        with pytest.raises(ValueError, match=message):
            run_otb(request, copy, 1)
    (copy / "manifest.json").unlink()
    with pytest.raises(ValueError, match=r"holds boxes without their manifest.json"):
        run_otb(request, copy, 1)


def test_ctrl_c_keeps_what_is_finished(finished, tmp_path, monkeypatch):
    request, out = finished

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(run, "progress_bar", lambda *_: Interrupting())
    with pytest.raises(KeyboardInterrupt):
        run_otb(request, tmp_path / "out", 1)
    kept = files(tmp_path / "out")
    assert 1 <= len(kept) < 8
    assert all(files(out)[path] == data for path, data in kept.items())


class Interrupting:
    """A progress bar at which the user presses Ctrl-C."""

    def __enter__(self):
        return self

    def __exit__(self, *_):
        return None

    def set_postfix_str(self, *_, **__):
        raise KeyboardInterrupt


def test_the_manifest_tells_where_the_sequences_are_as_the_user_did(root, tmp_path):
    """By a link, where a disk of data is linked into the working folder."""
    (tmp_path / "linked").symlink_to(root)
    out = tmp_path / "out"
    run_otb(OtbRun(tmp_path / "linked", ("pf",), ("ope",)), out, 1)
    assert json.loads((out / "manifest.json").read_text())["root"] == "../linked"
    run_otb(OtbRun(root, ("pf",), ("ope",)), out, 1)


def complaints(root, out, capsys, **kwargs):
    """Lines on stderr, and the numbers of finished jobs and of things that went wrong."""
    numbers = run_otb(OtbRun(root, ("pf",), ("ope",), **kwargs), out, 1)
    lines = [line for line in capsys.readouterr().err.splitlines() if "error: " in line]
    return [line.split("error: ")[1] for line in lines], numbers


def test_faulty_sequences_are_told_once_each_and_the_others_run(root, tmp_path, capsys):
    (root / "Bare" / "img").mkdir(parents=True)
    path = root / "Two" / "groundtruth_rect.txt"
    path.write_text("0,0,0,0\n" + path.read_text().partition("\n")[2])
    wanted = (("One", "--only"), ("Bare", "--only"), ("Two", "--only"), ("XX", "names.txt, line 3"))
    lines, numbers = complaints(root, tmp_path / "out", capsys, wanted=wanted, seed_count=2)
    assert numbers == (2, 3)
    assert lines[0].startswith("names.txt, line 3: no sequence or attribute 'XX'")
    assert lines[1].endswith("Bare/groundtruth_rect.txt: No such file or directory")
    assert "Two/groundtruth_rect.txt, line 1: the box 0,0,0,0 that ope starts" in lines[2]
    assert "affine/ope/pf/1/One.csv" in {p.as_posix() for p in files(tmp_path / "out")}


def test_a_damaged_image_ends_the_sequence_and_leaves_no_file(root, tmp_path, capsys):
    (root / "One" / "img" / "0006.png").write_text("no image")
    lines, numbers = complaints(root, tmp_path / "out", capsys, seed_count=2)
    assert numbers == (2, 1)
    assert lines[0].endswith("One/img/0006.png: not a readable image")
    assert {path.stem for path in files(tmp_path / "out")} == {"Two"}


def job(root, name, tracker="pf"):
    sequence = load_sequence(name, find_sequences(root)[name])
    ((found,), ()) = plan([sequence], [tracker], ["ope"], 1)
    return found


def test_a_start_on_a_constant_patch_is_refused_with_the_reason(root, tmp_path):
    for path in (root / "Two" / "img").iterdir():
        cv2.imwrite(str(path), cv2.imread(str(path)) * 0 + 90)
    done = Tracking(tmp_path)(job(root, "Two"))
    assert "Two/groundtruth_rect.txt, line 1: pf refuses to start" in done.complaint
    assert "texture" in done.complaint


def test_a_crash_is_told_in_a_line_and_its_traceback_is_kept(root, tmp_path, monkeypatch):
    def crash(rng):
        raise ZeroDivisionError("on purpose")

    found = job(root, "Two")
    broken = type(CONTESTANTS["pf"])("", crash)
    monkeypatch.setitem(CONTESTANTS, "pf", broken)
    done = Tracking(tmp_path)(found)
    assert "Two: pf crashed (ZeroDivisionError: on purpose); see" in done.complaint
    assert "Traceback" in found.error_path(tmp_path).read_text()


def test_trackers_without_chance_run_once(root, monkeypatch):
    steady = type(CONTESTANTS["pf"])("", CONTESTANTS["pf"].make, is_random=False)
    monkeypatch.setitem(CONTESTANTS, "steady", steady)
    sequence = load_sequence("One", find_sequences(root)["One"])
    jobs, _ = plan([sequence], ["pf", "steady"], ["ope", "sre"], 3)
    seeds = [(j.protocol, j.tracker, j.seed) for j in jobs]
    assert seeds == [
        (p, *rest)
        for p in ("ope", "sre")
        for rest in (("pf", 0), ("pf", 1), ("pf", 2), ("steady", 0))
    ]
    assert [j.frame_count for j in jobs] == [8] * 4 + [12 * 8] * 4


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"trackers": ("pff",)}, "tracker must be one of .*; got 'pff'; did you mean"),
        ({"trackers": ()}, "trackers must name one"),
        ({"protocols": ("opo",)}, "protocol must be one of ope, tre, sre; got 'opo'"),
        ({"seed_count": 0}, "seeds must be 1 or greater, got 0"),
    ],
)
def test_what_cannot_be_run_is_refused(tmp_path, change, message):
    settings = {"root": tmp_path, "trackers": ("pf",), "protocols": ("ope",)}
    with pytest.raises(ValueError, match=message):
        OtbRun(**(settings | change))
