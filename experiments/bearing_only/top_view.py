"""A flight from above, drawn instant by instant: ways, beliefs, landmarks and covariances."""

from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from experiments.bearing_only.flying import Instant
from sim.bearing_only.flight import FlightConfig
from tracker.bearing_only.slam import MonocularSlam

Colour: TypeAlias = tuple[int, int, int]

ROBOT: Colour = (0, 114, 178)
TARGET: Colour = (213, 94, 0)
LANDMARK: Colour = (150, 150, 150)
BELIEF: Colour = (30, 30, 30)
_SHIFT = 4
_SIGMAS = 2.0
_WIDEST = 0.24
"""Of the room: a landmark that is less certain is not drawn: its ellipse would hide the others."""
_SIGHT = 0.08
"""Of the room: how far the sides of the camera's view are drawn."""
_KEY = (("vehicle", ROBOT), ("target", TARGET), ("landmarks", LANDMARK), ("estimates", BELIEF))


class TopView:
    """Remembers the ways so far."""

    def __init__(self) -> None:
        self._ways: dict[str, list[NDArray[np.float64]]] = {
            "robot": [],
            "target": [],
            "robot_estimate": [],
            "target_estimate": [],
        }

    def draw(self, instant: Instant, size_px: int) -> NDArray[np.uint8]:
        """(size, size, 3) uint8 RGB with the state at this instant."""
        pose, target = instant.pose, instant.target
        self._ways["robot"].append(instant.robot_m)
        self._ways["target"].append(instant.target_m)
        self._ways["robot_estimate"].append(pose.position_m)
        if target is not None:
            self._ways["target_estimate"].append(target.position_m)
        chart = _Chart(instant.flight.config, size_px)
        if isinstance(instant.source, MonocularSlam):
            _, points, covariances = instant.source.landmarks()
            for point, P in zip(points, covariances, strict=True):
                chart.ellipse(point, P, LANDMARK)
        chart.sight(instant.robot_m, instant.forward, ROBOT)
        for name, colour in (("robot", ROBOT), ("target", TARGET)):
            chart.way(self._ways[name], colour, 2)
            chart.way(self._ways[f"{name}_estimate"], BELIEF, 1)
            chart.dot(self._ways[name][-1], colour)
        chart.ellipse(pose.position_m, pose.covariance, ROBOT)
        if target is not None:
            chart.ellipse(target.position_m, target.covariance, TARGET, 2)
            error_m = float(np.linalg.norm(target.position_m - instant.target_m))
            own_m = float(np.linalg.norm(pose.position_m - instant.robot_m))
            chart.caption(f"error: target {error_m:.2f} m, vehicle {own_m:.2f} m")
        return chart.picture


class _Chart:
    """A white picture of the room; x to the right, y up."""

    def __init__(self, world: FlightConfig, size_px: int) -> None:
        self.picture: NDArray[np.uint8] = np.full((size_px, size_px, 3), 255, np.uint8)
        low, high = np.array(world.landmark_low_m)[:2], np.array(world.landmark_high_m)[:2]
        self._middle_m, self._size_px = 0.5 * (low + high), size_px
        self._room_m = float(np.max(high - low))
        self._px_per_m = size_px / (1.1 * self._room_m)
        self._half_view_rad = np.arctan2(world.camera.u0_px, world.camera.s_u_px)
        corners = [low, (low[0], high[1]), high, (high[0], low[1]), low]
        self.way(corners, (205, 205, 205), 1)

    def _places(self, points_m: ArrayLike) -> NDArray[np.int32]:
        """(..., 2) sixteenths of a pixel of (..., 2 or 3) points."""
        offset_m = np.asarray(points_m, float)[..., :2] - self._middle_m
        pixels = 0.5 * self._size_px + offset_m * [1.0, -1.0] * self._px_per_m
        return np.rint(2**_SHIFT * pixels).astype(np.int32)

    def way(self, points_m: ArrayLike, colour: Colour, width_px: int) -> None:
        """A line through the points."""
        line = self._places(points_m)
        if len(line) > 1:
            cv2.polylines(self.picture, [line], False, colour, width_px, cv2.LINE_AA, _SHIFT)

    def dot(self, point_m: NDArray[np.float64], colour: Colour) -> None:
        """A disc."""
        radius = round(2**_SHIFT * 4.5)
        place = self._places(point_m).tolist()
        cv2.circle(self.picture, place, radius, colour, -1, cv2.LINE_AA, _SHIFT)

    def sight(
        self, point_m: NDArray[np.float64], forward: NDArray[np.float64], colour: Colour
    ) -> None:
        """The two sides of the camera's view."""
        yaw = np.arctan2(forward[1], forward[0])
        for angle in (yaw - self._half_view_rad, yaw + self._half_view_rad):
            direction = np.array([np.cos(angle), np.sin(angle)])
            end = point_m[:2] + _SIGHT * self._room_m * direction
            self.way([point_m[:2], end], colour, 1)

    def ellipse(
        self,
        point_m: NDArray[np.float64],
        covariance: NDArray[np.float64],
        colour: Colour,
        width_px: int = 1,
    ) -> None:
        """Two standard deviations of the horizontal position."""
        values, vectors = np.linalg.eigh(covariance[:2, :2])
        axes_m = _SIGMAS * np.sqrt(np.maximum(values, 0.0))
        if not np.isfinite(axes_m).all() or axes_m.max() > _WIDEST * self._room_m:
            return
        turns = np.linspace(0.0, 2.0 * np.pi, 33)
        ring = point_m[:2] + (np.column_stack([np.cos(turns), np.sin(turns)]) * axes_m) @ vectors.T
        self.way(ring, colour, width_px)

    def caption(self, line: str) -> None:
        """Errors at the top, and what the colours mean below, each on a clear strip."""
        font, dark = cv2.FONT_HERSHEY_SIMPLEX, (60, 60, 60)
        self.picture[:20], self.picture[-20:] = 255, 255
        cv2.putText(self.picture, line, (12, 16), font, 0.45, dark, 1, cv2.LINE_AA)
        for index, (word, colour) in enumerate(_KEY):
            place = 12 + index * (self._size_px - 12) // len(_KEY), self._size_px - 6
            cv2.putText(self.picture, word, place, font, 0.45, colour, 1, cv2.LINE_AA)
