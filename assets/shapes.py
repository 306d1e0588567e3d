"""Shapes that the meshes are made of: revolved profiles, bevelled plates, printed packages.

Lengths are metres.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

SEGMENTS = 32


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles over shared vertices; texture coordinates are optional."""

    vertices: np.ndarray
    """(n, 3) [m]."""
    faces: np.ndarray
    """(m, 3) indices, counter-clockwise seen from outside."""
    texcoords: np.ndarray | None = None
    """(n, 2), origin at the lower left of the picture."""

    def to_obj(self) -> str:
        """Wavefront text."""
        lines = ["# Written by assets/generate.py; do not edit."]
        lines += ["v {:.6g} {:.6g} {:.6g}".format(*v) for v in np.round(self.vertices, 6) + 0.0]
        if self.texcoords is None:
            lines += ["f {} {} {}".format(*f) for f in self.faces + 1]
        else:
            lines += ["vt {:.6g} {:.6g}".format(*t) for t in np.round(self.texcoords, 6) + 0.0]
            lines += ["f {0}/{0} {1}/{1} {2}/{2}".format(*f) for f in self.faces + 1]
        return "\n".join(lines) + "\n"


def rounded(corners: list[tuple[float, float, float]], steps: int = 2) -> np.ndarray:
    """Polyline through (x, y, fillet radius) corners, each corner replaced by an arc."""
    points = np.array([c[:2] for c in corners])
    out = []
    for index, (_, _, radius) in enumerate(corners):
        here = points[index]
        if radius == 0.0:
            out.append(here)
            continue
        before, after = points[index - 1], points[(index + 1) % len(points)]
        into = (before - here) / np.linalg.norm(before - here)
        away = (after - here) / np.linalg.norm(after - here)
        for t in np.linspace(0.0, 1.0, steps + 1):  # quadratic Bezier: close to an arc
            out.append(here + radius * ((1 - t) ** 2 * into + t**2 * away))
    return np.array(out)


def revolved(corners: list[tuple[float, float, float]], segments: int = SEGMENTS) -> Mesh:
    """Solid of revolution about z from a profile of (radius, z, fillet), going up.

    The ends are closed by flat discs.
    """
    profile = rounded(corners)
    angles = 2 * np.pi * np.arange(segments) / segments
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    vertices = [np.array([[0.0, 0.0, profile[0, 1]]])]
    for radius, z in profile:
        vertices.append(np.column_stack([radius * ring, np.full(segments, z)]))
    vertices.append(np.array([[0.0, 0.0, profile[-1, 1]]]))
    here = np.arange(segments)
    after = np.roll(here, -1)
    first = 1 + segments * np.arange(len(profile))
    top = first[-1] + segments
    faces = [np.column_stack([np.zeros_like(here), first[0] + after, first[0] + here])]
    for low, high in pairwise(first):
        faces.append(np.column_stack([low + here, low + after, high + after]))
        faces.append(np.column_stack([low + here, high + after, high + here]))
    faces.append(np.column_stack([first[-1] + here, first[-1] + after, np.full(segments, top)]))
    return Mesh(np.concatenate(vertices), np.concatenate(faces))


def plate(outline: np.ndarray, thickness: float, bevel: float) -> Mesh:
    """Bevelled plate: an outline in (x, z), counter-clockwise seen from -y, centred in y.

    The outline must be star-shaped about its mean.
    """
    centre = outline.mean(axis=0)
    reach = np.linalg.norm(outline - centre, axis=1, keepdims=True)
    shrunk = centre + (outline - centre) * (1 - bevel / reach)
    half = 0.5 * thickness
    layers = [(shrunk, -half), (outline, bevel - half), (outline, half - bevel), (shrunk, half)]
    n = len(outline)
    vertices = [np.column_stack([o[:, 0], np.full(n, y), o[:, 1]]) for o, y in layers]
    vertices += [np.array([[centre[0], y, centre[1]]]) for y in (-half, half)]
    here = np.arange(n)
    after = np.roll(here, -1)
    faces = [np.column_stack([np.full(n, 4 * n), here, after])]
    for k in range(3):
        low, high = k * n, (k + 1) * n
        faces.append(np.column_stack([low + after, low + here, high + here]))
        faces.append(np.column_stack([low + after, high + here, high + after]))
    faces.append(np.column_stack([np.full(n, 4 * n + 1), 3 * n + after, 3 * n + here]))
    return Mesh(np.concatenate(vertices), np.concatenate(faces))


