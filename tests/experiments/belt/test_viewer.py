"""The viewer's scene is that of the trial."""

import mujoco.viewer
import pytest

from experiments.belt.config import TrialConfig
from experiments.belt.viewer import show


@pytest.mark.parametrize(("motion", "carrier"), [("constant", "conveyor"), ("turntable", "plate")])
def test_the_viewer_shows_what_carries_the_object(monkeypatch, motion, carrier):
    launched = []
    monkeypatch.setattr(mujoco.viewer, "launch", lambda model, data: launched.append((model, data)))
    show(TrialConfig(motion=motion, seed=3))
    ((model, data),) = launched
    names = [model.geom(i).name for i in range(model.ngeom)]
    assert any(carrier in name for name in names)
    assert data.body("box/").xpos[2] == pytest.approx(0.04)
