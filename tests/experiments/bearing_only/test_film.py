import numpy as np
import pytest

from experiments.bearing_only.config import FlightRun
from experiments.bearing_only.film import PointFilm
from experiments.bearing_only.flying import fly
from experiments.bearing_only.top_view import ROBOT, TARGET


@pytest.mark.parametrize("controller", ["follow", "known-pose"])
def test_a_picture_shows_the_room_and_the_curves_so_far(controller):
    pictures = []
    run = FlightRun("robot", controller, iteration_count=8, landmark_count=10)
    making = PointFilm(run)
    fly([run], lambda instant: pictures.append(making.picture(instant)))
    assert {picture.shape for picture in pictures} == {(540, 960, 3)}
    room, charts = pictures[-1][:, :540], pictures[-1][:, 540:]
    for part in (room, charts):
        for colour in (ROBOT, TARGET):
            assert (np.abs(part.astype(int) - colour).max(axis=2) < 40).any()
    assert not np.array_equal(pictures[0][:, 540:], charts)
