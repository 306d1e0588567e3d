"""The arm and its gripper: models, servo, and the grasp as phases."""

from sim import require_offscreen_gl

require_offscreen_gl()
