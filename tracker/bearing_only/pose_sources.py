"""Where a pilot gets its pose from, and how odometry moves it on."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tracker.bearing_only.measurements import BodyIncrement, Measurements, PoseBelief
from tracker.geometry import rotation_of_euler, skew


class PoseSource(Protocol):
    """Answers with the pose of the vehicle after each iteration's measurements."""

    def update(self, measurements: Measurements) -> PoseBelief:
        """The pose now."""
        ...


def odometry_jacobians(
    R_world_body: NDArray[np.float64], increment: BodyIncrement
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The turn (..., 3, 3), and F (..., 6, 6) by which the error state of the pose moves on.

    With p' = p + R dx and R' = R dR, an error of the rotation moves the position by -R [dx]x.
    """
    dR = rotation_of_euler(increment.rotation_rad)
    F = np.zeros((*R_world_body.shape[:-2], 6, 6))
    F[..., :3, :3] = np.eye(3)
    F[..., :3, 3:] = -R_world_body @ skew(increment.displacement_m)
    F[..., 3:, 3:] = np.swapaxes(dR, -1, -2)
    return dR, F


def odometry_noise(
    R_world_body: NDArray[np.float64], std_m: float, std_rad: float
) -> NDArray[np.float64]:
    """(..., 6, 6) covariance that one increment adds, the same on every axis of the body."""
    Q = np.zeros((*R_world_body.shape[:-2], 6, 6))
    Q[..., range(6), range(6)] = [std_m**2] * 3 + [std_rad**2] * 3
    return Q


class DeadReckoning:
    """The sum of the odometry: the vehicle without eyes.  Source: [Wu2022] Eq. 2."""

    def __init__(self, start: PoseBelief, std_m: float, std_rad: float) -> None:
        self._pose, self._std_m, self._std_rad = start, std_m, std_rad

    def update(self, measurements: Measurements) -> PoseBelief:
        """Adds the increment."""
        pose, increment = self._pose, measurements.odometry
        dR, F = odometry_jacobians(pose.R_world_body, increment)
        Q = odometry_noise(pose.R_world_body, self._std_m, self._std_rad)
        self._pose = PoseBelief(
            moved_position(pose, increment),
            pose.R_world_body @ dR,
            F @ pose.covariance @ np.swapaxes(F, -1, -2) + Q,
        )
        return self._pose


def moved_position(pose: PoseBelief, increment: BodyIncrement) -> NDArray[np.float64]:
    """(..., 3): the displacement is in the frame of the body as it was before the turn."""
    moved = np.einsum("...ij,...j->...i", pose.R_world_body, increment.displacement_m)
    return pose.position_m + moved


class FixAided:
    """Odometry and position fixes in one filter: white noise of the fixes averages out.

    A fix of 1 m beside odometry of 0.01 m a step leaves about 0.1 m. Handing the fix's own
    covariance to the target filter instead ([Wu2022] Eq. 7) keeps its gain right, but not its
    Jacobians, which are evaluated at the fix and gain information that is not there.
    """

    def __init__(self, start: PoseBelief, fixes: PoseSource, std_m: float, std_rad: float) -> None:
        """Sets up the filter.

        Args:
            start: Pose at the first iteration.
            fixes: Answers with positions and their covariance; its rotation is taken as it is.
            std_m: Noise of the odometry, per axis and step.
            std_rad: Likewise of its rotation.
        """
        self._pose, self._fixes, self._std_m, self._std_rad = start, fixes, std_m, std_rad

    def update(self, measurements: Measurements) -> PoseBelief:
        """Adds the increment, then takes in the fix."""
        reckoning = DeadReckoning(self._pose, self._std_m, self._std_rad)
        pose, fix = reckoning.update(measurements), self._fixes.update(measurements)
        P = pose.covariance[..., :3, :3]
        S = P + fix.covariance[..., :3, :3]
        K = P @ np.linalg.inv(S)
        position = pose.position_m + np.einsum(
            "...ij,...j->...i", K, fix.position_m - pose.position_m
        )
        covariance = np.zeros_like(pose.covariance)
        covariance[..., :3, :3] = P - K @ P
        covariance[..., 3:, 3:] = fix.covariance[..., 3:, 3:]
        self._pose = PoseBelief(position, fix.R_world_body, covariance)
        return self._pose
