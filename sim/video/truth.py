"""What is true of the target on one image, from MuJoCo's state and camera alone.

Boxes and warps follow the conventions of the video benchmarks: pixel centres are integers counted
from 0, and a box (x, y, w, h) covers w x h pixels of which (x, y) is the first.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sim.video.surfaces import CORNERS, FRONT, Surface


@dataclass(frozen=True, eq=False)
class TargetTruth:
    """The target on one image, whether or not anything hides it."""

    box: np.ndarray
    """(4,) x, y, w, h [px] of the upright box around the whole target."""
    warp: np.ndarray
    """(3, 3) affine map from template coordinates (origin at the centre of the first image's box,
    unit sqrt(w h) of that box) to pixels, fitted to the target's front; exact where the front stays
    flat and square-on."""
    corners: np.ndarray
    """(4, 2) corners of the front [px]: top left, top right, bottom right, bottom left."""
    warp_error_px: float
    """Root mean square distance of the front's true points from where the warp puts them."""
    area_px: float
    """Area of the silhouette in the image, the part beyond its border included."""


class Surveyor:
    """Turns the target's vertices into its truth; the first image fixes the template coordinates.

    Args:
        surface: Mesh of the target.
        pixels: (n, 2) projections of its vertices on the first image.
    """

    def __init__(self, surface: Surface, pixels: np.ndarray) -> None:
        self._surface = surface
        box = upright_box(pixels)
        centre, unit = box[:2] + 0.5 * (box[2:] - 1.0), np.sqrt(box[2] * box[3])
        template = (pixels[FRONT] - centre) / unit
        self._template: np.ndarray = np.column_stack([template, np.ones(len(template))])
        self._inverse: np.ndarray = np.linalg.pinv(self._template)

    def truth(self, pixels: np.ndarray) -> TargetTruth:
        """The truth on an image on which the vertices project to `pixels` (n, 2)."""
        front = pixels[FRONT]
        rows = self._inverse @ front
        error = np.subtract(self._template @ rows, front)
        return TargetTruth(
            box=upright_box(pixels),
            warp=np.vstack([rows.T, [0.0, 0.0, 1.0]]),
            corners=pixels[CORNERS],
            warp_error_px=math.sqrt((error**2).sum(axis=1).mean()),
            area_px=_silhouette_px(self._surface, pixels),
        )


def upright_box(pixels: np.ndarray) -> np.ndarray:
    """(4,) x, y, w, h of the tightest box around points (n, 2).

    The first pixel of a box reaches from x - 0.5 to x + 0.5, hence the half.
    """
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    return np.concatenate([low + 0.5, high - low])


def _silhouette_px(surface: Surface, pixels: np.ndarray) -> float:
    """Summed area of the triangles that face the camera; exact as long as none hides another."""
    a, b, c = (pixels[surface.triangles[:, k]] for k in range(3))
    twice = (c - a)[:, 0] * (b - a)[:, 1] - (c - a)[:, 1] * (b - a)[:, 0]
    facing = np.maximum(twice, 0.0) if surface.is_closed else np.abs(twice)
    return 0.5 * float(facing.sum())
