"""Trackers from outside: found by import path, taken for what they return, told what is wrong."""

import sys
from pathlib import Path

import numpy as np
import pytest

from tracker.belt.registry import get_tracker_config
from tracker.peers.outside import get_box_finder, is_outside, outside_source

EXAMPLES = Path(__file__).parents[3] / "docs" / "examples"
RNG = np.random.default_rng(0)


@pytest.fixture
def shelf(tmp_path, monkeypatch):
    """A working folder in which a module of a given name and text is put."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", ["/nowhere"])
    monkeypatch.setattr("sys.modules", dict(__import__("sys").modules))

    def put(name: str, text: str) -> None:
        path = tmp_path / f"{name.replace('.', '/')}.py"
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)

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
    assert "class CornerFlow" in outside_source("corner_flow:CornerFlow")


TRACKER = """
import json
import numpy as np
from helper import REACH
class It:
    reach = REACH
    def __init__(self, rng): ...
    def start(self, image, box): ...
    def find(self, image): ...
"""


def test_the_source_of_a_tracker_covers_what_it_imports_from_its_folder(shelf):
    shelf("deeper", "STEP = 1")
    shelf("helper", "import tracker.affine.aff2\nfrom deeper import STEP\nREACH = 2 * STEP")
    shelf("mine", TRACKER)
    shelf("unused", "NOTHING = 0")
    text = outside_source("mine:It")
    assert text.index("STEP = 1") < text.index("REACH = 2") < text.index("class It")
    assert "NOTHING" not in text and "def perturb" not in text and "JSONDecoder" not in text
    shelf("deeper", "STEP = 100")
    assert outside_source("mine:It") == text.replace("STEP = 1", "STEP = 100")


def test_the_source_of_a_tracker_in_a_package_covers_relative_imports(shelf):
    shelf("pack.__init__", "")
    shelf("pack.mine", TRACKER.replace("helper", ".helper"))
    shelf("pack.helper", "REACH = 5")
    assert "REACH = 5" in outside_source("pack.mine:It")


def test_other_installed_packages_are_no_source(tmp_path, monkeypatch, shelf):
    installed = tmp_path / "site-packages"
    installed.mkdir()
    for name, text in [("mine", TRACKER), ("helper", "REACH = 5")]:
        (installed / f"{name}.py").write_text(text)
    monkeypatch.setattr("sys.path", [str(installed)])
    text = outside_source("mine:It")
    assert "class It" in text and "REACH = 5" not in text


def test_an_edit_is_noticed_in_the_same_process(shelf):
    shelf("helper", "REACH = 2")
    shelf("mine", TRACKER)
    reach = []
    for number in ("2", "300"):
        shelf("helper", f"REACH = {number}")
        outside_source("mine:It")
        reach.append(sys.modules["mine"].It.reach)
    assert reach == [2, 300]


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
