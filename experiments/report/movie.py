"""A film as an MP4 file, and captions on its pictures."""

from collections.abc import Generator
from pathlib import Path
from typing import Any, Self, cast

import cv2
import imageio_ffmpeg
import numpy as np

INK = (255, 255, 255)


class Movie:
    """Writes pictures of one size to a file, which begins with the first of them.

    Without a path nothing is written. A context manager: the file is whole when it is left.
    """

    def __init__(self, path: Path | None, rate_hz: int) -> None:
        """Names the file and the pictures a second."""
        self.path, self._rate_hz = path, rate_hz
        self._writer: Generator[None, Any, None] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._writer is not None:
            self._writer.close()

    @property
    def is_empty(self) -> bool:
        """Whether no picture has come yet, so that there is no file."""
        return self._writer is None

    def add(self, picture: np.ndarray) -> None:
        """Appends an (h, w, 3) uint8 RGB picture; h and w are even."""
        if self.path is None:
            return
        if self._writer is None:
            self._writer = self._open(self.path, picture)
        self._writer.send(np.ascontiguousarray(picture))

    def _open(self, path: Path, picture: np.ndarray) -> Generator[None, Any, None]:
        path.parent.mkdir(parents=True, exist_ok=True)
        height, width = picture.shape[:2]
        writer: Any = cast(Any, imageio_ffmpeg).write_frames(
            str(path),
            (width, height),
            fps=self._rate_hz,
            quality=6,
            macro_block_size=2,
            ffmpeg_log_level="error",
        )
        writer.send(None)
        return writer


def caption(image: np.ndarray, *lines: str) -> None:
    """Writes white text on a dark band at the top, in place; it grows with the image."""
    scale = image.shape[1] / 640.0
    band = round(26 * scale * len(lines) + 10 * scale)
    image[:band] = (image[:band] * 0.35).astype(np.uint8)
    for number, line in enumerate(lines):
        origin = round(12 * scale), round((24 + 26 * number) * scale)
        cv2.putText(image, line, origin, cv2.FONT_HERSHEY_SIMPLEX, 0.6 * scale, INK, 1, cv2.LINE_AA)
