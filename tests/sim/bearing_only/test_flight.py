import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sim.bearing_only.flight import (
    DRAWS,
    Flight,
    FlightCamera,
    FlightConfig,
    FlightDraws,
    TargetPath,
)

STILL = {"odometry_std_m": 0.0, "odometry_std_rad": 0.0}


def draws(config, seed=0):
    rngs = {name: np.random.default_rng([seed, i]) for i, name in enumerate(DRAWS)}
    return FlightDraws.of(config, rngs)


def test_the_circle_is_closed_after_five_hundred_steps():
    path = TargetPath()
    for k in (0, 125, 500):
        position, velocity = path.at(0.05 * k)
        assert np.isclose(np.linalg.norm(velocity), 2.0)
        assert np.isclose(position[2], 1.0)
    assert np.allclose(path.at(25.0)[0], path.at(0.0)[0])
    assert np.isclose(np.linalg.norm(path.at(12.5)[0] - path.at(0.0)[0]), 50.0 / np.pi)


@pytest.mark.parametrize("kind", ["line", "circle"])
def test_the_velocity_is_that_of_the_position(kind):
    path = TargetPath(kind, velocity_mps=(-1.0, 0.5, 0.1))
    ahead, behind = path.at(3.0 + 1e-5)[0], path.at(3.0 - 1e-5)[0]
    assert np.allclose((ahead - behind) / 2e-5, path.at(3.0)[1], atol=1e-8)


def test_the_camera_by_hand():
    pixel, is_seen = FlightCamera().see(np.array([2.0, 1.0, -0.5]))  # 1 m left, 0.5 m down
    assert np.allclose(pixel, [320.0 - 160.0, 240.0 + 80.0])
    assert is_seen
    assert not FlightCamera().see(np.array([-2.0, 0.0, 0.0]))[1]
    assert not FlightCamera().see(np.array([2.0, 2.1, 0.0]))[1]


def test_the_vehicle_moves_in_the_frame_it_had_before_it_turned():
    config = FlightConfig(yaw_rad=np.pi / 2, landmark_count=0, **STILL)
    flight = Flight(config, draws(config))
    flight.move(np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, np.pi / 2]))
    assert np.allclose(flight.position_m, [10.0, 16.0, 1.0])
    assert np.allclose(flight.R_world_body, Rotation.from_euler("z", np.pi).as_matrix(), atol=1e-12)
    assert flight.iteration == 1


def test_noise_has_the_size_it_should():
    config = FlightConfig(iteration_count=2000, landmark_count=0)
    flight = Flight(config, draws(config))
    for _ in range(1999):
        flight.move(np.zeros(3), np.zeros(3))
    spread = np.linalg.norm(flight.position_m - config.start_m) / np.sqrt(3 * 1999)
    assert 0.002 < spread < 0.03


def test_a_planar_vehicle_stays_in_its_plane():
    config = FlightConfig(is_planar=True, landmark_count=0)
    flight = Flight(config, draws(config))
    for _ in range(50):
        flight.move(np.array([0.1, 0.0, 0.1]), np.array([0.1, 0.1, 0.1]))
    assert flight.position_m[2] == 1.0
    assert np.allclose(flight.R_world_body[2], [0.0, 0.0, 1.0])


def test_two_controllers_meet_the_same_noise_wherever_they_fly():
    config = FlightConfig(landmark_count=50, pixel_std_px=3.0)
    flights = [Flight(config, draws(config)) for _ in range(2)]
    for _ in range(5):
        flights[0].move(np.zeros(3), np.zeros(3))
        flights[1].move(np.array([0.1, 0.1, 0.0]), np.array([0.0, 0.0, 0.1]))
    errors = []
    for flight in flights:
        in_body = (flight.target_m - flight.position_m) @ flight.R_world_body
        errors.append(flight.look().target_px - config.camera.see(in_body)[0])
    assert np.allclose(errors[0], errors[1])


def test_several_flights_at_once_are_each_as_alone():
    config = FlightConfig(landmark_count=0)
    both = Flight(config, FlightDraws.stack([draws(config, 1), draws(config, 2)]))
    alone = [Flight(config, draws(config, seed)) for seed in (1, 2)]
    for flight in (both, *alone):
        flight.move(np.array([0.1, 0.0, 0.0]), np.array([0.0, 0.01, 0.02]))
    assert np.allclose(both.look().target_px, [flight.look().target_px for flight in alone])
    assert both.look().landmark_ids.size == 0


def test_what_the_camera_gives_is_in_the_image():
    config = FlightConfig()
    sight = Flight(config, draws(config)).look()
    assert 10 < len(sight.landmark_ids) < 200
    assert config.camera.contains(sight.landmark_px).all()
    assert sight.is_target_seen


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: FlightConfig(landmark_count=-1), "landmark_count must be 0 or greater, got -1"),
        (lambda: FlightConfig(dt_s=0.0), "dt_s must be a positive number, got 0.0"),
        (lambda: FlightConfig(odometry_std_m=float("nan")), "odometry_std_m must be 0 or greater"),
        (lambda: FlightConfig(iteration_count=0), "iteration_count must be 1 or greater, got 0"),
        (lambda: TargetPath("spiral"), "kind must be line or circle; got 'spiral'"),
        (lambda: TargetPath(velocity_mps=(float("inf"), 0, 0)), "must be finite"),
        (lambda: TargetPath(circle_length_m=0.0), "circle_length_m must be a positive number"),
    ],
)
def test_impossible_worlds_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()
