"""Meshes of the things that are filmed: a grid that carries a picture, and what is behind it.

Local axes are x right, y down and z away from the camera; the origin is where a thing turns about.
"""

from dataclasses import dataclass

import numpy as np

from sim.video.clip import Shape

ROWS, COLUMNS = 17, 21
"""Vertices of the front; light is computed at vertices, so a grid shows how it varies."""

RIPPLES = 1.25
"""Waves along a rippled sheet."""
RIPPLE_PERIOD = 24.0
"""Time in which a ripple runs one wave length [frames]."""


@dataclass(frozen=True, eq=False)
class Surface:
    """A triangle mesh whose first ROWS * COLUMNS vertices are its front, row by row."""

    vertices_m: np.ndarray
    """(n, 3) at rest."""
    triangles: np.ndarray
    """(m, 3) indices, counter-clockwise as seen from outside."""
    texture: np.ndarray
    """(n, 2) texture coordinates, (0, 0) the upper left corner of the picture."""
    is_closed: bool
    """Whether the mesh bounds a body, so that triangles seen from behind are hidden."""


CORNERS = np.array([0, COLUMNS - 1, ROWS * COLUMNS - 1, (ROWS - 1) * COLUMNS])
"""Vertices at the corners of the front: top left, top right, bottom right, bottom left."""
FRONT = slice(0, ROWS * COLUMNS)


def make_surface(shape: Shape, size_m: tuple[float, float], thickness: float) -> Surface:
    """The surface of a shape; `thickness` is a carton's, as a share of its width."""
    if shape == "carton":
        return _carton(*size_m, thickness * size_m[0])
    return make_wall(size_m, ROWS, COLUMNS)


def make_wall(size_m: tuple[float, float], rows: int, columns: int) -> Surface:
    """A flat wall of (rows, columns) vertices that shows the whole picture once."""
    u, v = _grid(rows, columns)
    vertices = np.column_stack([u * size_m[0], v * size_m[1], np.zeros(u.size)])
    return Surface(vertices, _triangles(rows, columns), _texture(u, v), is_closed=False)


def deformed(
    vertices_m: np.ndarray, bend_rad: float, ripple: float, sway: float, time: float
) -> np.ndarray:
    """(n, 3) vertices of a flat sheet after pulling, bending and rippling; see `clip.Moves`."""
    width, height = np.ptp(vertices_m[:, :2], axis=0)
    u, v = vertices_m[:, 0] / width, vertices_m[:, 1] / height
    x = u + sway * np.sin(2.0 * np.pi * (0.7 * v + 0.1))
    y = v + sway * np.sin(2.0 * np.pi * (0.6 * u - 0.15))
    z = ripple * np.sin(2.0 * np.pi * (RIPPLES * u + 0.3 * v - time / RIPPLE_PERIOD))
    if abs(bend_rad) > 1e-9:
        z = z + (1.0 - np.cos(bend_rad * x)) / bend_rad
        x = np.sin(bend_rad * x) / bend_rad
    return np.column_stack([x * width, y * height, z * width])


def _carton(width: float, height: float, depth: float) -> Surface:
    """A box that turns about its centre; its other faces show the picture on its side."""
    u, v = _grid(ROWS, COLUMNS)
    faces = [np.column_stack([u, v, np.full(u.size, -0.5)])]
    triangles, textures = [_triangles(ROWS, COLUMNS)], [_texture(u, v)]
    u, v = _grid(_SIDE, _SIDE)
    face = np.column_stack([u, v, np.full(u.size, -0.5)])
    for turn in _TURNS:
        triangles.append(_triangles(_SIDE, _SIDE) + sum(map(len, faces)))
        faces.append(face @ np.transpose(turn))
        textures.append(_texture(v, u))
    vertices = np.concatenate(faces) * [width, height, depth]
    return Surface(vertices, np.concatenate(triangles), np.concatenate(textures), is_closed=True)


_SIDE = 7
"""Rows and columns of the faces of a carton that are not its front."""
_TURNS = (
    ((0, 0, -1), (0, 1, 0), (1, 0, 0)),
    ((-1, 0, 0), (0, 1, 0), (0, 0, -1)),
    ((0, 0, 1), (0, 1, 0), (-1, 0, 0)),
    ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
)
"""Rotations that bring the front to the other five faces of a cube."""


def _grid(rows: int, columns: int) -> tuple[np.ndarray, np.ndarray]:
    """u and v (rows * columns,) from -0.5 to 0.5, row by row."""
    u, v = np.meshgrid(np.linspace(-0.5, 0.5, columns), np.linspace(-0.5, 0.5, rows))
    return u.ravel(), v.ravel()


def _texture(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.column_stack([u, v]) + 0.5


def _triangles(rows: int, columns: int) -> np.ndarray:
    """(m, 3) two triangles for each cell of a grid, their outside towards -z."""
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b = index[:-1, :-1].ravel(), index[:-1, 1:].ravel()
    c, d = index[1:, 1:].ravel(), index[1:, :-1].ravel()
    return np.concatenate([np.column_stack([a, d, c]), np.column_stack([a, c, b])])
