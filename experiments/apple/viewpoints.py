"""Ways to choose where the camera goes next, under one name each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from experiments.apple.photographs import Photograph, Photographer


@dataclass(frozen=True)
class Viewing:
    """A way to choose the views."""

    description: str
    take: Callable[[Sequence[np.ndarray], Photographer, int], list[Photograph]]
    """Planned poses (4, 4) of the approach, what takes pictures, and the seed -> photographs."""


def along_the_arc(planned: Sequence[np.ndarray], take: Photographer, seed: int) -> list[Photograph]:
    """The planned approach, whatever is seen."""
    del seed
    return [photo for T in planned if (photo := take(T)) is not None]


VIEWS = {
    "arc": Viewing(
        "the approach as planned: an arc of 50 degrees, from 0.60 to 0.22 m", along_the_arc
    ),
}
"""Every way to choose views."""
