"""Leaves: the shape of the blade, and where leaves hang around a fruit."""

from dataclasses import dataclass

import numpy as np

_LENGTH_M = (0.060, 0.085)
_WIDTH_SHARE = (0.45, 0.58)
_HALF_THICKNESS = 0.004
_ALONG, _ACROSS = 13, 7


@dataclass(frozen=True, eq=False)
class Leaf:
    """A leaf in the world; blade frame: x along the midrib, y across, z out of the upper side."""

    centre_m: np.ndarray
    """(3,) middle of the blade."""
    rotation: np.ndarray
    """(3, 3) blade -> world."""
    length_m: float
    width_m: float
    shade: float = 1.0
    """Brightness of its green."""


@dataclass(frozen=True, eq=False)
class Blade:
    """Closed triangle mesh of a leaf 1 long and 1 wide, middle at the origin."""

    vertices: np.ndarray
    """(n, 3)."""
    triangles: np.ndarray
    """(m, 3) indices, seen anticlockwise from outside."""
    texture: np.ndarray
    """(n, 2) texture coordinates."""


def make_blade(curl: float = 0.10, fold: float = 0.12) -> Blade:
    """A pointed oval that droops along the midrib by `curl` and is folded along it by `fold`."""
    s, t = np.meshgrid(np.linspace(0.0, 1.0, _ALONG), np.linspace(-1.0, 1.0, _ACROSS))
    half = 0.5 * np.sin(np.pi * s**0.85) ** 0.8
    x, y = s - 0.5, t * half
    z = -curl * (2.0 * x) ** 2 + fold * np.abs(y)
    edge = (1.0 - t**2) * np.sin(np.pi * s)
    upper = np.stack([x, y, z + _HALF_THICKNESS * (edge + 0.1)], axis=-1).reshape(-1, 3)
    lower = np.stack([x, y, z - _HALF_THICKNESS * (edge + 0.1)], axis=-1).reshape(-1, 3)
    index = np.arange(_ALONG * _ACROSS).reshape(_ACROSS, _ALONG)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    top = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    rim = np.concatenate([index[0], index[1:, -1], index[-1, -2::-1], index[-2:0:-1, 0]])
    after, count = np.roll(rim, -1), _ALONG * _ACROSS
    sides = np.concatenate(
        [
            np.column_stack([rim, rim + count, after + count]),
            np.column_stack([rim, after + count, after]),
        ]
    )
    texture = np.stack([s, 0.5 + 0.5 * t], axis=-1).reshape(-1, 2)
    return Blade(
        vertices=np.concatenate([upper, lower]),
        triangles=np.concatenate([top, top[:, ::-1] + count, sides]),
        texture=np.concatenate([texture, texture]),
    )


def leaves_behind(
    rng: np.random.Generator, centre_m: np.ndarray, view_frame: np.ndarray, count: int
) -> tuple[Leaf, ...]:
    """Leaves beyond the fruit, none of which hides it from anywhere near the approach.

    Args:
        rng: Draws them.
        centre_m: (3,) middle of the fruit.
        view_frame: (3, 3) columns right, down and forward of a camera that looks along the
            approach.
        count: How many.
    """
    leaves: list[Leaf] = []
    for _ in range(count):
        around, out_m = rng.uniform(0, 2 * np.pi), 0.13 * np.sqrt(rng.uniform(0.02, 1.0))
        offset = np.array([out_m * np.cos(around), out_m * np.sin(around), rng.uniform(0.09, 0.18)])
        leaves.append(_leaf(rng, centre_m + view_frame @ offset, view_frame, 0.6))
    return tuple(leaves)


def leaves_in_front(
    rng: np.random.Generator,
    centre_m: np.ndarray,
    view_frame: np.ndarray,
    radius_m: float,
    count: int,
) -> tuple[Leaf, ...]:
    """Leaves between the camera and the fruit, each over a part of its outline or its face.

    `radius_m` is the fruit's; the middles of the leaves lie 0.6 to 1.2 radii off the line of
    sight. Other arguments as for `leaves_behind`.
    """
    leaves: list[Leaf] = []
    for _ in range(count):
        around = rng.uniform(0, 2 * np.pi)
        out_m = radius_m * rng.uniform(0.6, 1.2)
        depth_m = -(radius_m + rng.uniform(0.012, 0.035))
        offset = np.array([out_m * np.cos(around), out_m * np.sin(around), depth_m])
        leaves.append(_leaf(rng, centre_m + view_frame @ offset, view_frame, 0.35))
    return tuple(leaves)


def _leaf(
    rng: np.random.Generator, centre_m: np.ndarray, view_frame: np.ndarray, tilt_rad: float
) -> Leaf:
    """A leaf that faces the camera up to a random tilt, its midrib in a random direction."""
    turn = rng.uniform(0, 2 * np.pi)
    facing = np.array([*rng.uniform(-tilt_rad, tilt_rad, 2), -1.0])
    facing /= np.linalg.norm(facing)
    along = np.array([np.cos(turn), np.sin(turn), 0.0])
    along -= facing * (along @ facing)
    along /= np.linalg.norm(along)
    rotation = view_frame @ np.column_stack([along, np.cross(facing, along), facing])
    length_m = rng.uniform(*_LENGTH_M)
    width_m = length_m * rng.uniform(*_WIDTH_SHARE)
    return Leaf(centre_m, rotation, length_m, width_m, shade=rng.uniform(0.75, 1.15))
