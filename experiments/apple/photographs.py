"""Takes the pictures: drives the arm's camera to a view, and keeps what it saw and said.

Truth (true pose, masks) stays in the photograph for scoring and for the oracle; `sighting` is what
an estimator gets of it: the view, and where the arm says the camera was.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from experiments.seeding import Stream, generator
from sim.apple.eye_in_hand import EyeInHand, PoseNoise, camera_pose
from sim.apple.world import FREE_CAMERA, HAND_CAMERA, Masks, Orchard, intrinsics
from tracker.apple.segmentation import segment, view_of_masks
from tracker.apple.view import CameraPose, FruitView, Sighting

SEGMENTED, ORACLE = "segmented", "oracle"
MASKS = {
    SEGMENTED: "the fruit told from the image by colour",
    ORACLE: "control arm: the simulator's own masks of skin and calyx",
}
_NOISE_LEVELS = 3.0


@dataclass(frozen=True, eq=False)
class Photograph:
    """One image with what is known of it and what is true."""

    rgb: np.ndarray
    """(h, w, 3) uint8, with the sensor's noise."""
    reported_pose: np.ndarray
    """(4, 4) T_world_camera that the arm tells."""
    true_pose: np.ndarray
    """(4, 4) T_world_camera in the simulator."""
    masks: Masks
    by_arm: bool
    """Whether the arm carried the camera; a free one took the picture where it cannot reach."""


class Photographer(Protocol):
    """Takes the next picture from a pose (4, 4); None where that is out of reach."""

    def __call__(self, T_world_camera: np.ndarray) -> Photograph | None:
        """The picture."""
        ...


class ArmPhotographer:
    """Pictures by the camera in the arm's hand.

    The noise of the n-th picture and pose depends on the seed and n alone, so that ways to choose
    the views meet the same draws.
    """

    def __init__(
        self,
        orchard: Orchard,
        seed: int,
        pose_noise: PoseNoise | None = None,
        *,
        free_if_unreachable: bool = False,
    ) -> None:
        self._orchard, self._seed = orchard, seed
        self._pose_noise = PoseNoise() if pose_noise is None else pose_noise
        self._free_if_unreachable = free_if_unreachable
        self._count = 0
        self.arm = EyeInHand(orchard.model)
        self.on_move: Callable[[np.ndarray], None] | None = None
        """Called with the joint angles (6,) of every control step on the way."""

    def __call__(self, T_world_camera: np.ndarray) -> Photograph | None:
        """Drives there and takes the picture."""
        is_there = self.arm.reach(T_world_camera, self.on_move)
        if not (is_there or self._free_if_unreachable):
            return None
        if is_there:
            self._orchard.set_arm(self.arm.q_rad)
            camera, told = HAND_CAMERA, camera_pose(self.arm.q_rad)
        else:
            self._orchard.set_free_camera(T_world_camera)
            camera, told = FREE_CAMERA, T_world_camera
        sensor, arm = (
            generator(self._seed, Stream.SENSOR, f"apple {what} {self._count}")
            for what in ("pixels", "pose")
        )
        self._count += 1
        clean = self._orchard.render(camera, shadows=True)
        noise = sensor.standard_normal(clean.shape, np.float32) * np.float32(_NOISE_LEVELS)
        return Photograph(
            rgb=np.clip(np.rint(clean + noise), 0, 255).astype(np.uint8),
            reported_pose=self._pose_noise.disturbed(told, arm),
            true_pose=self._orchard.camera_pose(camera),
            masks=self._orchard.masks(camera),
            by_arm=is_there,
        )


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
