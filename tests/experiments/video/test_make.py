import hashlib
from dataclasses import replace

import numpy as np
import pytest

from experiments.video import make
from experiments.video.clips import RECIPES, Recipe
from experiments.video.commands import Make
from experiments.video.sequences import GROUND_TRUTH, VideoSequence, load_sequence
from sim.video.clip import Actor, Clip, Moves
from sim.video.motion import Wave

CLIP = Clip(
    "a panel drifts",
    Actor((64, 48), moves=Moves((Wave(20.0, (4.0, 8.0)),))),
    frame_count=3,
)
TINY = {"Drift": Recipe(("FM", "MB"), CLIP), "Stay": Recipe(("IV",), replace(CLIP, frame_count=2))}


@pytest.fixture
def tiny(monkeypatch):
    monkeypatch.setattr(make, "RECIPES", TINY)


def load(root, name) -> VideoSequence:
    return load_sequence(name, root / name / GROUND_TRUTH)


def contents(folder):
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in files
    }


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Both tiny sequences, made once; do not write into the folder."""
    out = tmp_path_factory.mktemp("made")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(make, "RECIPES", TINY)
        make.make_benchmark(out)
    return out


def test_a_sequence_can_be_read_as_any_other_of_the_benchmark(made):
    sequence = load(made, "Drift")
    assert len(sequence) == 3
    assert sequence.attributes == ("FM", "MB")
    assert sequence.image(0).shape == (240, 320, 3)
    assert sequence.boxes[0] == pytest.approx([129.0, 97.0, 64.0, 48.0])


def test_the_first_warp_maps_the_template_onto_the_first_box(made):
    path = made / "Drift" / "affine.csv"
    assert path.read_text().splitlines()[0] == "frame,a11,a12,a21,a22,x,y,visible"
    rows = np.loadtxt(path, delimiter=",", skiprows=1)
    x, y, w, h = load(made, "Drift").boxes[0] - [1, 1, 0, 0]
    unit = np.sqrt(w * h)
    assert rows[:, 0].tolist() == [1, 2, 3]
    expected = [unit, 0, 0, unit, x + (w - 1) / 2, y + (h - 1) / 2]
    assert rows[0, 1:7] == pytest.approx(expected, abs=1e-3)
    assert (rows[:, 7] > 0.98).all()


def test_the_corners_bound_the_box(made):
    header, *_ = (made / "Drift" / "corners.csv").read_text().splitlines()
    assert header == "frame,x1,y1,x2,y2,x3,y3,x4,y4"
    rows = np.loadtxt(made / "Drift" / "corners.csv", delimiter=",", skiprows=1)
    corners = rows[:, 1:].reshape(-1, 4, 2)
    boxes = load(made, "Drift").boxes
    assert np.allclose(corners.min(axis=1) + 1.5, boxes[:, :2], atol=1e-3)
    assert np.allclose(np.ptp(corners, axis=1), boxes[:, 2:], atol=1e-3)


def test_the_index_names_sequences_seed_and_command(made):
    lines = (made / "sequences.csv").read_text().splitlines()
    assert lines[0].startswith("name,attributes,frames,seed,recipe,beltgrasp,")
    assert [line.split(",")[:4] for line in lines[1:]] == [
        ["Drift", "FM MB", "3", "0"],
        ["Stay", "IV", "2", "0"],
    ]
    readme = (made / "README.md").read_text()
    assert "beltgrasp otb make --out DIR --seed 0\n" in readme
    assert "| Stay | IV | 2 | a panel drifts |" in readme


def test_a_sequence_does_not_depend_on_the_others(tiny, made, tmp_path):
    assert make.make_benchmark(tmp_path, ["Stay"]) == ["Stay"]
    assert contents(tmp_path / "Stay") == contents(made / "Stay")
    assert "--only Stay" in (tmp_path / "README.md").read_text()


def test_what_is_there_is_not_made_again_and_half_of_one_is(tiny, made, tmp_path, monkeypatch):
    make.make_benchmark(tmp_path, ["IV"])
    stamp = (tmp_path / "Stay" / "affine.csv").stat().st_mtime_ns
    half = tmp_path / ".Drift.part" / "img"
    half.mkdir(parents=True)
    (half / "0009.jpg").touch()
    assert make.make_benchmark(tmp_path) == ["Drift", "Stay"]
    assert (tmp_path / "Stay" / "affine.csv").stat().st_mtime_ns == stamp
    assert contents(tmp_path) == contents(made)


def test_an_interrupted_sequence_leaves_no_folder(tiny, tmp_path, monkeypatch):
    def breaks(clip, rng):
        raise KeyboardInterrupt
        yield

    monkeypatch.setattr(make, "shoot", breaks)
    with pytest.raises(KeyboardInterrupt):
        make.make_benchmark(tmp_path, ["Stay"])
    assert not (tmp_path / "Stay").exists()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"seed": 1}, "Drift was made with seed 0, not 1; choose another folder"),
        ({"names": ["Nope"]}, "no sequence or attribute 'Nope'; sequences: Drift, Stay"),
        ({"workers": 0}, "workers must be 1 or greater, got 0"),
        ({"seed": -1}, "seed must be 0 or greater, got -1"),
    ],
)
def test_what_cannot_be_made_is_refused_in_one_line(tiny, made, change, message):
    with pytest.raises(ValueError, match=message):
        make.make_benchmark(made, **change)


def test_a_foreign_folder_and_another_recipe_are_not_overwritten(tiny, tmp_path, monkeypatch):
    (tmp_path / "Stay").mkdir()
    with pytest.raises(ValueError, match="Stay was not made by this command"):
        make.make_benchmark(tmp_path, ["Stay"])
    (tmp_path / "Stay").rmdir()
    make.make_benchmark(tmp_path, ["Stay"])
    changed = {"Stay": Recipe(("IV",), replace(CLIP, noise_levels=9.0, frame_count=2))}
    monkeypatch.setattr(make, "RECIPES", changed)
    with pytest.raises(ValueError, match="Stay was made with recipe"):
        make.make_benchmark(tmp_path)


def test_the_command_makes_what_it_is_asked_for(tiny, tmp_path, capsys):
    assert Make(out=tmp_path, only=("Stay,",), workers=1).run() == 0
    assert capsys.readouterr().out == f"1 sequence: {tmp_path}\n"
    with pytest.raises(ValueError, match="attributes: IV, SV"):
        Make(out=tmp_path, only=("XX",), workers=1).run()


@pytest.mark.slow
def test_two_processes_write_the_same_files_as_one(tmp_path):
    names = ["Speck", "Exit"]
    assert set(names) <= set(RECIPES)
    for workers in (1, 2):
        make.make_benchmark(tmp_path / str(workers), names, seed=3, workers=workers)
    assert contents(tmp_path / "1") == contents(tmp_path / "2")
