"""What holds for all tests.

The OpenGL platform is chosen before any test imports mujoco or dm_control. Hypothesis runs without
deadlines, since shared machines stall, and takes the same examples every time.
"""

from hypothesis import settings

import sim  # noqa: F401

settings.register_profile("beltgrasp", deadline=None, derandomize=True, max_examples=60)
settings.load_profile("beltgrasp")
