from dataclasses import replace

import numpy as np
import pytest
from toy_study import ThisProcess, left_by

from experiments import cli, studies
from experiments.study.files import whole_lines
from experiments.study.folder import read_results
from experiments.study.processes import LocalWorkers
from experiments.study.run import run
from experiments.video.clips import RECIPES, Recipe
from experiments.video.sequences import GROUND_TRUTH, VideoSequence, load_sequence
from experiments.video.study import get_study
from sim.video.clip import Actor, Clip, Moves, Wave

CLIP = Clip(
    "a panel drifts",
    Actor((64, 48), moves=Moves((Wave(20.0, (4.0, 8.0)),))),
    frame_count=3,
)
STUDY = get_study("video/sequences")
TINY = {"Drift": Recipe(("FM", "MB"), CLIP), "Stay": Recipe(("IV",), replace(CLIP, frame_count=2))}


def shrink(patch):
    """Leaves two tiny sequences in the benchmark."""
    for name in [*RECIPES]:
        patch.delitem(RECIPES, name)
    for name, recipe in TINY.items():
        patch.setitem(RECIPES, name, recipe)


@pytest.fixture
def tiny(monkeypatch):
    shrink(monkeypatch)


def load(root, name) -> VideoSequence:
    return load_sequence(name, root / name / GROUND_TRUTH)


def make(out, names=("Drift", "Stay"), seed=0):
    """What `beltgrasp otb make` does, in this process."""
    done = run(STUDY, {"names": list(names), "seed": seed}, out, ThisProcess())
    studies.rebuild_report(out)
    return done


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Both tiny sequences, made once; do not write into the folder."""
    out = tmp_path_factory.mktemp("made")
    with pytest.MonkeyPatch.context() as patch:
        shrink(patch)
        make(out)
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
    rows = read_results(made, STUDY).rows
    assert [(row.name, row.attributes, row.frames, row.seed) for row in rows] == [
        ("Drift", "FM MB", 3, 0),
        ("Stay", "IV", 2, 0),
    ]
    assert rows[0].description == "a panel drifts"
    assert rows[0].mujoco_version.startswith("3.")
    lines = [line.strip() for line in whole_lines(made / "README.md")]
    assert any(line.startswith("beltgrasp otb make --out DIR --seed 0") for line in lines)
    assert any("Stay" in line and "a panel drifts" in line for line in lines)
    assert "source.json" not in (made / "README.md").read_text()


def test_a_sequence_does_not_depend_on_the_others(tiny, made, tmp_path):
    make(tmp_path, ["Stay"])
    alone, all_of_them = left_by(tmp_path), left_by(made)
    images = {name: data for name, data in alone.items() if name.startswith("Stay/")}
    assert len(images) == 2 + 4
    assert images == {name: d for name, d in all_of_them.items() if name.startswith("Stay/")}
    assert "--only Stay" in (tmp_path / "README.md").read_text()


def test_what_is_there_is_not_made_again(tiny, made, tmp_path):
    make(tmp_path, ["Stay"])
    stamp = (tmp_path / "Stay" / "affine.csv").stat().st_mtime_ns
    make(tmp_path)
    assert (tmp_path / "Stay" / "affine.csv").stat().st_mtime_ns == stamp
    assert left_by(tmp_path) == left_by(made)


def test_what_breaks_leaves_no_sequence_by_half(tiny, tmp_path, monkeypatch):
    def breaks(clip, rng):
        raise ZeroDivisionError("on purpose")
        yield

    monkeypatch.setattr("experiments.video.make.shoot", breaks)
    done = run(STUDY, {"names": ["Stay"], "seed": 0}, tmp_path, ThisProcess())
    assert done.error_count == 1
    assert not (tmp_path / "Stay").exists()


def test_another_seed_and_another_recipe_are_refused(tiny, tmp_path, monkeypatch):
    make(tmp_path, ["Stay"])
    with pytest.raises(ValueError, match="other settings: seed was 0, is 1; choose another folder"):
        make(tmp_path, seed=1)
    other = Recipe(("IV",), replace(CLIP, noise_levels=9.0, frame_count=2))
    monkeypatch.setitem(RECIPES, "Stay", other)
    with pytest.raises(ValueError, match=r"clip Stay\.clip\.noise_levels was \S+, is 9\.0; choose"):
        make(tmp_path)
    with pytest.raises(ValueError, match="seed must be 0 or greater, got -1"):
        make(tmp_path, seed=-1)


@pytest.mark.slow
def test_the_command_makes_what_it_is_asked_for_with_any_number_of_processes(tmp_path, capsys):
    selection = {"names": ["Speck", "Exit"], "seed": 3}
    run(STUDY, selection, tmp_path / "1", ThisProcess())
    run(STUDY, selection, tmp_path / "2", LocalWorkers(2))
    assert left_by(tmp_path / "1") == left_by(tmp_path / "2")
    words = ["otb", "make", "--only", "Exit", "--seed", "3", "--workers", "1"]
    assert cli.run([*words, "--out", str(tmp_path / "3")]) == 0
    assert f"1 sequence: {tmp_path / '3' / 'rows.csv'}\n" in capsys.readouterr().out
    assert "--only Exit" in (tmp_path / "3" / "README.md").read_text()
    exits = {n: d for n, d in left_by(tmp_path / "3").items() if n.startswith("Exit/")}
    assert exits and exits.items() <= left_by(tmp_path / "1").items()
