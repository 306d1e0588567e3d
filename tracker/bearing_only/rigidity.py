"""Which corners are no points in space: those that move otherwise than a rigid scene can.

Where the edge of something near crosses an edge far behind it there is a corner that moves
smoothly, and that every comparison of patches believes. A map with a few of those drifts away.
"""

from collections import deque
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tracker.bearing_only.measurements import FeatureObservation, PinholeCamera
from tracker.checks import require_count, require_positive


@dataclass(frozen=True)
class RigidityConfig:
    """How strictly corners are compared with the motion of the others."""

    camera: PinholeCamera = field(default_factory=PinholeCamera)
    gap: int = 15
    """So many images lie between the two that are compared."""
    tolerance_px: float = 1.0
    """Farthest that a corner may be from its epipolar line."""
    least_count: int = 12
    """With fewer corners in both images nothing is said; five of them decide the motion."""

    def __post_init__(self) -> None:
        require_count(self, "gap")
        require_count(self, "least_count", least=6)
        require_positive(self, "tolerance_px")
        if self.camera.s_u_px != self.camera.s_v_px:
            raise ValueError(
                f"s_u_px and s_v_px must be equal, got {self.camera.s_u_px} and "
                f"{self.camera.s_v_px}"
            )


class RigidityCheck:
    """Compares each image with an earlier one by the essential matrix.

    Source: [Nister2004], five corners at a time, with the consensus of all by RANSAC
    [Fischler1981].
    """

    def __init__(self, config: RigidityConfig | None = None) -> None:
        self.config = config or RigidityConfig()
        self._past: deque[FeatureObservation] = deque(maxlen=self.config.gap)
        self._proven: set[int] = set()

    def update(self, seen: FeatureObservation) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """(n,) which corners of the next image contradict the others, and which stood the test.

        A corner that is younger than the gap is neither. While no image is old enough to compare
        with, all are taken as proven: nothing else is known then.
        """
        is_odd = np.zeros(len(seen.ids), bool)
        if len(self._past) < self.config.gap:
            self._proven.update(seen.ids.tolist())
        else:
            is_odd = self._compare(self._past[0], seen)
        self._proven.intersection_update(seen.ids[~is_odd].tolist())
        self._past.append(seen)
        return is_odd, np.array([i in self._proven for i in seen.ids.tolist()], bool)

    def _compare(self, before: FeatureObservation, now: FeatureObservation) -> NDArray[np.bool_]:
        """(n,) which corners of `now` are far from their epipolar lines; notes those that fit."""
        is_odd = np.zeros(len(now.ids), bool)
        _, old, new = np.intersect1d(before.ids, now.ids, assume_unique=True, return_indices=True)
        if len(new) < self.config.least_count:
            return is_odd
        camera = self.config.camera
        essential: Any = cv2.findEssentialMat(
            before.pixels[old],
            now.pixels[new],
            focal=camera.s_u_px,
            pp=(camera.u0_px, camera.v0_px),
            method=cv2.RANSAC,
            prob=0.999,
            threshold=self.config.tolerance_px,
        )
        fits = essential[1]
        if fits is None:
            return is_odd
        is_odd[new] = fits.ravel() == 0
        self._proven.update(now.ids[new][fits.ravel() == 1].tolist())
        return is_odd
