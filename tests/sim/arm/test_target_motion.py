"""How far the hand is from its grasp on the target."""

import math

import numpy as np
import pytest

from sim.arm.hand_motion import top_down_pose
from sim.arm.target_motion import UniformMotion, servo_error


def test_servo_error_is_zero_at_the_grasp_and_counts_both_parts():
    motion = UniformMotion(np.array([0.52, 0.0, 0.08]), 0.3, np.array([0.0, 0.25, 0.0]))
    depth = 0.035
    grasp_position = motion.position_m - [0.0, 0.0, depth]
    exact = top_down_pose(grasp_position, 0.3 + math.pi / 2)
    assert servo_error(motion, exact, depth) == pytest.approx(0.0, abs=1e-12)
    turned = top_down_pose(grasp_position, 0.3 + math.pi / 2 + 0.2)
    assert servo_error(motion, turned, depth) == pytest.approx(0.02)
    shifted = top_down_pose(grasp_position + np.array([0.03, 0.0, 0.04]), 0.3 - math.pi / 2)
    assert servo_error(motion, shifted, depth) == pytest.approx(0.05)
