"""One iteration of the bearing-only pilot, and a whole study with the known pose."""

from dataclasses import replace

import numpy as np
import pytest

from experiments.bearing_only.config import FlightRun
from experiments.bearing_only.flying import fly
from experiments.bearing_only.pilots import NoiseDraws, pilot_config, rng_of, slam_config
from experiments.bearing_only.sensor_models import PointSensorModel
from experiments.bearing_only.studies import world_of
from sim.bearing_only.flight import DRAWS, Flight, FlightDraws
from tracker.bearing_only.measurements import BodyIncrement, PoseBelief
from tracker.bearing_only.pilot import BearingPilot, TargetPrior
from tracker.bearing_only.slam import MonocularSlam

RUN = FlightRun("circle", "gradient", seed=1000, landmark_count=200)


@pytest.mark.parametrize("landmark_count", [100, 200])
@pytest.mark.parametrize("controller", ["gradient", "turn"])
def test_an_iteration_of_the_pilot(benchmark, controller, landmark_count):
    """Every iteration of a flight of 400 is a round: the map grows as it does in use."""
    run = replace(RUN, controller=controller, landmark_count=landmark_count)
    config = world_of(run)
    flight = Flight(config, FlightDraws.of(config, {name: rng_of(run, name) for name in DRAWS}))
    start = PoseBelief(flight.position_m, flight.R_world_body, np.zeros((6, 6)))
    slam = MonocularSlam(slam_config(run), start)
    noise_draws = NoiseDraws([rng_of(run, "whims")], is_single=True)
    pilot = BearingPilot(pilot_config(run), slam, TargetPrior(11.0, 2.0), noise_draws)
    sensors = PointSensorModel(flight)
    motion = pilot.step(sensors.measure(BodyIncrement.none()))

    def following():
        increment = motion.increment
        flight.move(increment.displacement_m, increment.rotation_rad)
        return (sensors.measure(increment),), {}

    def step(measurements):
        nonlocal motion
        motion = pilot.step(measurements)

    benchmark.pedantic(step, setup=following, rounds=400)
    assert pilot.status == "tracking"


def test_a_study_of_a_hundred_flights_with_the_known_pose(benchmark):
    runs = [replace(RUN, controller="known-pose", seed=seed) for seed in range(1000, 1100)]
    flown = benchmark.pedantic(fly, args=(runs,), rounds=1)
    assert flown.error is None
