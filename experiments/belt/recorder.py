"""Videos of a trial: the camera's image with what the tracker believes, beside the whole cell."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import cv2
import numpy as np

from experiments.belt.config import TrialConfig
from experiments.report.movie import Movie, caption
from sim.belt.task import CONTROL_HZ
from tracker.base import Status

if TYPE_CHECKING:
    from experiments.belt.loop import Loop

FRAME_HZ = 30
_EVERY = CONTROL_HZ // FRAME_HZ
_COLOURS = {
    Status.SEARCHING: (230, 230, 230),
    Status.TRACKING: (255, 210, 40),
    Status.UNCERTAIN: (255, 130, 30),
    Status.LOST: (230, 50, 50),
}
_PARTICLE = (60, 220, 255)


class VideoRecorder:
    """Writes one frame a thirtieth of a simulated second; does nothing without a path."""

    def __init__(self, path: Path | None, config: TrialConfig) -> None:
        self._movie = Movie(path, FRAME_HZ)
        self._title = f"{config.tracker}  {config.speed_mps:g} m/s  seed {config.seed}"
        self._steps = 0

    def __enter__(self) -> VideoRecorder:
        self._movie.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        self._movie.__exit__(*error)

    def add(self, loop: Loop) -> None:
        """Draws the state after a control step."""
        self._steps += 1
        if self._movie.path is None or self._steps % _EVERY:
            return
        self._movie.add(np.hstack([camera_view(loop, self._title), cell_view(loop)]))


def camera_view(loop: Loop, title: str) -> np.ndarray:
    """(h, w, 3) uint8, the newest image that has arrived, with the estimate that belongs to it."""
    assert loop.image is not None, "a video needs a camera"
    image = np.array(loop.image.whole[0])
    seen = loop.seen
    if seen is not None and len(seen.corners_px):
        _draw_points(image, seen.particles_px, _PARTICLE)
        _draw_outline(image, seen.corners_px, _COLOURS[seen.status])
    status = "" if seen is None else f"  {seen.status}"
    caption(image, title, f"{loop.time_s:5.2f} s  {loop.grasp.phase}{status}")
    return image


def cell_view(loop: Loop) -> np.ndarray:
    """(h, w, 3) uint8 view of the whole cell."""
    image = np.array(loop.render_studio())
    held_s = loop.record.held_s
    if loop.record.is_success:
        caption(image, "success: lifted and held")
    elif held_s > 0.0:
        caption(image, f"held {held_s:.1f} s")
    return image


def _draw_outline(image: np.ndarray, corners_px: np.ndarray, colour: tuple[int, int, int]) -> None:
    """Closed polygon through (n, 2) pixels, in place; 1/16 px precise."""
    if np.isfinite(corners_px).all():
        points = np.rint(16.0 * np.clip(corners_px, -1e4, 1e4)).astype(np.int32)
        cv2.polylines(image, [points], True, colour, 2, cv2.LINE_AA, shift=4)


def _draw_points(image: np.ndarray, points_px: np.ndarray, colour: tuple[int, int, int]) -> None:
    """One pixel a point (n, 2), in place; points outside are left out."""
    height, width = image.shape[:2]
    is_in = np.isfinite(points_px).all(axis=1)
    columns, rows = np.rint(np.clip(points_px[is_in], -1, 1e4)).astype(int).T
    is_in = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    image[rows[is_in], columns[is_in]] = colour
