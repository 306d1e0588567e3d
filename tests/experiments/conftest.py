import os
import sys
import types
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent


@pytest.fixture(scope="session", autouse=True)
def quick_spawn():
    """Spawned workers import the main module again, and that of pytest takes long."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "__main__", types.ModuleType("__main__"))
        yield


@pytest.fixture
def toy(monkeypatch):
    """Import path of the toy trial, importable here and in spawned processes."""
    monkeypatch.syspath_prepend(str(HERE))
    return "toy_trial:run_trial"


@pytest.fixture
def toy_environment():
    """Environment of a new process that can import the toy trial and the project."""
    paths = [str(HERE), str(HERE.parent.parent), *filter(None, [os.environ.get("PYTHONPATH")])]
    return dict(os.environ, PYTHONPATH=os.pathsep.join(paths), PYTHON=sys.executable)


@pytest.fixture
def make_row(monkeypatch):
    """Maker of rows whose numbers depend on the configuration alone."""
    monkeypatch.syspath_prepend(str(HERE))
    import toy_trial

    return toy_trial.make_row
