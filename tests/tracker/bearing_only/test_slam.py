import numpy as np
import pytest

from tracker.bearing_only.landmarks import COORDINATES, INVERSE_DEPTH, LandmarkTable
from tracker.bearing_only.measurements import (
    BodyIncrement,
    FeatureObservation,
    Measurements,
    PinholeCamera,
    PoseBelief,
)
from tracker.bearing_only.pose_sources import DeadReckoning, FixAided
from tracker.bearing_only.slam import MonocularSlam, SlamConfig
from tracker.geometry import rotation_of_euler

CAMERA = PinholeCamera()
START = PoseBelief(np.zeros(3), np.eye(3), np.zeros((6, 6)))
STEP = BodyIncrement(np.array([0.02, 0.12, 0.0]), np.array([0.0, 0.0, -0.004]))


class World:
    """A vehicle that moves sideways past landmarks, with noise."""

    def __init__(self, seed=0, count=60, pixel_std=1.0, odometry_std=0.01):
        self.rng = np.random.default_rng(seed)
        self.landmarks = self.rng.uniform([6.0, -12.0, -6.0], [30.0, 12.0, 6.0], (count, 3))
        self.position, self.R = np.zeros(3), np.eye(3)
        self.pixel_std, self.odometry_std = pixel_std, odometry_std

    def look(self, odometry):
        body = (self.landmarks - self.position) @ self.R
        pixels = CAMERA.project(np.stack([-body[:, 1], -body[:, 2], body[:, 0]], axis=1))
        pixels = pixels + self.pixel_std * self.rng.normal(size=pixels.shape)
        ids = np.flatnonzero(CAMERA.contains(pixels) & (body[:, 0] > 0.5))
        return Measurements(odometry, FeatureObservation(ids, pixels[ids]))

    def move(self, increment):
        noise = self.odometry_std * self.rng.normal(size=3)
        self.position = self.position + self.R @ (increment.displacement_m + noise)
        self.R = self.R @ rotation_of_euler(increment.rotation_rad)


def drive(slam, world, steps=60):
    odometry = BodyIncrement.none()
    for k in range(steps):
        pose = slam.update(world.look(odometry))
        if k + 1 < steps:
            world.move(STEP)
            odometry = STEP
    return pose


@pytest.fixture(scope="module")
def driven():
    world = World()
    slam = MonocularSlam(SlamConfig(pixel_std_px=1.0), START)
    return slam, world, drive(slam, world)


def test_the_pose_is_found_and_as_good_as_it_believes(driven):
    errors = [(driven[1], driven[2])]
    for seed in (1, 2):
        world = World(seed)
        errors.append((world, drive(MonocularSlam(SlamConfig(pixel_std_px=1.0), START), world, 40)))
    nees = []
    for world, pose in errors:
        error = pose.position_m - world.position
        assert np.linalg.norm(error) < 0.3
        nees.append(error @ np.linalg.solve(pose.covariance[:3, :3], error))
    assert np.mean(nees) < 9.0


def test_a_narrow_prior_of_many_landmarks_outvotes_the_odometry():
    """Why the prior of inverse depth is wide: its error is common to all landmarks."""
    nees = []
    for prior in (0.05, 0.5):
        world = World(odometry_std=0.02)
        slam = MonocularSlam(
            SlamConfig(pixel_std_px=1.0, rho_per_m=0.2, rho_std_per_m=prior), START
        )
        pose = drive(slam, world, 30)
        error = pose.position_m - world.position
        nees.append(error @ np.linalg.solve(pose.covariance[:3, :3], error))
    assert nees[0] > 3.0 * nees[1]


def test_it_beats_the_odometry_and_admits_less_doubt(driven):
    world = World()
    reckoned = drive(DeadReckoning(START, 0.01, 3.5e-4), world)
    pose = driven[2]
    assert np.trace(pose.covariance[:3, :3]) < 0.5 * np.trace(reckoned.covariance[:3, :3])


def test_landmarks_are_converted_and_where_they_are(driven):
    slam, world, _ = driven
    sizes = slam._table.sizes
    assert (sizes == COORDINATES).sum() > 10
    assert slam.state_size == 6 + sizes.sum()
    ids, points, P = slam.landmarks()
    error = points - world.landmarks[ids]
    size = np.linalg.norm(error, axis=1)[sizes == COORDINATES]
    depth = np.linalg.norm(world.landmarks[ids], axis=1)[sizes == COORDINATES]
    assert np.median(size / depth) < 0.05
    assert (np.linalg.eigvalsh(P) > 0.0).all()


