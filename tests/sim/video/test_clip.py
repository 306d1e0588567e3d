"""Motion: every term starts at zero, reaches its peak and keeps to its periods."""

import numpy as np
import pytest

from sim.video.clip import Swing, Trip, Wave, draw_sum

FRAMES = 90
TERMS = [Wave(-40.0, (12.0, 50.0)), Swing(1.4, (60.0, 80.0)), Trip(200.0, 10.0, 50.0, 20.0)]


def values(term, seed=0, per_frame=8):
    signal = term.draw(FRAMES, np.random.default_rng(seed))
    return np.array([signal(k / per_frame) for k in range((FRAMES - 1) * per_frame + 1)])


@pytest.mark.parametrize("term", TERMS, ids=repr)
@pytest.mark.parametrize("seed", range(5))
def test_a_term_starts_at_zero_and_reaches_its_peak(term, seed):
    path = values(term, seed)
    peak = term.by if isinstance(term, Trip) else term.peak
    assert path[0] == 0.0
    assert path[np.argmax(np.abs(path))] == pytest.approx(peak, rel=1e-3)
    assert np.abs(path).max() <= abs(peak) * (1 + 1e-9)


@pytest.mark.parametrize("term", TERMS, ids=repr)
def test_the_same_generator_gives_the_same_motion(term):
    assert np.array_equal(values(term, 3), values(term, 3))


def test_a_wave_has_no_periods_shorter_than_asked_for():
    wave = Wave(10.0, (20.0, 60.0))
    power = np.abs(np.fft.rfft(values(wave, per_frame=1) * np.hanning(FRAMES))) ** 2
    periods_frames = FRAMES / np.maximum(np.arange(len(power)), 1e-9)
    assert power[periods_frames < 10.0].sum() < 1e-4 * power.sum()


def test_a_swing_stays_on_one_side():
    assert values(Swing(5.0, (20.0, 30.0))).min() >= 0.0
    assert values(Swing(-5.0, (20.0, 30.0))).max() <= 0.0


def test_terms_add_up():
    terms = (Trip(3.0, 0.0, 80.0, 10.0), Trip(4.0, 0.0, 80.0, 20.0))
    signal = draw_sum(terms, FRAMES, np.random.default_rng(0))
    assert signal(40.0) == pytest.approx(7.0)
    assert draw_sum((), FRAMES, np.random.default_rng(0))(12.0) == 0.0


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Wave(1.0, (30.0, 20.0)), r"periods must be .* got \(30.0, 20.0\)"),
        (lambda: Swing(1.0, (0.0, 20.0)), r"periods must be .* got \(0.0, 20.0\)"),
        (lambda: Trip(1.0, 30.0, 20.0, 5.0), "leave <= back .* got 30.0, 20.0, 5.0"),
    ],
)
def test_impossible_times_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()
