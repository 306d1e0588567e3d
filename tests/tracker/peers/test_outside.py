"""Trackers from outside: found by import path, taken for what they return, told what is wrong."""

from pathlib import Path

import numpy as np
import pytest

from tracker.belt.registry import get_tracker_config
from tracker.peers.outside import get_box_finder, is_outside, source_of

EXAMPLES = Path(__file__).parents[3] / "docs" / "examples"
RNG = np.random.default_rng(0)


@pytest.fixture
def shelf(tmp_path, monkeypatch):
    """A working folder in which a module of a given name and text is put."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", ["/nowhere"])
    monkeypatch.setattr("sys.modules", dict(__import__("sys").modules))

    def put(name: str, text: str) -> None:
        (tmp_path / f"{name}.py").write_text(text)

    return put


def moving_picture(step: int) -> np.ndarray:
    noise = np.random.default_rng(4).integers(0, 255, (30, 40), dtype=np.uint8)
    image = np.full((120, 160, 3), 90, np.uint8)
    image[40 : 40 + 60, 20 + 3 * step : 20 + 3 * step + 80] = np.kron(noise, np.ones((2, 2)))[
        ..., None
    ]
    return image


def test_the_example_of_the_guide_follows_a_moving_picture(monkeypatch):
    monkeypatch.chdir(EXAMPLES)
    tracker = get_box_finder("corner_flow:CornerFlow").make(RNG)
    tracker.start(moving_picture(0), np.array([20.0, 40.0, 80.0, 60.0]))
    for step in range(1, 6):
        box = tracker.update(moving_picture(step)).box
    assert box == pytest.approx([35.0, 40.0, 80.0, 60.0], abs=0.2)
    assert tracker.is_found


def test_the_example_is_short():
    assert len((EXAMPLES / "corner_flow.py").read_text().splitlines()) < 40


def test_names_with_a_colon_are_import_paths():
    assert is_outside("a.b:C") and not is_outside("kcf-0.1")


def test_a_found_class_is_a_tracker_of_the_loop(monkeypatch):
    monkeypatch.chdir(EXAMPLES)
    assert get_tracker_config("corner_flow:CornerFlow").baseline == "corner_flow:CornerFlow"
    assert "class CornerFlow" in source_of("corner_flow:CornerFlow")


@pytest.mark.parametrize(
    ("text", "name", "message"),
    [
        ("", "absent:It", "tracker 'absent:It': No module named 'absent'"),
        ("import absent", "mine:It", "tracker 'mine:It': No module named 'absent'"),
        ("", "mine:It", "tracker 'mine:It': mine has no class 'It'"),
        ("It = 3", "mine:It", "mine has no class 'It'"),
        ("class It:\n    def start(self): ...", "mine:It", "It has no method 'find'"),
    ],
)
def test_what_is_wrong_with_a_path_is_told(shelf, text, name, message):
    shelf("mine", text)
    with pytest.raises(ValueError, match=message):
        get_box_finder(name)


def test_what_is_no_box_is_told(shelf):
    shelf(
        "odd",
        "class It:\n"
        "    def __init__(self, rng): ...\n"
        "    def start(self, image, box): ...\n"
        "    def find(self, image): return 1, 2, 3\n",
    )
    tracker = get_box_finder("odd:It").make(RNG)
    tracker.start(moving_picture(0), np.array([20.0, 40.0, 80.0, 60.0]))
    with pytest.raises(
        ValueError, match=r"find\(\) must return four numbers or None, got \(1, 2, 3\)"
    ):
        tracker.update(moving_picture(1))
