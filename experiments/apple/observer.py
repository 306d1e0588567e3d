"""What an estimator is told of a photograph: the view, and where the arm says the camera was."""

import numpy as np

from experiments.apple.photographs import Photograph
from sim.apple.world import intrinsics
from tracker.apple.segmentation import segment, view_of_masks
from tracker.apple.view import CameraPose, FruitView, Sighting

SEGMENTED, ORACLE = "segmented", "oracle"
MASKS = {
    SEGMENTED: "the fruit told from the image by colour",
    ORACLE: "control arm: the simulator's own masks of skin and calyx",
}


def sighting(photograph: Photograph, mask: str) -> Sighting:
    """The sighting by segmentation, or by the simulator's masks for the oracle."""
    T = photograph.reported_pose
    pose = CameraPose(T[:3, :3].copy(), T[:3, 3].copy())
    return Sighting(_view(photograph, mask), intrinsics(), pose)


def visible_share(photograph: Photograph, outline_px: np.ndarray) -> float:
    """Share of the fruit's disc (n, 2) [px] that nothing hides."""
    x, y = outline_px.T
    area = 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))
    return min(1.0, int(photograph.masks.fruit.sum()) / area)


def _view(photograph: Photograph, mask: str) -> FruitView:
    if mask == SEGMENTED:
        return segment(photograph.rgb)
    masks = photograph.masks
    return view_of_masks(photograph.rgb, masks.fruit & ~masks.calyx, masks.calyx)
