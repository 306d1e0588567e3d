"""A tracker of one's own: the median motion of the corners in the box."""

import cv2
import numpy as np


class CornerFlow:
    """Run it here with `beltgrasp trial --tracker corner_flow:CornerFlow`."""

    def __init__(self, rng: np.random.Generator) -> None:
        del rng  # everything random must come from it; here nothing is

    def start(self, image: np.ndarray, box: np.ndarray) -> None:
        """Takes the target in `box` (x, y, w, h) of the BGR image."""
        self.box = np.array(box, float)
        self.grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)

    def find(self, image: np.ndarray) -> np.ndarray | None:
        """The box in the next image; None where no corner was found again."""
        before, self.grey = self.grey, cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        x, y, w, h = self.box.astype(int)
        inside = np.zeros_like(before)
        inside[max(y, 0) : y + h, max(x, 0) : x + w] = 255
        corners = cv2.goodFeaturesToTrack(before, 50, 0.01, 3, mask=inside)
        if corners is None:
            return None
        moved, found, _ = cv2.calcOpticalFlowPyrLK(before, self.grey, corners, None)
        steps = (moved - corners)[found.ravel() == 1]
        if not len(steps):
            return None
        self.box[:2] += np.median(steps.reshape(-1, 2), axis=0)
        return self.box.copy()
