"""Every way to tell the axis from the images so far, under one name each."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from experiments.seeding import Stream, generator
from tracker.apple.attitude import unit
from tracker.apple.filters import (
    AxialFilter,
    PointFilterConfig,
    kalman_estimates,
    particle_estimates,
)
from tracker.apple.silhouette_fit import fit_silhouettes
from tracker.apple.single_view import SingleViewConfig, measure
from tracker.apple.view import Sighting


@dataclass(frozen=True, eq=False)
class Estimate:
    """What a method says after an image."""

    axis: np.ndarray
    """(3,) unit vector from calyx to stem, in the robot's frame."""
    sigma_deg: float | None = None
    """Its own uncertainty, root mean square of both directions; None where it tells none."""


Estimates = list[Estimate | None]
"""After each image; None before the first fruit was seen, or, of a single image, without one."""


@dataclass(frozen=True)
class AttitudeMethod:
    """A way to tell the axis."""

    description: str
    run: Callable[[Sequence[Sighting], int], Estimates]
    """Sightings in their order and the seed -> estimates."""
    is_fused: bool = True
    """Whether an estimate builds on the images before."""


def _single(form: str) -> Callable[[Sequence[Sighting], int], Estimates]:
    def run(sightings: Sequence[Sighting], seed: int) -> Estimates:
        del seed
        measured = [measure(sighting, SingleViewConfig(form=form)) for sighting in sightings]
        return [None if m is None else Estimate(m.axis) for m in measured]

    return run


def _filtered(
    form: str, estimate: Callable[[np.ndarray, int], np.ndarray]
) -> Callable[[Sequence[Sighting], int], Estimates]:
    """A filter of points over single-image attitudes; without a fruit it stays where it was."""

    def run(sightings: Sequence[Sighting], seed: int) -> Estimates:
        measured = [measure(sighting, SingleViewConfig(form=form)) for sighting in sightings]
        axes = [m.axis for m in measured if m is not None]
        if not axes:
            return [None] * len(sightings)
        told = iter(estimate(np.array(axes), seed))
        estimates: Estimates = []
        for m in measured:
            last = estimates[-1] if estimates else None
            estimates.append(last if m is None else Estimate(unit(next(told))))
        return estimates

    return run


def _particles(measurements: np.ndarray, seed: int) -> np.ndarray:
    rng = generator(seed, Stream.TRACKER, "apple particles")
    return particle_estimates(measurements, PointFilterConfig(), rng)


def _kalman(measurements: np.ndarray, seed: int) -> np.ndarray:
    del seed
    return kalman_estimates(measurements, PointFilterConfig())


def _axial(sightings: Sequence[Sighting], seed: int) -> Estimates:
    del seed
    fused, estimates = AxialFilter(), Estimates()
    for sighting in sightings:
        measurement = measure(sighting)
        if measurement is not None:
            fused.update(measurement)
            sigma = np.degrees(np.sqrt(np.trace(fused.covariance)))
            estimates.append(Estimate(fused.axis, float(sigma)))
        else:
            estimates.append(estimates[-1] if estimates else None)
    return estimates


def _silhouettes(sightings: Sequence[Sighting], seed: int) -> Estimates:
    del seed
    fits = [fit_silhouettes(sightings[: count + 1]) for count in range(len(sightings))]
    return [None if fit is None else Estimate(fit.axis, fit.axis_sigma_deg) for fit in fits]


METHODS = {
    "single-paper": AttitudeMethod(
        "each image alone, by the formulas as printed", _single("paper"), is_fused=False
    ),
    "single-perspective": AttitudeMethod(
        "each image alone, in perspective", _single("perspective"), is_fused=False
    ),
    "particle-paper": AttitudeMethod(
        "the published method: 200 particles over the formulas as printed",
        _filtered("paper", _particles),
    ),
    "kalman-paper": AttitudeMethod(
        "the exact filter of the same model", _filtered("paper", _kalman)
    ),
    "particle-perspective": AttitudeMethod(
        "the published filter over the formulas in perspective",
        _filtered("perspective", _particles),
    ),
    "axial": AttitudeMethod("a filter on the sphere over the formulas in perspective", _axial),
    "silhouettes": AttitudeMethod(
        "one spheroid fitted to the outlines of all images", _silhouettes
    ),
}
"""Every method that the rendered experiments compare."""
