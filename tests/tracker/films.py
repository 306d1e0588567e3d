"""A short film of a moving card, and what a baseline makes of it; importable from this folder."""

import hashlib

import cv2
import numpy as np
from scenes import box_picture

from tracker.peers.baselines import BASELINES

BOX = np.array([60.0, 50.0, 48.0, 32.0])
STEP_PX = (2.0, 1.0)


def film(count=11, step=STEP_PX):
    """BGR images of a textured card that moves by `step` over a darker, textured ground."""
    rng = np.random.default_rng(2)
    ground = 70 + cv2.GaussianBlur(rng.normal(0, 60, (180, 240)), (0, 0), 3)
    ground = ground.clip(0, 255).astype(np.uint8)
    x, y, w, h = BOX.astype(int)
    card = cv2.resize(box_picture(), (w, h), interpolation=cv2.INTER_AREA)
    images = []
    for k in range(count):
        image = ground.copy()
        left, top = x + round(k * step[0]), y + round(k * step[1])
        image[top : top + h, left : left + w] = card
        images.append(cv2.cvtColor(image, cv2.COLOR_GRAY2BGR))
    return images


def follow(name, images, seed=0, box=BOX):
    tracker = BASELINES[name].make(np.random.default_rng(seed))
    tracker.start(images[0], box)
    return tracker, [tracker.update(image) for image in images[1:]]


def digest(name, seed):
    _, estimates = follow(name, film(6), seed)
    return hashlib.sha256(np.array([e.box for e in estimates]).tobytes()).hexdigest()
