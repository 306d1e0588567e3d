"""The toy trial and its sweeps; `toy_trial` and `toy_sweep` are importable from this folder."""

import shutil
import sys
import types
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

import toy_sweep
import toy_trial


@pytest.fixture(scope="session", autouse=True)
def quick_spawn():
    """Spawned workers import the main module again, and that of pytest takes long."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "__main__", types.ModuleType("__main__"))
        yield


@pytest.fixture
def toy():
    """Import path of the toy trial."""
    return toy_sweep.TOY


@pytest.fixture(scope="session")
def finished(tmp_path_factory):
    """Folder of an unbroken sweep by one worker; not to be written to."""
    return _sweep(toy_sweep.PRESET, tmp_path_factory.mktemp("finished") / "toy")


@pytest.fixture
def unbroken(finished):
    """Bytes of the rows and curves of an unbroken sweep by one worker."""
    return toy_sweep.left_by(finished)


@pytest.fixture
def copy(finished, tmp_path):
    """A copy of the unbroken sweep to do harm to."""
    return shutil.copytree(finished, tmp_path / "copy")


@pytest.fixture(scope="session")
def long_unbroken(tmp_path_factory):
    """Bytes of the rows and curves of an unbroken long sweep by one worker."""
    folder = _sweep(toy_sweep.LONG_PRESET, tmp_path_factory.mktemp("finished") / "long")
    return toy_sweep.left_by(folder)


def _sweep(preset, folder):
    toy_sweep.run_sweep(preset, folder, toy_sweep.LocalWorkers(1), run_trial=toy_sweep.TOY)
    return folder


@pytest.fixture
def toy_environment():
    """Environment of a new process that can import the toy trial and the project."""
    return toy_sweep.environment()


@pytest.fixture
def make_row():
    """Maker of rows whose numbers depend on the configuration alone."""
    return toy_trial.make_row
