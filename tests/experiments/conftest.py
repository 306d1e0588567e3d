"""The toy study and made-up rows; `toy_study` and `toy_trial` are importable from this folder."""

import shutil
import sys
import types
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

import toy_study
import toy_trial


@pytest.fixture(scope="session", autouse=True)
def quick_spawn():
    """Spawned workers import the main module again, and that of pytest takes long."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "__main__", types.ModuleType("__main__"))
        yield


@pytest.fixture(scope="session")
def finished(tmp_path_factory):
    """Folder of an unbroken run of the toy by one worker; not to be written to."""
    folder = tmp_path_factory.mktemp("finished") / "toy"
    toy_study.run_toy(folder, workers=1)
    return folder


@pytest.fixture
def unbroken(finished):
    """Bytes of what an unbroken run by one worker leaves."""
    return toy_study.left_by(finished)


@pytest.fixture
def copy(finished, tmp_path):
    """A copy of the unbroken run to do harm to."""
    return shutil.copytree(finished, tmp_path / "copy")


@pytest.fixture(scope="session")
def long_unbroken(tmp_path_factory):
    """Bytes of what an unbroken long run leaves."""
    folder = tmp_path_factory.mktemp("finished") / "long"
    toy_study.run_toy(folder, toy_study.LONG)
    return toy_study.left_by(folder)


@pytest.fixture
def toy_environment():
    """Environment of a new process that can import the toy and the project."""
    return toy_study.environment()


@pytest.fixture
def make_row():
    """Maker of rows whose numbers depend on the configuration alone."""
    return toy_trial.make_row
