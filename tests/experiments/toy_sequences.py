"""Tiny sequences: a textured patch that wanders over a textured ground."""

import cv2
import numpy as np

SIZE = 64, 48
BOX = 20, 16
FRAMES = 8


def texture(rng, width, height):
    noise = rng.integers(0, 256, (height, width, 3)).astype(np.uint8)
    return cv2.GaussianBlur(noise, (0, 0), 1.0)


def paint_sequence(folder, frame_count=FRAMES, seed=0):
    """Writes img/ and the ground truth of a sequence, and returns its true boxes (1-based)."""
    rng = np.random.default_rng(seed)
    ground, patch = texture(rng, *SIZE), texture(rng, *BOX)
    (folder / "img").mkdir(parents=True)
    boxes = []
    for index in range(frame_count):
        x, y = 10 + 2 * (index % 10), 12 + index % 7
        image = ground.copy()
        image[y : y + BOX[1], x : x + BOX[0]] = patch
        cv2.imwrite(str(folder / "img" / f"{index + 1:04d}.png"), image)
        boxes.append((x + 1, y + 1, *BOX))
    lines = [",".join(map(str, box)) + "\n" for box in boxes]
    (folder / "groundtruth_rect.txt").write_text("".join(lines))
    return np.array(boxes, float)


def write_affine(folder, boxes, visible=1.0):
    """The affine truth of a target that only moves; `boxes` (n, 4) are 1-based."""
    unit = np.sqrt(boxes[0, 2] * boxes[0, 3])
    affine, corners = ["frame,a11,a12,a21,a22,x,y,visible"], ["frame,x1,y1,x2,y2,x3,y3,x4,y4"]
    for frame, (x, y, w, h) in enumerate(boxes, start=1):
        cx, cy = x - 1 + (w - 1) / 2, y - 1 + (h - 1) / 2
        left, right, top, bottom = cx - w / 2, cx + w / 2, cy - h / 2, cy + h / 2
        affine.append(f"{frame},{unit},0,0,{unit},{cx},{cy},{visible}")
        corners.append(f"{frame},{left},{top},{right},{top},{right},{bottom},{left},{bottom}")
    (folder / "affine.csv").write_text("\n".join(affine) + "\n")
    (folder / "corners.csv").write_text("\n".join(corners) + "\n")
