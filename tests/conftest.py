"""The OpenGL platform is chosen before any test imports mujoco or dm_control."""

import sim  # noqa: F401
