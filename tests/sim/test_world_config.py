"""The one description of a world: what it refuses, what it costs to import, and where it goes."""

import subprocess
import sys
from dataclasses import fields

import pytest

from sim.belt.task_config import TaskConfig
from sim.world_config import WorldConfig

CHANGED = WorldConfig(
    speed_mps=0.5,
    embodiment="ur3-soft",
    camera="kinect",
    condition="blur-1+dark-2",
    object="can",
    motion="turntable",
    delay_s=0.1,
    camera_rate_hz=60.0,
    gripper_delay_s=0.2,
)


def run(code: str) -> None:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_importing_the_description_imports_nothing_heavy():
    run(
        "import sys, sim.world_config; "
        "heavy = {'numpy', 'mujoco', 'dm_control', 'cv2', 'scipy'} & set(sys.modules); "
        "sys.exit(f'imported {heavy}' if heavy else 0)"
    )


def test_without_opengl_every_package_says_what_to_install_and_the_description_still_imports():
    run(
        "import ctypes, importlib, pkgutil\n"
        "def missing(name): raise OSError(f'{name}: cannot open shared object file')\n"
        "ctypes.CDLL = missing\n"
        "import sim, sim.world_config\n"
        "packages = [m.name for m in pkgutil.iter_modules(sim.__path__) if m.ispkg]\n"
        "assert 'belt' in packages\n"
        "for name in packages:\n"
        "    try:\n"
        "        importlib.import_module(f'sim.{name}')\n"
        "    except sim.OffscreenGLError as error:\n"
        "        assert 'apt-get install' in str(error)\n"
        "    else:\n"
        "        raise AssertionError(name)\n"
    )


def test_a_task_takes_every_field_of_its_world():
    assert all(getattr(CHANGED, f.name) != f.default for f in fields(WorldConfig))
    task = TaskConfig.of(CHANGED, has_camera=False)
    assert all(getattr(task, f.name) == getattr(CHANGED, f.name) for f in fields(WorldConfig))
    assert not task.has_camera and task.observes_camera


def test_tasks_share_a_compiled_model_unless_it_differs():
    model = TaskConfig.of(CHANGED).as_compiled
    assert (model.object, model.motion, model.condition) == ("can", "turntable", "normal")
    assert TaskConfig(**{**vars(model), "condition": "dark-1", "delay_s": 0.0}).as_compiled == model
    for change in ({"object": "box"}, {"motion": "sine"}, {"has_camera": False}):
        assert TaskConfig(**{**vars(model), **change}).as_compiled != model
    assert TaskConfig(motion="sine").as_compiled == TaskConfig().as_compiled


def test_a_condition_has_one_name():
    assert WorldConfig(condition="dark-01+blur-1+dark-1").condition == "blur-1+dark-1"


@pytest.mark.parametrize(
    ("rate_hz", "message"),
    [(50.0, r"camera_rate_hz must divide 480 \(as 10"), (0.5, "from 1 to 120, got 0.5")],
)
def test_camera_rates_that_the_physics_cannot_keep_are_refused(rate_hz, message):
    with pytest.raises(ValueError, match=message):
        WorldConfig(camera_rate_hz=rate_hz)
