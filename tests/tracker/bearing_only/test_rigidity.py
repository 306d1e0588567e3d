"""Corners of a rigid scene pass; those that move otherwise are told."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracker.bearing_only.measurements import FeatureObservation, PinholeCamera
from tracker.bearing_only.rigidity import RigidityCheck, RigidityConfig

GAP, COUNT, WRONG = 5, 40, 6
CAMERA = PinholeCamera()
FEW = 3
"""Good ones that may be taken for wrong, as five noisy corners decide about all."""


def points(seed: int) -> np.ndarray:
    """(n, 3) in the first camera's frame, all in view."""
    rng = np.random.default_rng(seed)
    depth = rng.uniform(6.0, 30.0, COUNT)
    return np.column_stack([rng.uniform(-0.7, 0.7, (COUNT, 2)) * depth[:, None], depth])


def seen(where: np.ndarray, camera_m: np.ndarray, noise: np.ndarray) -> FeatureObservation:
    return FeatureObservation(np.arange(COUNT), CAMERA.project(where - camera_m) + 0.1 * noise)


def junctions(pixels: np.ndarray, step: int) -> np.ndarray:
    """Pixels of which the first few also slide down, as a crossing of edges does."""
    slid = pixels.copy()
    slid[:WRONG, 1] += 3.0 * step
    return slid


def flight(seed: int, wrong: bool, steps: int = 12):
    """Observations of a camera that flies to the right."""
    rng, where = np.random.default_rng(seed + 1), points(seed)
    for step in range(steps):
        view = seen(where, np.array([0.12 * step, 0.0, 0.0]), rng.standard_normal((COUNT, 2)))
        pixels = junctions(view.pixels, step) if wrong else view.pixels
        yield FeatureObservation(view.ids, pixels)


@settings(max_examples=12)
@given(st.integers(0, 10**6))
def test_a_rigid_scene_passes(seed):
    check = RigidityCheck(RigidityConfig(gap=GAP))
    for view in flight(seed, wrong=False):
        is_odd, is_proven = check.update(view)
        assert is_odd.sum() <= FEW
        assert (is_odd ^ is_proven).all()


@settings(max_examples=12)
@given(st.integers(0, 10**6))
def test_what_slides_is_told(seed):
    check = RigidityCheck(RigidityConfig(gap=GAP))
    for step, view in enumerate(flight(seed, wrong=True)):
        is_odd, is_proven = check.update(view)
        assert is_odd[:WRONG].all() == (step >= GAP)
        assert is_odd[WRONG:].sum() <= FEW
        assert not (is_odd & is_proven).any()


def test_a_new_corner_has_to_wait_until_it_is_compared():
    check = RigidityCheck(RigidityConfig(gap=GAP))
    for step, view in enumerate(flight(3, wrong=False, steps=GAP + 8)):
        ids = view.ids if step < GAP + 2 else view.ids + np.where(np.arange(COUNT) < 5, 1000, 0)
        is_odd, is_proven = check.update(FeatureObservation(ids, view.pixels))
        assert is_odd.sum() <= FEW and is_proven[5:].sum() >= COUNT - 5 - FEW
        if GAP + 2 <= step < 2 * GAP + 2:
            assert not is_proven[:5].any()
        else:
            assert is_proven[:5].sum() >= 5 - FEW


def test_with_few_corners_nothing_is_said():
    check = RigidityCheck(RigidityConfig(gap=1, least_count=12))
    for view in flight(0, wrong=True):
        few = FeatureObservation(view.ids[:11], view.pixels[:11])
        assert not check.update(few)[0].any()


def test_no_corner_is_no_trouble():
    check = RigidityCheck(RigidityConfig(gap=1))
    for _ in range(4):
        is_odd, is_proven = check.update(FeatureObservation.none())
        assert len(is_odd) == len(is_proven) == 0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"gap": 0}, "gap"),
        ({"least_count": 5}, "least_count"),
        ({"tolerance_px": 0.0}, "tolerance_px"),
        ({"camera": PinholeCamera(s_u_px=300.0)}, "s_u_px and s_v_px.*300"),
    ],
)
def test_impossible_settings_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        RigidityConfig(**change)