def test_the_few_landmarks_of_which_least_is_known_keep_the_pose(driven):
    _, world, all_pose = driven
    few = MonocularSlam(SlamConfig(pixel_std_px=1.0, most=8), START)
    pose = drive(few, same := World())
    np.testing.assert_array_equal(same.position, world.position)
    assert np.linalg.norm(pose.position_m - same.position) < 0.2
    doubt, least = (np.trace(p.covariance[:3, :3]) for p in (pose, all_pose))
    assert doubt < 4.0 * least
    stds = np.sqrt([np.linalg.eigvalsh(P).max() for P in few.landmarks()[2]])
    assert np.median(stds) < 0.1 * np.linalg.norm(few.landmarks()[1], axis=1).mean()


def test_the_covariance_stays_positive(driven):
    slam = driven[0]
    P = slam._P.blocks(np.arange(slam.state_size))
    assert np.linalg.eigvalsh(P).min() > -1e-9


def test_without_landmarks_it_is_dead_reckoning():
    slam, reckoning = MonocularSlam(SlamConfig(), START), DeadReckoning(START, 0.01, 3.5e-4)
    for _ in range(10):
        pose, expected = (s.update(Measurements(STEP)) for s in (slam, reckoning))
    assert np.allclose(pose.position_m, expected.position_m)
    assert np.allclose(pose.covariance, expected.covariance)
    assert slam.landmarks()[0].size == 0


def test_a_landmark_that_jumps_is_not_believed_and_has_to_go():
    world = World()
    slam = MonocularSlam(SlamConfig(pixel_std_px=1.0), START)
    odometry = BodyIncrement.none()
    for k in range(30):
        seen = world.look(odometry)
        pixels = seen.features.pixels.copy()
        pixels[seen.features.ids == seen.features.ids[0]] += [0.0, 25.0 * (k % 2)]
        slam.update(Measurements(odometry, FeatureObservation(seen.features.ids, pixels)))
        world.move(STEP)
        odometry = STEP
    error = slam.pose.position_m - world.position
    assert np.linalg.norm(error) < 0.3


def test_the_map_keeps_to_its_capacity():
    slam = MonocularSlam(SlamConfig(capacity=20), START)
    for k in range(12):
        ids = np.arange(10 * k, 10 * k + 10)
        pixels = np.random.default_rng(k).uniform([10, 10], [600, 400], (10, 2))
        slam.update(Measurements(STEP, FeatureObservation(ids, pixels)))
    assert len(slam.landmarks()[0]) <= 30
    assert slam.landmarks()[0].max() == 119


def test_the_table_finds_its_rows():
    table = LandmarkTable()
    assert np.array_equal(table.rows_of(np.array([4])), [-1])
    table.add(np.array([7, 3, 9]), 0)
    assert np.array_equal(table.rows_of(np.array([9, 5, 7])), [2, -1, 0])
    table.to_coordinates(np.array([1]))
    assert np.array_equal(table.starts, [6, 12, 15])
    assert np.array_equal(table.indices(np.array([2]), INVERSE_DEPTH)[0], np.arange(15, 21))
    table.keep(np.array([True, False, True]))
    assert np.array_equal(table.starts, [6, 12])


def test_fixes_and_odometry_together_are_better_than_either():
    rng, world = np.random.default_rng(0), World(odometry_std=0.02)

    class Fixes:
        def update(self, measurements):
            noisy = world.position + rng.normal(0.0, 1.0, 3)
            P = np.zeros((6, 6))
            P[range(3), range(3)] = 1.0
            return PoseBelief(noisy, world.R, P)

    fused = FixAided(START, Fixes(), 0.02, 3.5e-4)
    errors, odometry = [], BodyIncrement.none()
    for _ in range(300):
        pose = fused.update(Measurements(odometry))
        errors.append(np.linalg.norm(pose.position_m - world.position))
        world.move(STEP)
        odometry = STEP
    assert np.mean(errors[100:]) < 0.4
    assert np.trace(pose.covariance[:3, :3]) < 0.1
