"""Monocular SLAM: the pose and the landmarks in one extended Kalman filter.

The state is the pose, whose error has six numbers, then the landmarks in their order, six numbers
each while their depth is uncertain and three afterwards. Source: [Civera2008], which [Wu2022]
section 3 takes; the quaternion there is an error state here, so that nothing need be normalised.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tracker.bearing_only.covariance import JointCovariance
from tracker.bearing_only.landmarks import (
    COORDINATES,
    INVERSE_DEPTH,
    POSE,
    LandmarkTable,
    linearity,
    new_features,
    points_of,
    view_landmarks,
)
from tracker.bearing_only.measurements import (
    FeatureObservation,
    Measurements,
    PinholeCamera,
    PoseBelief,
)
from tracker.bearing_only.pose_sources import moved_position, odometry_jacobians, odometry_noise
from tracker.bearing_only.target_filter import determinant_2x2, inverse_2x2
from tracker.checks import require_count, require_positive, require_share
from tracker.geometry import rotation_of_vector

_SURELY = 3.0
"""Standard deviations by which an inverse depth must be negative to be impossible; while depths are
unknown, noise makes that of a far landmark negative for a while."""


@dataclass(frozen=True)
class SlamConfig:
    """Settings of the map and of its noise."""

    camera: PinholeCamera = field(default_factory=PinholeCamera)
    pixel_std_px: float = 3.0
    odometry_std_m: float = 0.01
    odometry_std_rad: float = 3.5e-4
    """0.02 degrees; [Wu2022] Table 1."""
    rho_per_m: float = 0.1
    rho_std_per_m: float = 0.5
    """Inverse depth of a new landmark; the values of [Civera2008] section VI. It must be wide: the
    landmarks share the error of the guess, and the filter takes it for independent, so that a
    narrow prior of many landmarks outvotes the odometry about the scale of everything."""
    gate: float = 13.8
    """Squared Mahalanobis distance beyond which a pixel is not believed: 99.9 % of a chi-square
    with two degrees. It is needed even with perfect association, as near landmarks of unknown
    depth are wildly nonlinear."""
    linearity: float = 0.1
    """Below this a landmark is converted to coordinates; [Civera2008] section V."""
    trial_count: int = 10
    """Sightings after which a landmark has to be found as often as `found_share`."""
    found_share: float = 0.5
    most: int = 20
    """Landmarks at most that correct the state in one image: those of which least is known."""
    capacity: int = 400
    """Landmarks at most; of those out of view the longest unseen has to go."""

    def __post_init__(self) -> None:
        require_positive(
            self,
            "pixel_std_px",
            "odometry_std_m",
            "odometry_std_rad",
            "rho_per_m",
            "rho_std_per_m",
            "gate",
            "linearity",
        )
        require_count(self, "trial_count", "most", "capacity")
        require_share(self, "found_share")


class MonocularSlam:
    """The pose by landmarks of unknown place; a pose source for a pilot."""

    def __init__(self, config: SlamConfig, start: PoseBelief) -> None:
        self.config = config
        self._position = np.array(start.position_m, float)
        self._R = np.array(start.R_world_body, float)
        self._x = np.empty(0)
        self._Q = odometry_noise(self._R, config.odometry_std_m, config.odometry_std_rad)
        self._P = JointCovariance(start.covariance)
        self._table = LandmarkTable()
        self._iteration = 0

    @property
    def pose(self) -> PoseBelief:
        """The pose now."""
        return PoseBelief(self._position.copy(), self._R.copy(), self._P.pose)

    @property
    def state_size(self) -> int:
        """Numbers in the state."""
        return len(self._P)

    def landmarks(self) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
        """Ids (n,), coordinates (n, 3) and their covariances (n, 3, 3) of the map now."""
        n = len(self._table)
        points, covariances = np.empty((n, 3)), np.empty((n, 3, 3))
        for size in (INVERSE_DEPTH, COORDINATES):
            rows = np.flatnonzero(self._table.sizes == size)
            index = self._table.indices(rows, size)
            values, P = self._x[index - POSE], self._P.blocks(index)
            if size == INVERSE_DEPTH:
                values, J = points_of(values)
                P = J @ P @ np.swapaxes(J, 1, 2)
            points[rows], covariances[rows] = values, P
        return self._table.ids.copy(), points, covariances

    def update(self, measurements: Measurements) -> PoseBelief:
        """One iteration: odometry, the landmarks that are known, and those that are new."""
        self._iteration += 1
        self._predict(measurements)
        features = measurements.features
        rows = self._table.rows_of(features.ids)
        is_known = rows >= 0
        if is_known.any():
            self._correct(rows[is_known], features.pixels[is_known])
        self._convert()
        self._remove()
        if not is_known.all():
            self._enter(FeatureObservation(features.ids[~is_known], features.pixels[~is_known]))
        return self.pose

    def _predict(self, measurements: Measurements) -> None:
        """Moves pose and covariance by the odometry; landmarks stand still."""
        pose, increment = self.pose, measurements.odometry
        dR, F = odometry_jacobians(pose.R_world_body, increment)
        self._position, self._R = moved_position(pose, increment), self._R @ dR
        self._P.move_pose(F, self._Q)

    def _correct(self, rows: NDArray[np.int64], pixels: NDArray[np.float64]) -> None:
        """Takes in the pixels of known landmarks, at once those that pass the gate and count."""
        table, config = self._table, self.config
        starts = table.starts[rows]
        predicted, by_pose, by_feature, is_in_front = view_landmarks(
            config.camera.intrinsics_px,
            self._position,
            self._R,
            self._x,
            starts - POSE,
            table.sizes[rows],
        )
        blocks = self._P.innovation_blocks((by_pose, by_feature, starts), config.pixel_std_px)
        residual = pixels - predicted
        distance = np.einsum("ni,nij,nj->n", residual, inverse_2x2(blocks), residual)
        is_believed = is_in_front & (distance < config.gate)
        table.tried[rows] += 1
        table.found[rows] += is_believed
        table.last_seen[rows] = self._iteration
        used = self._least_known(np.flatnonzero(is_believed), blocks)
        if len(used):
            seen = by_pose[used], by_feature[used], starts[used]
            self._move(self._P.correct(seen, residual[used].reshape(-1), config.pixel_std_px))

    def _least_known(
        self, believed: NDArray[np.int64], blocks: NDArray[np.float64]
    ) -> NDArray[np.int64]:
        """The part of `believed` that corrects, by the innovations' blocks (n, 2, 2)."""
        if len(believed) <= self.config.most:
            return believed
        volume = determinant_2x2(blocks[believed])
        return np.sort(believed[np.argsort(-volume, kind="stable")[: self.config.most]])

    def _move(self, error: NDArray[np.float64]) -> None:
        """Puts the estimated error into the state."""
        self._position = self._position + error[:3]
        self._R = self._R @ rotation_of_vector(error[3:POSE])
        self._x = self._x + error[POSE:]

    def _convert(self) -> None:
        """Landmarks whose depth is well known get coordinates: half the numbers."""
        rows = np.flatnonzero(self._table.sizes == INVERSE_DEPTH)
        if not len(rows):
            return
        index = self._table.indices(rows, INVERSE_DEPTH)
        features, variance = self._x[index - POSE], self._P.variances(index[:, 5])
        chosen = linearity(features, variance, self._position) < self.config.linearity
        if not chosen.any():
            return
        index = index[chosen]
        points, J = points_of(features[chosen])
        self._x[index[:, :COORDINATES] - POSE] = points
        self._P.to_coordinates(index[:, 0], J)
        self._table.to_coordinates(rows[chosen])
        is_kept = np.ones(self.state_size, bool)
        is_kept[index[:, COORDINATES:]] = False
        self._shrink(is_kept)

    def _remove(self) -> None:
        """Drops landmarks that are not believed, lie behind infinity, or are too many."""
        table, config = self._table, self.config
        is_bad = (table.tried >= config.trial_count) & (
            table.found < config.found_share * table.tried
        )
        deep = np.flatnonzero(table.sizes == INVERSE_DEPTH)
        if len(deep):
            place = table.starts[deep] + 5
            rho, std = self._x[place - POSE], np.sqrt(self._P.variances(place))
            is_bad[deep[rho + _SURELY * std < 0.0]] = True
        surplus = len(table) - int(is_bad.sum()) - config.capacity
        if surplus > 0:
            candidates = np.flatnonzero(~is_bad & (table.last_seen < self._iteration))
            oldest = candidates[np.argsort(table.last_seen[candidates], kind="stable")]
            is_bad[oldest[:surplus]] = True
        if not is_bad.any():
            return
        numbers = np.concatenate([np.ones(POSE, bool), np.repeat(~is_bad, table.sizes)])
        self._shrink(numbers)
        table.keep(~is_bad)

    def _shrink(self, is_kept: NDArray[np.bool_]) -> None:
        """Leaves out numbers of the state."""
        self._P.keep(np.flatnonzero(is_kept))
        self._x = self._x[is_kept[POSE:]]

    def _enter(self, new: FeatureObservation) -> None:
        """New landmarks: correlated with the pose from which they are first seen."""
        config, n = self.config, len(new.ids)
        features, by_pose, by_pixel = new_features(
            config.camera, self.pose, new.pixels, config.rho_per_m
        )
        own = np.zeros((n, INVERSE_DEPTH, INVERSE_DEPTH))
        own[:, 3:5, 3:5] = config.pixel_std_px**2 * by_pixel @ np.swapaxes(by_pixel, 1, 2)
        own[:, 5, 5] = config.rho_std_per_m**2
        self._P.append(by_pose.reshape(-1, POSE), own)
        self._x = np.concatenate([self._x, features.reshape(-1)])
        self._table.add(new.ids, self._iteration)
