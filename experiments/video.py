"""Videos of a trial: the camera's image with what the tracker believes, beside the whole cell."""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import cv2
import imageio_ffmpeg
import numpy as np

from experiments.config import TrialConfig
from sim.task import CONTROL_HZ
from tracker.base import Status

if TYPE_CHECKING:
    from experiments.loop import Loop

FRAME_HZ = 30
_EVERY = CONTROL_HZ // FRAME_HZ
_COLOURS = {
    Status.SEARCHING: (230, 230, 230),
    Status.TRACKING: (255, 210, 40),
    Status.UNCERTAIN: (255, 130, 30),
    Status.LOST: (230, 50, 50),
}
_PARTICLE = (60, 220, 255)
_INK = (255, 255, 255)


class VideoRecorder:
    """Writes one frame a thirtieth of a simulated second; does nothing without a path."""

    def __init__(self, path: Path | None, config: TrialConfig) -> None:
        self._path = path
        self._title = f"{config.tracker}  {config.speed_mps:g} m/s  seed {config.seed}"
        self._writer: Generator[None, Any, None] | None = None
        self._steps = 0

    def __enter__(self) -> VideoRecorder:
        return self

    def __exit__(self, *_: object) -> None:
        if self._writer is not None:
            self._writer.close()

    def add(self, loop: Loop) -> None:
        """Draws the state after a control step."""
        self._steps += 1
        if self._path is None or self._steps % _EVERY:
            return
        frame = np.hstack([camera_view(loop, self._title), cell_view(loop)])
        if self._writer is None:
            self._writer = _open_writer(self._path, frame)
        self._writer.send(np.ascontiguousarray(frame))


def camera_view(loop: Loop, title: str) -> np.ndarray:
    """(h, w, 3) uint8, the newest image that has arrived, with the estimate that belongs to it."""
    assert loop.frame is not None, "a video needs a camera"
    image = np.array(loop.frame.whole[0])
    seen = loop.seen
    if seen is not None and len(seen.corners_px):
        _draw_points(image, seen.particles_px, _PARTICLE)
        _draw_outline(image, seen.corners_px, _COLOURS[seen.status])
    status = "" if seen is None else f"  {seen.status}"
    _caption(image, title, f"{loop.time_s:5.2f} s  {loop.grasp.phase}{status}")
    return image


def cell_view(loop: Loop) -> np.ndarray:
    """(h, w, 3) uint8 view of the whole cell."""
    image = np.array(loop.render_studio())
    held_s = loop.record.held_s
    if loop.record.is_success:
        _caption(image, "success: lifted and held")
    elif held_s > 0.0:
        _caption(image, f"held {held_s:.1f} s")
    return image


def _open_writer(path: Path, frame: np.ndarray) -> Generator[None, Any, None]:
    path.parent.mkdir(parents=True, exist_ok=True)
    height, width = frame.shape[:2]
    writer: Any = cast(Any, imageio_ffmpeg).write_frames(
        str(path),
        (width, height),
        fps=FRAME_HZ,
        quality=6,
        macro_block_size=2,
        ffmpeg_log_level="error",
    )
    writer.send(None)
    return writer


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


def _caption(image: np.ndarray, *lines: str) -> None:
    """White text on a dark band at the top, in place."""
    scale = image.shape[1] / 640.0
    band = round(26 * scale * len(lines) + 10 * scale)
    image[:band] = (image[:band] * 0.35).astype(np.uint8)
    for number, line in enumerate(lines):
        origin = round(12 * scale), round((24 + 26 * number) * scale)
        cv2.putText(
            image, line, origin, cv2.FONT_HERSHEY_SIMPLEX, 0.6 * scale, _INK, 1, cv2.LINE_AA
        )
