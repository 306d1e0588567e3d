"""The truth against cases that can be computed by hand."""

import numpy as np
import pytest

from sim.geometry import project
from sim.video.film import Surveyor, upright_box
from sim.video.surfaces import make_surface

FLAT = make_surface("panel", (0.30, 0.20), 0.0)
CARTON = make_surface("carton", (0.30, 0.20), 0.5)
CAMERA = np.array([[300.0, 0, 159.5, 0], [0, 300.0, 119.5, 0], [0, 0, 1, 0]])


def seen(surface, rotation=None, depth_m=1.0):
    vertices = surface.vertices_m @ (np.eye(3) if rotation is None else rotation).T
    return project(CAMERA, np.add(vertices, [0.0, 0.0, depth_m]))


def about(axis, angle_rad):
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    if axis == "z":
        return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def test_a_box_counts_whole_pixels():
    """Pixels 3 to 7 and 10 to 11 are covered by what reaches from 2.5 to 7.5 and 9.5 to 11.5."""
    corners = np.array([[2.5, 9.5], [7.5, 11.5]])
    assert upright_box(corners).tolist() == [3.0, 10.0, 5.0, 2.0]


def test_the_first_warp_is_the_first_box():
    first = seen(FLAT)
    truth = Surveyor(FLAT, first).truth(first)
    unit = 300.0 * np.sqrt(0.30 * 0.20)
    assert truth.box == pytest.approx([159.5 - 45 + 0.5, 119.5 - 30 + 0.5, 90, 60])
    assert np.allclose(truth.warp, [[unit, 0, 159.5], [0, unit, 119.5], [0, 0, 1]])
    assert truth.corners[0] == pytest.approx([159.5 - 45, 119.5 - 30])
    assert truth.corners[2] == pytest.approx([159.5 + 45, 119.5 + 30])
    assert truth.area_px == pytest.approx(90 * 60)
    assert truth.warp_error_px == pytest.approx(0.0, abs=1e-9)


def test_a_turn_in_the_image_and_an_approach_are_exact():
    surveyor = Surveyor(FLAT, seen(FLAT))
    truth = surveyor.truth(seen(FLAT, about("z", 0.7), depth_m=0.8))
    unit = 300.0 * np.sqrt(0.30 * 0.20) / 0.8
    assert np.allclose(truth.warp[:2, :2], unit * about("z", 0.7)[:2, :2])
    assert truth.warp_error_px == pytest.approx(0.0, abs=1e-9)
    assert truth.area_px == pytest.approx(90 * 60 / 0.8**2)


def test_a_turn_out_of_the_image_shortens_the_width():
    truth = Surveyor(FLAT, seen(FLAT)).truth(seen(FLAT, about("y", 1.0)))
    first = Surveyor(FLAT, seen(FLAT)).truth(seen(FLAT))
    ratio = truth.warp[:2, :2] / first.warp[0, 0]
    assert ratio == pytest.approx(np.diag([np.cos(1.0), 1.0]), abs=0.03)
    assert 0.1 < truth.warp_error_px < 3.0


def test_the_sides_of_a_carton_count_in_box_and_area_only_when_they_show():
    surveyor = Surveyor(CARTON, seen(CARTON))
    first, turned = surveyor.truth(seen(CARTON)), surveyor.truth(seen(CARTON, about("y", 0.6)))
    assert first.area_px == pytest.approx(first.box[2] * first.box[3])
    front = np.ptp(turned.corners, axis=0)
    assert turned.box[2] > front[0] + 10
    assert turned.area_px > 1.2 * front[0] * front[1] * 0.9
