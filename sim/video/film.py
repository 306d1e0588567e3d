"""Exposes the images of a clip, and surveys what is true of the target on each.

The truth comes from MuJoCo's state and camera alone. Boxes and warps follow the conventions of the
video benchmarks: pixel centres are integers counted from 0, and a box (x, y, w, h) covers w x h
pixels of which (x, y) is the first.
"""

import math
from collections.abc import Generator
from dataclasses import dataclass

import cv2
import mujoco
import numpy as np

from sim.geometry import project
from sim.imaging.camera import OffscreenRenderer
from sim.video.clip import HEIGHT_PX, WIDTH_PX, Clip
from sim.video.stage import CAMERA, TARGET, Stage, flex_id
from sim.video.surfaces import CORNERS, FRONT, Surface

_SUPERSAMPLING = 2
"""Each pixel is the mean of this many squared."""
_BLUR_STEP_PX = 1.0
"""Farthest that the target may move between two instants of an exposure."""
_SHUTTER_RAMP = 5.0
"""The shutter opens to its full time over this many frames: the first image is sharp."""


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


@dataclass(frozen=True, eq=False)
class FilmImage:
    """One image and what is true of it, in the middle of its exposure."""

    pixels: np.ndarray
    """(h, w, 3) uint8 RGB."""
    truth: TargetTruth
    visible: float
    """Share of the target's silhouette that can be seen, 0 to 1."""


def survey(clip: Clip, rng: np.random.Generator) -> list[TargetTruth]:
    """The truth of every image without rendering any; `rng` as for `shoot`."""
    stage = Stage(clip, rng.spawn(2)[0], is_painted=False)
    surveyor = Surveyor(stage.target, _target_px(stage, 0.0))
    return [surveyor.truth(_target_px(stage, float(k))) for k in range(clip.frame_count)]


def shoot(clip: Clip, rng: np.random.Generator) -> Generator[FilmImage, None, None]:
    """Yields the images of a clip; the same clip and state of `rng` give the same images."""
    stage_rng, noise_rng = rng.spawn(2)
    stage = Stage(clip, stage_rng)
    surveyor = Surveyor(stage.target, _target_px(stage, 0.0))
    size = _SUPERSAMPLING * WIDTH_PX, _SUPERSAMPLING * HEIGHT_PX
    with OffscreenRenderer(stage.model, *size) as renderer:
        for index in range(clip.frame_count):
            light = _expose(stage, renderer, float(index))
            noise = noise_rng.normal(0.0, clip.noise_levels, light.shape)
            truth = surveyor.truth(_target_px(stage, float(index)))
            yield FilmImage(
                pixels=np.clip(np.rint(light + noise), 0, 255).astype(np.uint8),
                truth=truth,
                visible=_visible(stage, renderer, truth.area_px),
            )


def _target_px(stage: Stage, time: float) -> np.ndarray:
    """(n, 2) pixels of the target's vertices at a time [frames]."""
    stage.show(time)
    return project(stage.projection(), stage.target_vertices_m())


def _expose(stage: Stage, renderer: OffscreenRenderer, time: float) -> np.ndarray:
    """(h, w, 3) float32 mean of the image over the time that the shutter is open."""
    open_frames = stage.clip.exposure_frames * min(1.0, time / _SHUTTER_RAMP)
    instants = _instants(stage, time, open_frames)
    total = np.zeros((HEIGHT_PX, WIDTH_PX, 3), np.float32)
    for instant in instants:
        stage.show(instant)
        rgb, _ = renderer.render(stage.model, stage.data, CAMERA)
        total += cv2.resize(
            rgb.astype(np.float32), (WIDTH_PX, HEIGHT_PX), interpolation=cv2.INTER_AREA
        )
    return total / len(instants)


def _instants(stage: Stage, time: float, open_frames: float) -> np.ndarray:
    """Times that divide an exposure, centred at `time`, into equal parts, and are their middles."""
    if open_frames == 0.0:
        return np.array([time])
    ends = (_target_px(stage, time + side * open_frames / 2) for side in (-1, 1))
    moved_px = float(np.linalg.norm(np.subtract(*ends), axis=1).max())
    count = max(1, int(np.ceil(moved_px / _BLUR_STEP_PX)))
    return time + open_frames * ((np.arange(count) + 0.5) / count - 0.5)


def _visible(stage: Stage, renderer: OffscreenRenderer, area_px: float) -> float:
    """Share of the silhouette that is in the image and in front of everything else."""
    kind, number = renderer.segment(stage.model, stage.data, CAMERA)
    target = flex_id(stage.model, TARGET)
    seen = np.count_nonzero((kind == int(mujoco.mjtObj.mjOBJ_FLEX)) & (number == target))
    return min(1.0, seen / _SUPERSAMPLING**2 / area_px)
