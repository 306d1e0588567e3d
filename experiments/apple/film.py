"""Films an approach: the camera's view with what is estimated, beside the arm at the tree.

Between the views at which the attitude is estimated the camera keeps filming; the outline drawn is
that of each image's own segmentation, the axis that of the fit to the views so far.
"""

import math
from pathlib import Path

import cv2
import numpy as np

from experiments.apple.approach import ApproachJob
from experiments.apple.photographs import SEGMENTED, ArmPhotographer, Photograph, sighting
from experiments.apple.viewpoints import VIEWS
from experiments.apple.worlds import World, draw_world
from experiments.report.movie import Movie, caption
from sim.apple.eye_in_hand import camera_pose
from sim.apple.world import HAND_CAMERA, STUDIO, Orchard, intrinsics
from tracker.apple.attitude import axis_error_deg, tangent_basis
from tracker.apple.segmentation import segment
from tracker.apple.silhouette_fit import SilhouetteFit, fit_silhouettes
from tracker.apple.spheroid import Spheroid
from tracker.apple.view import CameraPose, FruitView, Sighting
from tracker.geometry import project

_FPS = 20
_EVERY = 6
"""Control steps of the arm, 120 a second, to an image of the film."""
_HOLD = 10
"""Images for which the film rests at a view."""
_OUTLINE, _CONTOUR, _AXIS, _CALYX = (70, 220, 255), (255, 240, 60), (255, 255, 255), (255, 80, 220)
_SURE, _UNSURE = (90, 230, 110), (255, 150, 50)
_SURE_DEG = 3.0


def film_approach(job: ApproachJob, path: Path) -> None:
    """Writes an MP4 of one world."""
    world = draw_world(job.world)
    with world.build() as orchard, Movie(path, _FPS) as movie:
        film = _Film(orchard, world, job, movie)
        photographer = ArmPhotographer(orchard, job.world.seed)
        photographer.on_move = film.moved

        def take(T_world_camera: np.ndarray) -> Photograph | None:
            photograph = photographer(T_world_camera)
            if photograph is not None:
                film.seen(photograph)
            return photograph

        VIEWS[job.views].take(world.approach, take, job.world.seed)


class _Film:
    """Draws and writes the images."""

    def __init__(self, orchard: Orchard, world: World, job: ApproachJob, movie: Movie) -> None:
        self._orchard, self._world, self._movie = orchard, world, movie
        self._title = f"{job.world.fruit_class}, aspect {job.world.aspect:g}, {job.views}"
        self._sightings: list[Sighting] = []
        self._fit: SilhouetteFit | None = None
        self._steps = 0

    def moved(self, q_rad: np.ndarray) -> None:
        """The arm is on its way."""
        self._steps += 1
        if self._steps % _EVERY:
            return
        self._orchard.set_arm(q_rad)
        image = self._orchard.render(HAND_CAMERA, shadows=True)
        T = camera_pose(q_rad)
        self._write(image, segment(image), CameraPose(T[:3, :3].copy(), T[:3, 3].copy()))

    def seen(self, photograph: Photograph) -> None:
        """A view was taken: the fit takes it in, and the film rests."""
        self._sightings.append(sighting(photograph, SEGMENTED))
        self._fit = fit_silhouettes(self._sightings)
        for _ in range(_HOLD):
            self._write(photograph.rgb, self._sightings[-1].view, true_pose(photograph))

    def _write(self, image: np.ndarray, view: FruitView, pose: CameraPose) -> None:
        lines = [f"{self._title}   view {len(self._sightings)}   {view.status}"]
        if self._fit is not None:
            error = float(axis_error_deg(self._fit.axis, self._world.fruit.axis))
            told = f"axis within {self._fit.axis_sigma_deg:.1f} deg by its own account"
            lines.append(f"{told}, {error:.1f} deg off in truth")
        drawn = draw_view(image, view, self._fit, pose)
        caption(drawn, *lines)
        studio = np.array(self._orchard.render(STUDIO, shadows=True))
        self._movie.add(np.hstack([drawn, studio]))


def true_pose(photograph: Photograph) -> CameraPose:
    """Where the camera really was, so that what is drawn lies where the estimate puts it."""
    T = photograph.true_pose
    return CameraPose(T[:3, :3].copy(), T[:3, 3].copy())


def draw_view(
    image: np.ndarray, view: FruitView, fit: SilhouetteFit | None, pose: CameraPose
) -> np.ndarray:
    """(h, w, 3) uint8 the image with outline points, calyx, the fitted fruit and its axis."""
    drawn = np.array(image)
    if view.is_found:
        for point in view.contour_px[::2]:
            cv2.circle(drawn, _pixel(point), 8, _CONTOUR, -1, cv2.LINE_AA, 4)
        if view.calyx_px is not None:
            cv2.circle(drawn, _pixel(view.calyx_px), 16 * 6, _CALYX, 2, cv2.LINE_AA, 4)
    if fit is not None and _is_in_front(fit.fruit, pose):
        outline = fit.fruit.outline_px(intrinsics(), pose)
        points = np.rint(16.0 * np.clip(outline, -1e4, 1e4)).astype(np.int32)
        cv2.polylines(drawn, [points], True, _OUTLINE, 1, cv2.LINE_AA, shift=4)
        _draw_axis(drawn, fit, pose)
    return drawn


def _draw_axis(image: np.ndarray, fit: SilhouetteFit, pose: CameraPose) -> None:
    """An arrow from the calyx to beyond the stem, and around its tip where it may be (95 %)."""
    fruit = fit.fruit
    reach_m = 1.9 * fruit.radius_m * fruit.aspect
    colour = _SURE if fit.axis_sigma_deg < _SURE_DEG else _UNSURE
    values, vectors = np.linalg.eigh((E := tangent_basis(fruit.axis)).T @ fit.axis_covariance @ E)
    radii = np.minimum(np.sqrt(5.991 * np.maximum(values, 0.0)), math.radians(80.0))
    turn = np.linspace(0.0, 2.0 * math.pi, 48, endpoint=False)
    ring = (np.stack([np.cos(turn), np.sin(turn)], axis=1) * np.tan(radii)) @ vectors.T @ E.T
    tips = fruit.axis + ring
    tips /= np.linalg.norm(tips, axis=1, keepdims=True)
    ends = _project(np.vstack([fruit.centre_m + reach_m * tips]), pose)
    outline = np.rint(16.0 * np.clip(ends, -1e4, 1e4)).astype(np.int32)
    cv2.polylines(image, [outline], True, colour, 2, cv2.LINE_AA, shift=4)
    calyx, tip = _project(np.stack([fruit.calyx_m, fruit.centre_m + reach_m * fruit.axis]), pose)
    cv2.arrowedLine(image, _pixel(calyx), _pixel(tip), _AXIS, 2, cv2.LINE_AA, 4, 0.12)


def _project(points_m: np.ndarray, pose: CameraPose) -> np.ndarray:
    return project((points_m - pose.position_m) @ pose.rotation, intrinsics())


def _is_in_front(fruit: Spheroid, pose: CameraPose) -> bool:
    depth_m = float(pose.rotation[:, 2] @ (fruit.centre_m - pose.position_m))
    return depth_m > 3.0 * fruit.radius_m


def _pixel(point: np.ndarray) -> tuple[int, int]:
    x, y = np.rint(16.0 * np.clip(point, -1e4, 1e4)).astype(int)
    return int(x), int(y)
