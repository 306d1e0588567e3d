"""Random streams by address: (seed, stream, part) names a stream, never the order of the calls.

Scene and sensor streams know nothing of the tracker, so every tracker meets the same world and
the same noise draws, and differences between trackers are paired.
"""

import enum

import numpy as np

BENCHMARK_ENTROPY = 0x62656C746772617370
"""Root entropy of the benchmark (the ASCII codes of its name); changing it changes every world."""


class Stream(enum.IntEnum):
    """What the draws of a stream decide."""

    SCENE = 0
    SENSOR = 1
    TRACKER = 2
    VIDEO = 3
    """A tracker's draws on a video sequence; the place is protocol, sequence and run."""
    BOOTSTRAP = 4
    FOOTAGE = 5
    """A rendered sequence; the place is its name."""
    FLIGHT = 8
    """A flight of bearing-only tracking; the place is the noise source."""


def seed_sequence(seed: int, stream: Stream, place: str = "") -> np.random.SeedSequence:
    """The address of one stream, independent of every other address.

    `place` tells streams of one kind apart: its UTF-8 bytes, read as one number, end the address.
    """
    if seed < 0:
        raise ValueError(f"seed must be 0 or greater, got {seed}")
    number = (int.from_bytes(place.encode(), "big"),) if place else ()
    return np.random.SeedSequence(BENCHMARK_ENTROPY, spawn_key=(seed, int(stream), *number))


def generator(seed: int, stream: Stream, place: str = "") -> np.random.Generator:
    """A fresh generator at the start of the stream."""
    return np.random.Generator(np.random.PCG64(seed_sequence(seed, stream, place)))
