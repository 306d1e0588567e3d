"""Random streams by address: (seed, stream, part) names a stream, never the order of the calls.

Scene and sensor streams know nothing of the tracker, so every tracker meets the same world and
the same noise draws, and differences between trackers are paired.
"""

from __future__ import annotations

import enum

import numpy as np

BENCHMARK_ENTROPY = 0x62656C746772617370
"""Root entropy of the benchmark (the ASCII codes of its name); changing it changes every world."""


class Stream(enum.IntEnum):
    """What the draws of a stream decide."""

    SCENE = 0
    SENSOR = 1
    TRACKER = 2
    FOOTAGE = 3


def seed_sequence(seed: int, stream: Stream, *part: int) -> np.random.SeedSequence:
    """The address of one stream or of a part of it, independent of every other address."""
    if seed < 0:
        raise ValueError(f"seed must be 0 or greater, got {seed}")
    return np.random.SeedSequence(BENCHMARK_ENTROPY, spawn_key=(seed, int(stream), *part))


def generator(seed: int, stream: Stream, *part: int) -> np.random.Generator:
    """A fresh generator at the start of the stream, or of the part that these numbers name."""
    return np.random.Generator(np.random.PCG64(seed_sequence(seed, stream, *part)))


def random_state(seed: int, stream: Stream) -> np.random.RandomState:
    """The stream as the legacy type that dm_control expects; the only place that makes one."""
    return np.random.RandomState(np.random.MT19937(seed_sequence(seed, stream)))
