"""Flights from rendered images: the command, the sensors, the film and what is refused."""

import csv
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from experiments import cli
from experiments.bearing_only.config import FlightRun
from experiments.bearing_only.film import ImageFilm, colour_of
from experiments.bearing_only.flying import fly
from experiments.bearing_only.run import results_of
from experiments.bearing_only.sensor_models import ImageSensorModel, PointSensorModel
from experiments.bearing_only.studies import STUDIES, world_of

RUN = FlightRun("circle-pixels", "log-det", seed=1000, iteration_count=12)


def command(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "experiments.cli", *words],
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_command_flies_films_and_reports(tmp_path: Path):
    words = (
        "bearing-only",
        "circle",
        "--pixels",
        "--controllers",
        "turn",
        "--seeds",
        "1",
        "--first-seed",
        "1000",
    )
    words = (*words, "--iterations", "12", "--workers", "1", "--out", str(tmp_path))
    run = command(*words, "--video", "all")
    assert run.returncode == 0, run.stderr
    rows = list(csv.DictReader((tmp_path / "rows.csv").open()))
    assert [row["outcome"] for row in rows] == ["tracked"]
    assert rows[0]["study"] == "circle-pixels" and rows[0]["landmark_count"] == "0"
    assert 0.0 < float(rows[0]["target_error_m"]) < 3.0
    assert 0.0 < float(rows[0]["robot_error_m"]) < 0.2
    assert float(rows[0]["landmarks_in_view"]) > 15
    assert float(rows[0]["seen_share"]) == 1.0
    (video,) = (tmp_path / "videos").iterdir()
    assert (
        video.name.startswith("PASS_tracked_circle-pixels_turn_") and video.stat().st_size > 10_000
    )
    before = (tmp_path / "rows.csv").read_bytes()
    assert command(*words).returncode == 0
    assert (tmp_path / "rows.csv").read_bytes() == before
    report = command("report", str(tmp_path))
    assert report.returncode == 0, report.stderr
    assert (tmp_path / "tables" / "errors.md").exists()


def test_an_image_tells_where_the_target_is():
    """CamShift's pixel is that of the world's target, seen from the world's pose."""
    errors, counts = [], []

    def watch(instant):
        assert isinstance(instant.sensors, ImageSensorModel)
        flight, seen = instant.flight, instant.sensors.seen
        in_body = (flight.target_m - flight.position_m) @ flight.R_world_body
        errors.append(seen.target_px - flight.config.camera.see(in_body)[0])
        counts.append(len(seen.features.ids))

    flown = fly([RUN], watch)
    assert flown.error is None
    assert len(errors) == RUN.iteration_count
    assert np.abs(errors).max() < 0.5
    assert min(counts) > 20


def test_the_same_run_gives_the_same_row():
    short = replace(RUN, iteration_count=5)
    first, again = (results_of([short], fly([short]), "")[0] for _ in range(2))
    assert first == again


def test_the_noise_of_the_motion_is_that_of_the_points():
    """A flight among images and one among points begin alike: the same odometry, so paired."""
    images = fly([replace(RUN, iteration_count=2)])
    points = fly([replace(RUN, study="circle", iteration_count=2)])
    told = [
        np.subtract(f.log.array("robot_m")[1], f.log.array("reckoned_m")[1])
        for f in (images, points)
    ]
    # Their commands differ a little (another pixel), the noise in the body's frame does not.
    assert np.abs(told[0] - told[1]).max() < 1e-3
    assert np.abs(told[0]).max() > 1e-3


def test_a_target_that_flies_away_is_lost_and_the_row_kept():
    """It leaves the image at once, faster than the vehicle turns: predicted, then given up."""
    run = replace(RUN, study="line-pixels", target_speed_mps=600.0, iteration_count=70)
    flown = fly([run])
    (row,) = results_of([run], flown, "")
    assert row.outcome == "lost"
    assert row.seen_share < 0.1
    assert row.robot_error_m is not None


def test_every_pixel_study_is_a_study_of_points_as_well():
    for name, study in STUDIES.items():
        if name.endswith("-pixels"):
            assert study.base.is_rendered
            twin = replace(study.base, study=name.removesuffix("-pixels"))
            world, points = world_of(study.base), world_of(twin)
            assert world.landmark_count == 0
            assert replace(world, landmark_count=0) == replace(points, landmark_count=0)
        else:
            assert not study.base.is_rendered


def test_points_make_no_film():
    film = ImageFilm(RUN)

    def watch(instant):
        assert isinstance(instant.sensors, PointSensorModel)
        with pytest.raises(AssertionError, match="no images"):
            film.picture(instant)

    fly([replace(RUN, study="circle", iteration_count=1)], watch)


def test_a_picture_shows_both_views():
    pictures = []
    film = ImageFilm(RUN)
    fly([replace(RUN, iteration_count=3)], lambda instant: pictures.append(film.picture(instant)))
    assert {picture.shape for picture in pictures} == {(480, 640 + 480, 3)}
    assert not np.array_equal(pictures[0], pictures[-1])


def test_landmarks_never_have_the_colour_of_the_target():
    for name in range(300):
        red, green, blue = colour_of(name)
        assert green > 70 or blue > red


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["speed", "--pixels"], "--pixels goes with line and circle, not with speed"),
        (["circle", "--pixels", "--landmarks", "50"], "--landmarks does not go with --pixels"),
        (["circle", "--pixels", "--controllers", "known-pose"], "known-pose flies among points"),
        (["circle", "--pixels", "--controllers", "nobody"], "nobody"),
        (["circle", "--pixels", "--seeds", "0"], "seeds must be 1 or greater"),
    ],
)
def test_what_does_not_go_together_is_refused_in_a_line(capsys, tmp_path, words, message):
    assert cli.run(["bearing-only", *words, "--out", str(tmp_path)]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1
