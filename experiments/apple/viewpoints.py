"""Ways to choose where the camera goes next, under one name each."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from experiments.apple.photographs import SEGMENTED, Photograph, Photographer, sighting
from experiments.apple.worlds import pointed
from experiments.seeding import Stream, generator
from sim.apple.world import HEIGHT_PX, WIDTH_PX, intrinsics
from tracker.apple.next_view import predicted_sigmas_deg, views_around
from tracker.apple.silhouette_fit import SilhouetteFit, fit_silhouettes
from tracker.apple.view import CameraPose, Sighting

_PLANNED = 2
"""Views of the planned approach before the first choice."""
_CANDIDATES = 40
_CAP_RAD = math.radians(75.0)
_APART_RAD = math.radians(12.0)
"""A place so near to one that was seen from, as the fruit sees it, is no new one."""
_TRIES = 12
"""So many of the best places are tried before the planned one is taken."""


@dataclass(frozen=True)
class Viewing:
    """A way to choose the views."""

    description: str
    take: Callable[[Sequence[np.ndarray], Photographer, int], list[Photograph]]
    """Planned poses (4, 4) of the approach, what takes pictures, and the seed -> photographs."""


def along_the_arc(planned: Sequence[np.ndarray], take: Photographer, seed: int) -> list[Photograph]:
    """The planned approach, whatever is seen."""
    del seed
    return [photograph for T in planned if (photograph := take(T)) is not None]


def next_best(planned: Sequence[np.ndarray], take: Photographer, seed: int) -> list[Photograph]:
    """At the planned distances, from the side after which the axis should be known best.

    The first two views are the planned ones. Every later choice is made by the fit to the images
    so far; where the arm cannot go, the next best place is tried.
    """
    rng = generator(seed, Stream.TRACKER, "apple aim")
    photographs = along_the_arc(planned[:_PLANNED], take, seed)
    sightings = [sighting(photograph, SEGMENTED) for photograph in photographs]
    for T in planned[_PLANNED:]:
        fit = fit_silhouettes(sightings)
        photograph = None if fit is None else _best_reachable(fit, sightings, T, take, rng)
        photograph = take(T) if photograph is None else photograph
        if photograph is not None:
            photographs.append(photograph)
            sightings.append(sighting(photograph, SEGMENTED))
    return photographs


def _best_reachable(
    fit: SilhouetteFit,
    sightings: Sequence[Sighting],
    planned: np.ndarray,
    take: Photographer,
    rng: np.random.Generator,
) -> Photograph | None:
    """The photograph from the best place that the arm reaches; None if it reaches none of them."""
    centre = fit.fruit.centre_m
    seen_from = np.array([s.pose.position_m - centre for s in sightings])
    seen_from /= np.linalg.norm(seen_from, axis=1, keepdims=True)
    distance_m = float(np.linalg.norm(planned[:3, 3] - centre))
    around = views_around(centre, seen_from[0], distance_m, _CAP_RAD, _CANDIDATES)
    candidates = [pose for pose in around if _is_new(pose, centre, seen_from)]
    sigmas = predicted_sigmas_deg(fit, candidates, intrinsics(), (WIDTH_PX, HEIGHT_PX))
    order: list[int] = np.argsort(sigmas, kind="stable")[:_TRIES].tolist()
    for index in order:
        if np.isfinite(sigmas[index]):
            photograph = take(pointed(candidates[index].position_m, centre, rng))
            if photograph is not None:
                return photograph
    return None


def _is_new(pose: CameraPose, centre_m: np.ndarray, seen_from: np.ndarray) -> bool:
    direction = pose.position_m - centre_m
    cosine = float((seen_from @ direction).max()) / float(np.linalg.norm(direction))
    return cosine < math.cos(_APART_RAD)


VIEWS = {
    "arc": Viewing("an arc of 50 degrees from 0.60 to 0.22 m, as planned", along_the_arc),
    "next-best": Viewing(
        "at the same distances, where the axis should be known best afterwards", next_best
    ),
}
"""Every way to choose views."""
