"""Drives a tracker of the belt through rendered images of a synthetic scene."""

import numpy as np
from scenes import SIZE_M, TOP_Z_M, angle_error

from tracker.belt.image import ArrayImage
from tracker.belt.perception import TargetTracker
from tracker.belt.registry import get_tracker_config

RATE_HZ = 30.0


def build(name, template, view, seed=0, particle_count=150):
    config = get_tracker_config(name).with_particle_count(particle_count)
    return TargetTracker(config, template, SIZE_M, view, np.random.default_rng(seed))


def drive(tracker, scene, speed, yaw, count, x=0.53, y=-0.3, occluder=None):
    """Runs `count` images; returns observations and position and yaw errors of usable poses."""
    seen, errors = [], []
    for k in range(count):
        y_k = y + speed * k / RATE_HZ
        hidden = None if occluder is None else occluder(k, y_k)
        seen.append(tracker.update(ArrayImage(*scene.render(x, y_k, yaw, hidden), k / RATE_HZ)))
        pose = seen[-1].pose
        if pose is not None and pose.is_usable:
            error = pose.position_m - [x, y_k, TOP_Z_M]
            errors.append([*error, angle_error(pose.yaw_rad, yaw)])
    return seen, np.array(errors)
