"""Writes the meshes of the assets folder: `python assets/generate.py`.

Every mesh is made here from a few radii and outlines, so no binary file and nobody else's model is
in the repository. Lengths are metres. The arm is built of revolved profiles, placed and repeated
by the files in `robots/`; the grippers of bevelled plates; the objects have texture coordinates.
A test runs this and compares.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from shapes import Mesh, can, carton, joined, plate, printed_from_above, revolved, rounded, turned

ASSETS = Path(__file__).resolve().parent


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


def _tabletop(radius: float, thickness: float) -> Mesh:
    """Disc of the turntable, its upper side at z = 0."""
    corners = [(radius, -thickness, 0.0), (radius, 0.0, 0.002), (radius - 0.004, 0.0, 0.0)]
    return revolved(corners, segments=96)


def object_meshes() -> dict[str, Mesh]:
    """The objects, in their own frames, with texture coordinates for `sim/belt/artwork.py`."""
    return {
        "carton": carton((0.200, 0.080, 0.080)),
        "small-carton": carton((0.120, 0.060, 0.060)),
        "can": can(radius=0.033, height=0.110),
        "flask": printed_from_above(flask(), 0.190, 0.072),
    }


def flask() -> Mesh:
    """Flat flask lying on its side, 190 x 72 x 50 mm: a body with round ends, a neck, a cap."""
    angles = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 17)
    end = 0.036 * np.column_stack([np.cos(angles), np.sin(angles)])
    shoulder, bottom = np.array([0.014, 0.0]), np.array([-0.059, 0.0])
    body = plate(np.concatenate([shoulder + end, bottom - end]), 0.050, 0.003)
    neck = revolved(
        [
            (0.013, 0.045, 0.0),
            (0.013, 0.073, 0.0),
            (0.017, 0.073, 0.001),
            (0.017, 0.095, 0.002),
        ]
    )
    lying = turned(body, (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    return joined(lying, turned(neck, (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))


def generate() -> dict[str, str]:
    """Text of every mesh file, by its path inside the assets folder."""
    folders = {
        "robots/meshes": arm_meshes(),
        "grippers/meshes": gripper_meshes(),
        "objects/meshes": object_meshes(),
        "meshes": {"disc": _tabletop(radius=0.37, thickness=0.02)},
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
