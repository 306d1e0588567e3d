import numpy as np
import pytest

from tracker.video.histogram_loops import orientation_histograms


def histograms(slope_x, slope_y, bins=8):
    y, x = np.mgrid[:12, :16]
    out = np.empty((bins, 3, 4), np.float32)
    orientation_histograms((slope_x * x + slope_y * y).astype(np.float32), 4, out)
    return out


@pytest.mark.parametrize(
    ("slope", "expected"),
    [
        ((1, 0), {0: 1.0}),
        ((-1, 0), {0: 1.0}),
        ((0, 1), {4: 1.0}),
        ((0, -1), {4: 1.0}),
        ((1, 1), {2: 1.0}),
        ((1, -1), {6: 1.0}),
        ((np.cos(0.1), -np.sin(0.1)), {7: 0.8 / np.pi, 0: 1 - 0.8 / np.pi}),
    ],
)
def test_a_slope_counts_for_the_bins_of_its_orientation(slope, expected):
    inner = histograms(*slope)[:, 1, 1]
    wanted = np.zeros(8)
    for place, share in expected.items():
        wanted[place] = 2 * share * np.hypot(*slope)  # of central differences: twice the slope
    np.testing.assert_allclose(inner, wanted, atol=1e-5)


def test_the_rim_has_no_gradient():
    corner = histograms(1, 0)[0, 0, 0]
    assert corner == pytest.approx(2 * 9 / 16)


def test_random_pictures_agree_with_the_definition():
    grey = np.random.default_rng(0).normal(100.0, 40.0, (26, 30)).astype(np.float32)
    out = np.empty((9, 6, 7), np.float32)
    orientation_histograms(grey, 4, out)
    expected = np.zeros_like(out)
    for y in range(1, 24):
        for x in range(1, 28):
            dx, dy = grey[y, x + 1] - grey[y, x - 1], grey[y + 1, x] - grey[y - 1, x]
            place = (np.arctan2(dy, dx) * 9 / np.pi) % 9
            low, size = int(place), np.hypot(dx, dy) / 16
            expected[low % 9, y // 4, x // 4] += (1 - place + low) * size
            expected[(low + 1) % 9, y // 4, x // 4] += (place - low) * size
    np.testing.assert_allclose(out, expected, atol=2e-3)


def test_an_even_picture_has_no_gradient():
    out = np.empty((9, 3, 4), np.float32)
    orientation_histograms(np.full((12, 16), 7.0, np.float32), 4, out)
    np.testing.assert_array_equal(out, 0.0)
