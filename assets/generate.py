"""Writes the meshes of the assets folder: `python assets/generate.py`.

Every mesh is made here from a few radii and outlines, so no binary file and nobody else's model is
in the repository. Lengths are metres. The arm is built of revolved profiles, placed and repeated
by the files in `robots/`; the grippers of bevelled plates; the carton is a box with texture
coordinates. A test runs this and compares.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

ASSETS = Path(__file__).resolve().parent
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
    """Box whose six faces share one picture, as `sim/textures.py` paints it.

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


def arm_meshes() -> dict[str, Mesh]:
    """Parts of the arm; the z axis is that of the joint or of the tube."""
    return {
        "plinth": revolved(
            [(0.0745, 0.0, 0.0), (0.0745, 0.012, 0.003), (0.064, 0.016, 0.003), (0.060, 0.034, 0.0)]
        ),
        "housing_large": _housing(radius=0.060, half=0.060, fillet=0.008),
        "housing_small": _housing(radius=0.045, half=0.045, fillet=0.006),
        "cap_large": _cap(radius=0.0585, height=0.016),
        "cap_small": _cap(radius=0.0435, height=0.013),
        "upper_tube": _tube(bottom=0.054, top=0.052, waist=0.047, length=0.315),
        "fore_tube": _tube(bottom=0.052, top=0.041, waist=0.040, length=0.30),
        "flange": revolved(
            [
                (0.0375, -0.037, 0.0),
                (0.0375, -0.012, 0.001),
                (0.0355, -0.011, 0.001),
                (0.0355, -0.008, 0.001),
                (0.0375, -0.007, 0.001),
                (0.0375, 0.0, 0.001),
            ]
        ),
    }


def _housing(radius: float, half: float, fillet: float) -> Mesh:
    """Joint housing: a cylinder with rounded ends."""
    return revolved(
        [
            (radius - fillet, -half, 0.0),
            (radius, -half, fillet),
            (radius, half, fillet),
            (radius - fillet, half, 0.0),
        ]
    )


def _cap(radius: float, height: float) -> Mesh:
    """Lid of a joint: rounded edge and a shallow dish."""
    return revolved(
        [
            (radius, 0.0, 0.0),
            (radius, height, 0.008),
            (0.62 * radius, height, 0.002),
            (0.58 * radius, height - 0.002, 0.002),
            (0.2 * radius, height - 0.002, 0.0),
        ]
    )


def _tube(bottom: float, top: float, waist: float, length: float) -> Mesh:
    """Tube from z = 0 to `length` with a collar at each end."""
    return revolved(
        [
            (bottom, 0.0, 0.0),
            (bottom, 0.022, 0.003),
            (waist, 0.036, 0.006),
            (min(waist, top - 0.002), length - 0.034, 0.006),
            (top, length - 0.022, 0.003),
            (top, length, 0.0),
        ]
    )


def gripper_meshes() -> dict[str, Mesh]:
    """Parts of the grippers, in the frames of `grippers/rg2.xml` and `grippers/soft.xml`."""
    body = rounded(
        [
            (-0.030, 0.020, 0.004),
            (-0.040, 0.044, 0.008),
            (-0.040, 0.086, 0.010),
            (-0.026, 0.116, 0.006),
            (0.026, 0.116, 0.006),
            (0.040, 0.086, 0.010),
            (0.040, 0.044, 0.008),
            (0.030, 0.020, 0.004),
        ]
    )[::-1]
    finger = rounded(
        [
            (0.008, 0.032, 0.0),
            (0.008, -0.034, 0.004),
            (0.014, -0.060, 0.005),
            (0.028, -0.060, 0.005),
            (0.030, -0.042, 0.006),
            (0.020, -0.006, 0.010),
            (0.0165, 0.032, 0.003),
        ]
    )
    return {
        "palm": plate(body, 0.058, 0.004),
        "cover": plate(0.5 * body + [0.0, 0.036], 0.062, 0.002),
        "finger": plate(finger, 0.024, 0.002),
    } | _soft_finger()


def _soft_finger() -> dict[str, Mesh]:
    """One air chamber of the soft finger, and its tip; x = 0 is the axis of the hinge."""
    chamber = rounded(
        [
            (-0.004, 0.0066, 0.0),
            (-0.004, -0.0066, 0.0),
            (0.009, -0.0060, 0.004),
            (0.013, -0.0020, 0.003),
            (0.013, 0.0020, 0.003),
            (0.009, 0.0060, 0.004),
        ]
    )
    tip = rounded(
        [
            (-0.004, 0.022, 0.003),
            (-0.004, 0.0, 0.0),
            (0.009, 0.0, 0.002),
            (0.006, 0.016, 0.006),
            (0.001, 0.023, 0.003),
        ]
    )
    return {"bellow": plate(chamber, 0.022, 0.0015), "fingertip": plate(tip, 0.022, 0.0015)}


def generate() -> dict[str, str]:
    """Text of every mesh file, by its path inside the assets folder."""
    folders = {
        "robots/meshes": arm_meshes(),
        "grippers/meshes": gripper_meshes(),
        "objects/meshes": {"carton": carton((0.200, 0.080, 0.080))},
    }
    return {
        f"{folder}/{name}.obj": mesh.to_obj()
        for folder, meshes in folders.items()
        for name, mesh in meshes.items()
    }


def main() -> None:
    """Writes the files."""
    for name, text in generate().items():
        path = ASSETS / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        print(f"{path.relative_to(ASSETS)}: {len(text)} bytes")


if __name__ == "__main__":
    main()
