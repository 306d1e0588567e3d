"""The simulated world: UR5, gripper, conveyor, RGB-D camera, physics of success, and the servo."""

import os
from pathlib import Path

# MuJoCo chooses its OpenGL back end at the first import of mujoco or dm_control.
os.environ.setdefault("MUJOCO_GL", "egl")

ASSETS = Path(__file__).resolve().parent.parent / "assets"
"""Folder of MJCF models and meshes; the same place in a checkout and in an installed wheel."""
