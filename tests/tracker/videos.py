"""A synthetic video: a textured target that moves, turns and grows over a textured ground."""

import cv2
import numpy as np

SIZE_PX = (48, 36)


def texture(rng, height, width, grain_px):
    coarse = rng.random((height // grain_px + 2, width // grain_px + 2, 3)).astype(np.float32)
    return (255 * cv2.resize(coarse, (width, height), interpolation=cv2.INTER_CUBIC)).clip(0, 255)


def film(warps, seed=0, shape=(180, 240), noise=2.0):
    """BGR images (n) of the target under warps from its centre and sqrt(w h) to pixels."""
    rng = np.random.default_rng(seed)
    ground, target = texture(rng, *shape, 20), texture(rng, SIZE_PX[1], SIZE_PX[0], 6)
    w, h = SIZE_PX
    unit = np.sqrt(w * h)
    to_template = np.array([[1 / unit, 0, -(w - 1) / 2 / unit], [0, 1 / unit, -(h - 1) / 2 / unit]])
    images = []
    for warp in warps:
        M = (warp @ np.vstack([to_template, [0, 0, 1]]))[:2]
        size = shape[::-1]
        cover = cv2.warpAffine(np.ones((h, w), np.float32), M, size)[..., None]
        picture = cv2.warpAffine(target, M, size, borderMode=cv2.BORDER_REPLICATE)
        image = cover * picture + (1 - cover) * ground
        image += rng.normal(0.0, noise, image.shape)
        images.append(image.clip(0, 255).astype(np.uint8))
    return images