def carton(size: tuple[float, float, float]) -> Mesh:
    """Box whose six faces share one picture, as `sim/belt/artwork.py` paints it.

    Rows of the picture from the top: lid, front (-y), base, back (+y), each as wide as the box is
    long; to the right of the lid and of the front stand the ends +x and -x.
    """
    x, y, z = 0.5 * np.array(size)
    width, height = 2 * (x + y), 4 * 2 * max(y, z)
    row = height / 4
    faces_3d = [  # lower left, lower right, upper right, upper left, as read from outside
        ([(-x, -y, z), (x, -y, z), (x, y, z), (-x, y, z)], 0, 0),
        ([(-x, -y, -z), (x, -y, -z), (x, -y, z), (-x, -y, z)], 0, 1),
        ([(-x, y, -z), (x, y, -z), (x, -y, -z), (-x, -y, -z)], 0, 2),
        ([(x, y, -z), (-x, y, -z), (-x, y, z), (x, y, z)], 0, 3),
        ([(x, -y, -z), (x, y, -z), (x, y, z), (x, -y, z)], 1, 0),
        ([(-x, y, -z), (-x, -y, -z), (-x, -y, z), (-x, y, z)], 1, 1),
    ]
    vertices, texcoords, faces = [], [], []
    for corners, column, line in faces_3d:
        left, right = ((0.0, 2 * x), (2 * x, width))[column]
        bottom, top = height - (line + 1) * row, height - line * row
        start = len(vertices)
        vertices += corners
        texcoords += [(left, bottom), (right, bottom), (right, top), (left, top)]
        faces += [(start, start + 1, start + 2), (start, start + 2, start + 3)]
    return Mesh(np.array(vertices), np.array(faces), np.array(texcoords) / [width, height])


def can(radius: float, height: float, segments: int = SEGMENTS) -> Mesh:
    """Standing cylinder whose three faces share one picture.

    Lid and base stand side by side at the top of the picture, seen from above; under them the
    side, unrolled from the direction -x on, counter-clockwise seen from above.
    """
    angles = np.pi * (2 * np.arange(segments + 1) / segments - 1)
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    width, tall = 2 * np.pi * radius, 2 * radius + height
    half = np.full((segments + 1, 1), 0.5 * height)
    discs, disc_texcoords = [], []
    for centre, z in ((radius, half), (3 * radius, -half)):
        discs += [np.array([[0.0, 0.0, z[0, 0]]]), np.hstack([radius * ring, z])]
        middle = np.array([[centre, tall - radius]])
        disc_texcoords += [middle, middle + radius * ring]
    around = np.linspace(0.0, width, segments + 1)
    side = [np.hstack([radius * ring, z]) for z in (half, -half)]
    side_texcoords = [np.column_stack([around, np.full(segments + 1, v)]) for v in (height, 0.0)]
    here = np.arange(segments)
    base, top, bottom = segments + 2, 2 * segments + 4, 3 * segments + 5
    faces = [
        np.column_stack([np.zeros_like(here), 1 + here, 2 + here]),
        np.column_stack([np.full(segments, base), base + 2 + here, base + 1 + here]),
        np.column_stack([bottom + here, bottom + here + 1, top + here + 1]),
        np.column_stack([bottom + here, top + here + 1, top + here]),
    ]
    texcoords = np.concatenate(disc_texcoords + side_texcoords) / [width, tall]
    return Mesh(np.concatenate(discs + side), np.concatenate(faces), texcoords)


def turned(mesh: Mesh, x_axis: tuple, y_axis: tuple, offset: tuple = (0.0, 0.0, 0.0)) -> Mesh:
    """The mesh with its x and y axes laid along the given ones, then moved."""
    R = np.column_stack([x_axis, y_axis, np.cross(x_axis, y_axis)])
    return replace(mesh, vertices=mesh.vertices @ R.T + offset)


def joined(*meshes: Mesh) -> Mesh:
    """All of them as one, without texture coordinates."""
    ends = np.cumsum([len(m.vertices) for m in meshes])
    faces = [m.faces + end - len(m.vertices) for m, end in zip(meshes, ends, strict=True)]
    return Mesh(np.concatenate([m.vertices for m in meshes]), np.concatenate(faces))


def printed_from_above(mesh: Mesh, length: float, width: float) -> Mesh:
    """The mesh with a picture of its bounding rectangle (x, y) projected along z."""
    return replace(mesh, texcoords=mesh.vertices[:, :2] / [length, width] + 0.5)
