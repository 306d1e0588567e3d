"""What an image of a video costs: whole updates, the filter's step and its parts, and the floor.

A target of 64 x 78 px, the size of OTB's David, moves over 320 x 240 px; the template has 32 x 32
samples, and there are 100 particles. The floor is `cv2.remap` of as many samples as the step takes.
"""

import time
from dataclasses import replace

import cv2
import numpy as np
import pytest

from experiments.video.trackers import VIDEO_TRACKERS
from tracker.affine import filter as particle_filter
from tracker.affine.filter import ParticleFilter
from tracker.affine.likelihood import TemplateObservation
from tracker.affine.patches import PatchMatcher
from tracker.affine.proposal import GaussianProposal, PriorProposal
from tracker.video.particle_box_tracker import ParticleBoxTracker
from tracker.video.registry import BOX_TRACKERS

PARTICLES = 100
FRAMES = 300
FILTERS = ("igpf", "gpf", "pf")


@pytest.fixture(scope="module")
def video():
    """Images, and the box on the first."""
    rng = np.random.default_rng(0)
    noise = cv2.GaussianBlur(rng.integers(0, 255, (300, 380, 3), np.uint8), (0, 0), 3)
    wall = cv2.normalize(noise, None, 0, 255, cv2.NORM_MINMAX)
    corners = [
        (int(30 + 20 * np.sin(k / 15)), int(30 + 15 * np.cos(k / 11))) for k in range(FRAMES)
    ]
    images = [np.ascontiguousarray(wall[y : y + 240, x : x + 320]) for x, y in corners]
    return images, np.array([128.0, 81.0, 64.0, 78.0])


@pytest.fixture(autouse=True)
def one_thread():
    cv2.setNumThreads(1)


def start(name, video):
    images, box = video
    config = BOX_TRACKERS[name]
    config = replace(config, filter=replace(config.filter, particle_count=PARTICLES))
    tracker = ParticleBoxTracker(config, np.random.default_rng(0))
    tracker.start(images[0], box)
    return tracker


@pytest.mark.parametrize("name", BOX_TRACKERS)
def test_update(benchmark, video, name):
    """One image, window and template update included."""
    tracker, count = start(name, video), iter(range(1, 10**9))
    benchmark(lambda: tracker.update(video[0][next(count) % FRAMES]))


@pytest.mark.parametrize("name", ["csrt", "kcf", "mosse"])
def test_update_of_a_peer(benchmark, video, name):
    """The same images; `make peers` installs what is skipped."""
    try:
        tracker = VIDEO_TRACKERS[name].make(np.random.default_rng(0))
    except ValueError as error:
        pytest.skip(str(error))
    tracker.start(video[0][0], video[1])
    count = iter(range(1, 10**9))
    benchmark(lambda: tracker.update(video[0][next(count) % FRAMES]))


@pytest.mark.parametrize("name", FILTERS)
def test_step(benchmark, monkeypatch, video, name):
    """The filter's step alone. Prints its parts and its cost over the floor.

    Least times, so that the pauses of a shared machine drop out.
    """
    tracker, watch = start(name, video), Watch(monkeypatch)
    watch.spend(ParticleFilter, "predict")
    watch.spend(TemplateObservation, "linearise")
    watch.spend(GaussianProposal if name != "pf" else PriorProposal, "draw")
    watch.spend(ParticleFilter, "_weigh")
    watch.spend(ParticleFilter, "_resample")
    watch.spend(particle_filter, "moments")
    watch.count(PatchMatcher, "fit")
    watch.count(PatchMatcher, "linearise")
    step, ratios = ParticleFilter.step, []
    floor_s = remap_s(video[0][0]) / PARTICLES

    def timed(*arguments):
        watch.warps = 0
        before = time.perf_counter()
        estimate = step(*arguments)
        ratios.append((time.perf_counter() - before) / (watch.warps * floor_s))
        return estimate

    monkeypatch.setattr(ParticleFilter, "step", timed)
    benchmark.pedantic(lambda: [tracker.update(image) for image in video[0]], rounds=3)
    parts = watch.least_s
    if "linearise" in parts:
        parts["draw"] -= parts["linearise"]
    benchmark.extra_info |= {f"{part}_s": seconds for part, seconds in parts.items()}
    benchmark.extra_info |= {"floor_ratio": min(ratios)}
    split = ", ".join(f"{part.strip('_')} {1e3 * s:.3f}" for part, s in parts.items())
    print(f"\n{name}: {min(ratios):.2f} x the remap of as many samples; least ms: {split}")


class Watch:
    """Least time spent in methods, and how many warps were compared."""

    def __init__(self, monkeypatch):
        self.monkeypatch, self.least_s, self.warps = monkeypatch, {}, 0

    def spend(self, owner, method):
        inner = getattr(owner, method)

        def timed(*arguments, **settings):
            before = time.perf_counter()
            result = inner(*arguments, **settings)
            seconds = time.perf_counter() - before
            self.least_s[method] = min(seconds, self.least_s.get(method, np.inf))
            return result

        self.monkeypatch.setattr(owner, method, timed)

    def count(self, owner, method):
        inner = getattr(owner, method)

        def counted(matcher, layers, warps, clip):
            self.warps += len(warps)
            return inner(matcher, layers, warps, clip)

        self.monkeypatch.setattr(owner, method, counted)


def remap_s(image):
    """Least time to sample the patches of all particles with OpenCV [s]."""
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY).astype(np.float32)
    shift = np.random.default_rng(0).uniform(-8, 8, (2, PARTICLES, 1))
    rows, columns = np.mgrid[0:32, 0:32].reshape(2, 1, -1)
    x, y = (128 + 2.0 * columns + shift[0], 81 + 2.4 * rows + shift[1])
    x, y = np.float32(x), np.float32(y)
    times = []
    for _ in range(300):
        before = time.perf_counter()
        cv2.remap(grey, x, y, cv2.INTER_LINEAR)
        times.append(time.perf_counter() - before)
    return min(times)
