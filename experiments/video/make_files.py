"""The files of a rendered sequence, and what lies beside the sequences to explain them."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import cv2

from experiments.video.sequences import GROUND_TRUTH
from sim.video.film import Frame

JPEG_QUALITY = 90
AFFINE_HEADER = "frame,a11,a12,a21,a22,x,y,visible"
CORNERS_HEADER = "frame,x1,y1,x2,y2,x3,y3,x4,y4"

README = """\
# Rendered sequences

Video sequences in the layout of OTB, rendered by beltgrasp {beltgrasp} with MuJoCo {mujoco}:

```sh
beltgrasp otb make --out DIR --seed {seed}{selection}
```

{table}

Each folder holds

- `img/0001.jpg` and so on: the images
- `groundtruth_rect.txt`: `x,y,w,h` of each image, x and y of the upper left corner counted from 1:
  the upright box around the whole target, be it hidden or outside the image
- `attrs.txt`: the challenges
- `affine.csv`: the true warp `[a11 a12 x; a21 a22 y]` from template coordinates (origin at the
  centre of the first box, unit sqrt(w h) of it, u right, v down) to pixels counted from 0, pixel
  centres at integers; and `visible`, the share of the target that can be seen, 0 to 1
- `corners.csv`: corners of the target's front, pixels counted from 0: top left, top right, bottom
  right, bottom left
- `source.json`: seed, versions, and a hash of all that was set

The warp is exact for a flat target that faces the camera. Where it turns out of the image plane,
is bent or pulled, the warp is the least-squares affine map of the points of its front from where
they are on the first image. What each clip shows and how truth is defined: `docs/sequences.md`.
"""


@dataclass(frozen=True)
class Source:
    """Where a sequence comes from; `source.json` in its folder, a row in `sequences.csv`."""

    name: str
    attributes: str
    """Tags, separated by blanks."""
    frames: int
    seed: int
    recipe: str
    """Hash of all that the recipe says."""
    beltgrasp: str
    """Version of the package."""
    commit: str
    mujoco: str
    """Version of MuJoCo."""
    description: str


def write_sequence(folder: Path, frames: Iterable[Frame], source: Source) -> None:
    """Writes images and truth of a sequence into an empty folder."""
    (folder / "img").mkdir()
    boxes: list[str] = []
    affine, corners = [AFFINE_HEADER], [CORNERS_HEADER]
    for number, frame in enumerate(frames, start=1):
        _write_image(folder / "img" / f"{number:04d}.jpg", frame)
        box, warp = frame.truth.box, frame.truth.warp
        boxes.append(_line([box[0] + 1, box[1] + 1, box[2], box[3]]))
        affine.append(f"{number},{_line([*warp[:2, :2].ravel(), *warp[:2, 2], frame.visible])}")
        corners.append(f"{number},{_line(frame.truth.corners.ravel())}")
    for name, lines in (
        (GROUND_TRUTH, boxes),
        ("affine.csv", affine),
        ("corners.csv", corners),
        ("attrs.txt", [",".join(source.attributes.split())]),
        ("source.json", [json.dumps(asdict(source), indent=2)]),
    ):
        (folder / name).write_text("\n".join(lines) + "\n", encoding="utf-8")


def read_source(folder: Path) -> Source:
    """The source of a sequence; ValueError where the folder does not tell."""
    path = folder / "source.json"
    if not path.exists():
        raise ValueError(f"{folder} was not made by this command; choose another folder")
    try:
        return Source(**json.loads(path.read_text(encoding="utf-8")))
    except (ValueError, TypeError) as error:
        raise ValueError(f"{path}: not the source of a sequence: {error}") from None


def write_index(out: Path, sources: Sequence[Source], selection: str) -> None:
    """Writes `sequences.csv` and `README.md` for the sequences of these sources.

    `selection` is what the command line must say to get these and no others, if anything.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(field.name for field in fields(Source))
    writer.writerows(asdict(source).values() for source in sources)
    (out / "sequences.csv").write_text(text.getvalue(), encoding="utf-8")
    rows = [f"| {s.name} | {s.attributes} | {s.frames} | {s.description} |" for s in sources]
    table = "\n".join(["| name | challenges | frames | shows |", "|---|---|---|---|", *rows])
    last = sources[-1]
    readme = README.format(
        beltgrasp=last.beltgrasp,
        mujoco=last.mujoco,
        seed=last.seed,
        selection=selection,
        table=table,
    )
    (out / "README.md").write_text(readme, encoding="utf-8")


def _write_image(path: Path, frame: Frame) -> None:
    quality = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]
    if not cv2.imwrite(str(path), frame.image[..., ::-1], quality):
        raise OSError(f"{path}: cannot be written")


def _line(values: Iterable[float]) -> str:
    return ",".join(f"{value:.4f}" for value in values)
