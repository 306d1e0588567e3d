"""The pilot of a run: settings of the study and of the controller, and its random streams."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from experiments.bearing_only.config import FlightRun
from experiments.bearing_only.controllers import get_controller
from experiments.bearing_only.studies import STUDIES
from experiments.seeding import Stream, generator
from tracker.bearing_only.control import ControlConfig, DifferentialDrive
from tracker.bearing_only.measurements import PinholeCamera
from tracker.bearing_only.pilot import PilotConfig
from tracker.bearing_only.slam import SlamConfig
from tracker.bearing_only.target_filter import TargetNoise

INDOOR_SCALE = 0.02
"""Of accelerations indoors beside those of the flights: speed squared over distance."""

CORNER_STD_PX = 2.0
"""Of corners that are followed in images: they are 0.2 px exact from one image to the next, but
creep, and an error that lasts counts for more than noise of its size."""
TARGET_STD_PX = 1.0
"""Of the centroid of the target's colour, with some room for an outline that is partly hidden."""
CORNER_CAPACITY = 60
"""Landmarks of a map of corners: one that is lost never comes back and can go."""


def rng_of(run: FlightRun, source: str) -> np.random.Generator:
    """The generator of one noise source; it knows seed and source, not the controller."""
    return generator(run.seed, Stream.FLIGHT, source)


class NoiseDraws:
    """Standard normal numbers of each step, for one flight or for several at once."""

    def __init__(self, rngs: Sequence[np.random.Generator], is_single: bool) -> None:
        self._rngs, self._is_single = rngs, is_single

    def __call__(self) -> NDArray[np.float64]:
        """(3,) or (flights, 3)."""
        draws = [rng.standard_normal(3) for rng in self._rngs]
        return draws[0] if self._is_single else np.stack(draws)


def pilot_config(run: FlightRun) -> PilotConfig:
    """Settings of the run's pilot."""
    controller, is_indoors = get_controller(run.controller), run.study == "robot"
    scale, usual = INDOOR_SCALE if is_indoors else 1.0, TargetNoise()
    return PilotConfig(
        camera=camera_of(run),
        control=ControlConfig(
            manoeuvre=controller.manoeuvre,
            v_max_mps=run.v_max_mps,
            equilibrium_m=STUDIES[run.study].equilibrium_m,
            steepness_per_m=1.0 if is_indoors else 0.5,
            floor_share=controller.floor_share,
        ),
        target_model=controller.target_model,
        target_noise=TargetNoise(
            pixel_std_px=TARGET_STD_PX if run.is_rendered else usual.pixel_std_px,
            acceleration_std_mps2=scale * controller.acceleration_std_mps2,
            turn_acceleration_std_mps2=scale * usual.turn_acceleration_std_mps2,
        ),
        dt_s=0.1 if is_indoors else 0.05,
        drive=DifferentialDrive() if is_indoors else None,
    )


def camera_of(run: FlightRun) -> PinholeCamera:
    """The camera as its calibration tells it."""
    return PinholeCamera(s_u_px=525.0, s_v_px=525.0) if run.study == "robot" else PinholeCamera()


def slam_config(run: FlightRun) -> SlamConfig:
    """Settings of the run's map; indoors everything is nearer."""
    if run.is_rendered:
        return SlamConfig(
            pixel_std_px=CORNER_STD_PX,
            rho_per_m=0.06,
            rho_std_per_m=0.03,
            capacity=CORNER_CAPACITY,
        )
    if run.study != "robot":
        return SlamConfig()
    return SlamConfig(
        camera=camera_of(run),
        odometry_std_m=0.001,
        odometry_std_rad=math.radians(0.05),
        rho_per_m=0.3,
        rho_std_per_m=1.0,
    )
