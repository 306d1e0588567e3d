"""Exposes the images of a clip and surveys the target on each."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

import cv2
import mujoco
import numpy as np

from sim.geometry import project
from sim.imaging.camera import OffscreenRenderer
from sim.video.clip import HEIGHT_PX, WIDTH_PX, Clip
from sim.video.stage import CAMERA, TARGET, Stage, flex_id
from sim.video.truth import Surveyor, TargetTruth

_SUPERSAMPLING = 2
"""Each pixel is the mean of this many squared."""
_BLUR_STEP_PX = 1.0
"""Farthest that the target may move between two instants of an exposure."""
_SHUTTER_RAMP = 5.0
"""The shutter opens to its full time over this many frames: the first image is sharp."""


@dataclass(frozen=True, eq=False)
class Frame:
    """One image and what is true of it, in the middle of its exposure."""

    image: np.ndarray
    """(h, w, 3) uint8 RGB."""
    truth: TargetTruth
    visible: float
    """Share of the target's silhouette that can be seen, 0 to 1."""


def survey(clip: Clip, rng: np.random.Generator) -> list[TargetTruth]:
    """The truth of every frame without rendering any; `rng` as for `shoot`."""
    stage = Stage(clip, rng.spawn(2)[0], is_painted=False)
    surveyor = Surveyor(stage.target, _target_px(stage, 0.0))
    return [surveyor.truth(_target_px(stage, float(k))) for k in range(clip.frame_count)]


def shoot(clip: Clip, rng: np.random.Generator) -> Generator[Frame, None, None]:
    """Yields the frames of a clip; the same clip and state of `rng` give the same frames."""
    stage_rng, noise_rng = rng.spawn(2)
    stage = Stage(clip, stage_rng)
    surveyor = Surveyor(stage.target, _target_px(stage, 0.0))
    size = _SUPERSAMPLING * WIDTH_PX, _SUPERSAMPLING * HEIGHT_PX
    with OffscreenRenderer(stage.model, *size) as renderer:
        for index in range(clip.frame_count):
            light = _expose(stage, renderer, float(index))
            noise = noise_rng.normal(0.0, clip.noise_levels, light.shape)
            truth = surveyor.truth(_target_px(stage, float(index)))
            yield Frame(
                image=np.clip(np.rint(light + noise), 0, 255).astype(np.uint8),
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
