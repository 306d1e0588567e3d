"""A store of the landmarks' patches as they were first seen: all in one picture.

One picture, because OpenCV's Lucas-Kanade compares many points of two pictures in one call.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

SLOT_PX = 32
"""Side of a slot; a patch fills it but for one pixel."""
_REACH_PX = SLOT_PX // 2 - 1


class PatchStore:
    """As many patches as slots fit into a picture of the camera's size.

    Args:
        shape: Rows and columns of the camera's images.
    """

    def __init__(self, shape: tuple[int, int]) -> None:
        rows, columns = (np.arange(SLOT_PX // 2, n - SLOT_PX // 2 + 1, SLOT_PX) for n in shape)
        x, y = np.meshgrid(columns, rows)
        self.centres_px: NDArray[np.float32] = np.column_stack([x.ravel(), y.ravel()]).astype(
            np.float32
        )
        """(n, 2) the middle of each slot, which is the landmark."""
        self.picture: NDArray[np.uint8] = np.zeros(shape, np.uint8)

    def __len__(self) -> int:
        return len(self.centres_px)

    def keep(self, slot: int, grey: NDArray[np.uint8], point_px: NDArray[np.float32]) -> None:
        """Puts what is around a point of an image into a slot, sampled between the pixels."""
        side = 2 * _REACH_PX + 1
        x, y = (round(float(value)) for value in self.centres_px[slot])
        patch = cv2.getRectSubPix(grey, (side, side), (float(point_px[0]), float(point_px[1])))
        rows = slice(y - _REACH_PX, y + _REACH_PX + 1)
        self.picture[rows, x - _REACH_PX : x + _REACH_PX + 1] = patch
