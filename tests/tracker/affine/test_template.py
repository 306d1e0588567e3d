import numpy as np
import pytest
from scenes import SIZE_M, box_picture
from scipy.interpolate import RectBivariateSpline

from tracker.affine import aff2
from tracker.affine.template import Template, square_cells


def test_values_are_normalised_and_arrays_read_only(template):
    assert abs(template.values.mean()) < 1e-5
    assert template.values.std() == pytest.approx(1.0, abs=1e-5)
    with pytest.raises(ValueError, match="read-only"):
        template.values[0] = 0.0


def test_template_unit_is_the_root_of_the_area(template):
    w, h = template.size
    assert w * h == pytest.approx(1.0)
    assert w / h == pytest.approx(SIZE_M[0] / SIZE_M[1])
    np.testing.assert_allclose(template.corners.mean(axis=1), [0, 0, 1], atol=1e-12)


def test_jacobian_equals_finite_differences_of_a_smooth_picture():
    v, u = np.mgrid[0:160, 0:400]
    smooth = 128 + 60 * np.sin(u / 31.0) * np.cos(v / 23.0) + 30 * np.sin((u + 2 * v) / 53.0)
    template = Template.of_picture(smooth.astype(np.uint8), (0.2, 0.08), grid=(32, 80))
    rows, columns = template.shape
    grid_u = template.points[0].reshape(rows, columns)[0]
    grid_v = template.points[1].reshape(rows, columns)[:, 0]
    spline = RectBivariateSpline(grid_v, grid_u, template.values.reshape(rows, columns))
    inner = (slice(3, -3), slice(3, -3))
    step = 1e-4
    for axis in range(6):
        moved = []
        for sign in (1, -1):
            e = np.zeros(6)
            e[axis] = sign * step
            q = aff2.exp(e) @ template.points
            moved.append(spline.ev(q[1], q[0]).reshape(rows, columns)[inner])
        expected = (moved[0] - moved[1]) / (2 * step)
        actual = template.jacobian[:, axis].reshape(rows, columns)[inner]
        assert np.abs(actual - expected).max() < 0.05 * np.abs(expected).max()


def test_what_the_mask_leaves_out_has_no_say():
    """Samples, values and derivatives are those of the target alone, whatever lies around it."""
    picture = box_picture()[:, :160].copy()
    v, u = np.mgrid[:160, :160] - 79.5
    mask = np.hypot(u, v) < 79.5
    ink = picture.copy()
    ink[np.hypot(u, v) > 84] = 0
    plain, inked = (Template.of_picture(p, (1, 1), mask=mask) for p in (picture, ink))
    assert np.hypot(*plain.points[:2]).max() < 0.5
    assert len(plain.values) / 19**2 == pytest.approx(np.pi / 4, abs=0.1)
    np.testing.assert_allclose(inked.values, plain.values, atol=1e-5)
    np.testing.assert_allclose(inked.jacobian, plain.jacobian, atol=1e-4)


def test_cells_are_square_whatever_the_shape():
    assert square_cells((0.2, 0.08), 360) == (12, 30)
    assert square_cells((0.066, 0.066), 360) == (19, 19)


@pytest.mark.parametrize(
    ("picture", "size", "message"),
    [
        (np.zeros((20, 20), np.uint8), (1, 1), "texture"),
        (np.zeros((20, 20), np.float32), (1, 1), "uint8"),
        (np.zeros((20, 20, 4), np.uint8), (1, 1), "picture"),
        (box_picture(), (0.2, 0.0), "size"),
        (box_picture(), (0.2, np.nan), "size"),
    ],
)
def test_bad_pictures_are_refused(picture, size, message):
    with pytest.raises(ValueError, match=message):
        Template.of_picture(picture, size)


def test_a_mask_of_another_shape_or_without_target_is_refused():
    with pytest.raises(ValueError, match=r"mask must be \(160, 400\) as the picture is, got"):
        Template.of_picture(box_picture(), (0.2, 0.08), mask=np.ones((4, 4), bool))
    with pytest.raises(ValueError, match="texture"):
        Template.of_picture(box_picture(), (0.2, 0.08), mask=np.zeros((160, 400), bool))
