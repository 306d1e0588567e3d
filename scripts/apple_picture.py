"""Paints docs/images/apple.jpg: a world of each class with what is estimated after six images.

python scripts/apple_picture.py
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

import sim  # noqa: F401
from experiments.apple.film import draw_view, true_pose
from experiments.apple.photographs import SEGMENTED, ArmPhotographer, sighting
from experiments.apple.worlds import CLASSES, WorldId, draw_world
from experiments.report.movie import caption
from tracker.apple.attitude import axis_error_deg
from tracker.apple.silhouette_fit import fit_silhouettes

ROOT = Path(__file__).resolve().parents[1]
SEED, ASPECT, IMAGES = 1003, 0.92, 6


def panel(fruit_class: str) -> np.ndarray:
    """(480, 640, 3) the last of the images with the estimate drawn on it."""
    world = draw_world(WorldId(fruit_class, ASPECT, SEED))
    with world.build() as orchard:
        photographer = ArmPhotographer(orchard, SEED)
        photographs = [photographer(T) for T in world.approach[:IMAGES]]
    sightings = [sighting(photo, SEGMENTED) for photo in photographs if photo is not None]
    fit = fit_silhouettes(sightings)
    assert fit is not None and photographs[-1] is not None
    last = photographs[-1]
    image = draw_view(last.rgb, sightings[-1].view, fit, true_pose(last))
    error = float(axis_error_deg(fit.axis, world.fruit.axis))
    caption(image, f"{fruit_class}: axis {error:.1f} deg off after {IMAGES} images")
    return image


def main() -> None:
    """Paints and writes the picture."""
    panels = [panel(name) for name in CLASSES]
    picture = np.vstack([np.hstack(panels[:2]), np.hstack(panels[2:])])
    path = ROOT / "docs" / "images" / "apple.jpg"
    cv2.imwrite(str(path), picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 88])
    print(path.relative_to(ROOT))


if __name__ == "__main__":
    main()
