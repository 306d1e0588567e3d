"""A flight from above, drawn instant by instant: ways, beliefs, landmarks and covariances."""

from __future__ import annotations

from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from experiments.bearing_only.flying import Instant
from sim.flight import BOX_HIGH_M, BOX_LOW_M
from tracker.bearing_only.slam import MonocularSlam

Colour: TypeAlias = tuple[int, int, int]

ROBOT: Colour = (0, 114, 178)
TARGET: Colour = (213, 94, 0)
LANDMARK: Colour = (150, 150, 150)
BELIEF: Colour = (30, 30, 30)
_SHIFT = 4
_SIGMAS = 2.0
_WIDEST_M = 12.0
"""A landmark that is less certain than this is not drawn: its ellipse would hide the others."""
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
        flight, pilot = instant.flight, instant.pilot
        self._ways["robot"].append(flight.position_m)
        self._ways["target"].append(flight.target_m)
        self._ways["robot_estimate"].append(pilot.pose.position_m)
        if pilot.has_target:
            self._ways["target_estimate"].append(pilot.target.position_m)
        chart = _Chart(size_px)
        if isinstance(instant.source, MonocularSlam):
            _, points, covariances = instant.source.landmarks()
            for point, P in zip(points, covariances, strict=True):
                chart.ellipse(point, P, LANDMARK)
        chart.sight(flight.position_m, flight.R_world_body[:, 0], ROBOT)
        for name, colour in (("robot", ROBOT), ("target", TARGET)):
            chart.way(self._ways[name], colour, 2)
            chart.way(self._ways[f"{name}_estimate"], BELIEF, 1)
            chart.dot(self._ways[name][-1], colour)
        chart.ellipse(pilot.pose.position_m, pilot.pose.covariance, ROBOT)
        if pilot.has_target:
            chart.ellipse(pilot.target.position_m, pilot.target.covariance, TARGET, 2)
            error_m = float(np.linalg.norm(pilot.target.position_m - flight.target_m))
            own_m = float(np.linalg.norm(pilot.pose.position_m - flight.position_m))
            chart.caption(f"error: target {error_m:.2f} m, vehicle {own_m:.2f} m")
        return chart.picture


class _Chart:
    """A white picture of the room; x to the right, y up."""

    def __init__(self, size_px: int) -> None:
        self.picture: NDArray[np.uint8] = np.full((size_px, size_px, 3), 255, np.uint8)
        self._px_per_m = size_px / (1.1 * float(BOX_HIGH_M[0] - BOX_LOW_M[0]))
        self._size_px = size_px
        low, high = self._place(BOX_LOW_M), self._place(BOX_HIGH_M)
        cv2.rectangle(self.picture, low, high, (205, 205, 205), 1, cv2.LINE_AA, _SHIFT)

    def _place(self, point_m: NDArray[np.float64]) -> tuple[int, int]:
        """Sixteenths of a pixel."""
        middle = 0.5 * (BOX_LOW_M + BOX_HIGH_M)
        x, y = (np.asarray(point_m)[:2] - middle[:2]) * [1.0, -1.0] * self._px_per_m
        column, row = (2**_SHIFT * (0.5 * self._size_px + value) for value in (x, y))
        return round(column), round(row)

    def way(self, points_m: list[NDArray[np.float64]], colour: Colour, width_px: int) -> None:
        """A line through the points."""
        if len(points_m) > 1:
            line = np.array([self._place(point) for point in points_m], np.int32)
            cv2.polylines(self.picture, [line], False, colour, width_px, cv2.LINE_AA, _SHIFT)

    def dot(self, point_m: NDArray[np.float64], colour: Colour) -> None:
        """A disc."""
        radius = round(2**_SHIFT * 4.5)
        cv2.circle(self.picture, self._place(point_m), radius, colour, -1, cv2.LINE_AA, _SHIFT)

    def sight(
        self, point_m: NDArray[np.float64], forward: NDArray[np.float64], colour: Colour
    ) -> None:
        """The two sides of the camera's view, 45 degrees from its axis."""
        yaw = np.arctan2(forward[1], forward[0])
        for angle in (yaw - np.pi / 4, yaw + np.pi / 4):
            end = point_m[:2] + 4.0 * np.array([np.cos(angle), np.sin(angle)])
            ends = self._place(point_m), self._place(end)
            cv2.line(self.picture, *ends, colour, 1, cv2.LINE_AA, _SHIFT)

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
        if not np.isfinite(axes_m).all() or axes_m.max() > _WIDEST_M:
            return
        turns = np.linspace(0.0, 2.0 * np.pi, 33)
        ring = point_m[:2] + (np.column_stack([np.cos(turns), np.sin(turns)]) * axes_m) @ vectors.T
        self.way(list(ring), colour, width_px)

    def caption(self, line: str) -> None:
        """Errors at the top, and what the colours mean below, each on a clear strip."""
        font, dark = cv2.FONT_HERSHEY_SIMPLEX, (60, 60, 60)
        self.picture[:20], self.picture[-20:] = 255, 255
        cv2.putText(self.picture, line, (12, 16), font, 0.45, dark, 1, cv2.LINE_AA)
        for index, (word, colour) in enumerate(_KEY):
            place = 12 + index * (self._size_px - 12) // len(_KEY), self._size_px - 6
            cv2.putText(self.picture, word, place, font, 0.45, colour, 1, cv2.LINE_AA)
