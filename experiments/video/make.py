"""Renders the benchmark's sequences, each with a random stream of its own, and explains them.

No sequence depends on which others are made, in which order, or by how many processes.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path

import cv2
import numpy as np

from experiments.report.report import Report
from experiments.report.table import Table, words
from experiments.seeding import Stream, generator
from experiments.study.files import write_whole
from experiments.study.provenance import package_version, provenance
from experiments.study.study import Result, Results
from experiments.video.clips import RECIPES
from experiments.video.rendered import RenderJob, RenderRow
from experiments.video.sequences import (
    AFFINE_FILE,
    AFFINE_HEADER,
    CORNERS_FILE,
    CORNERS_HEADER,
    GROUND_TRUTH,
)
from sim.video.film import FilmImage, shoot

JPEG_QUALITY = 90

_README = Path(__file__).with_name("sequences_readme.md")
"""What the folder says of itself, with a place for the versions, the seed and the table."""


def sequence_rng(name: str, seed: int) -> np.random.Generator:
    """The generator that draws everything random about a sequence."""
    return generator(seed, Stream.FOOTAGE, name)


def render_sequences(jobs: Sequence[RenderJob]) -> list[Result[RenderRow]]:
    """Renders sequences, one after the other."""
    return [render_sequence(job) for job in jobs]


def render_sequence(job: RenderJob) -> Result[RenderRow]:
    """Renders a sequence: its images and truth are files of the folder of its name."""
    recipe = RECIPES[job.name]
    images = list(shoot(recipe.clip, sequence_rng(job.name, job.seed)))
    row = RenderRow(
        name=job.name,
        attributes=" ".join(recipe.attributes),
        frames=len(images),
        seed=job.seed,
        description=recipe.clip.description,
        outcome="done",
        **provenance(),
    )
    files = sequence_files(images, recipe.attributes)
    return Result((row,), files={f"{job.name}/{name}": data for name, data in files.items()})


def sequence_files(
    images: Sequence[FilmImage], attributes: Sequence[str]
) -> dict[str, str | bytes]:
    """The files of a sequence in the layout of OTB, the ground truth last."""
    boxes: list[str] = []
    affine, corners = [AFFINE_HEADER], [CORNERS_HEADER]
    files: dict[str, str | bytes] = {}
    for number, image in enumerate(images, start=1):
        files[f"img/{number:04d}.jpg"] = _jpeg(image)
        box, warp = image.truth.box, image.truth.warp
        boxes.append(_line([box[0] + 1, box[1] + 1, box[2], box[3]]))
        affine.append(f"{number},{_line([*warp[:2, :2].ravel(), *warp[:2, 2], image.visible])}")
        corners.append(f"{number},{_line(image.truth.corners.ravel())}")
    for name, lines in (
        (AFFINE_FILE, affine),
        (CORNERS_FILE, corners),
        ("attrs.txt", [",".join(attributes)]),
        (GROUND_TRUTH, boxes),
    ):
        files[name] = "\n".join(lines) + "\n"
    return files


def write_index(results: Results[RenderRow]) -> Report:
    """Writes `README.md` and the table of the sequences of a folder."""
    rows = results.good
    table = Table(
        [
            {"name": r.name, "challenges": r.attributes, "frames": r.frames, "shows": r.description}
            for r in rows
        ],
        words("name", "challenges", "frames", "shows"),
    )
    names = [row.name for row in rows]
    readme = _README.read_text(encoding="utf-8").format(
        beltgrasp=package_version("beltgrasp"),
        mujoco=rows[0].mujoco_version,
        seed=rows[0].seed,
        selection="" if names == list(RECIPES) else f" --only {','.join(names)}",
        table=table.to_markdown().rstrip(),
    )
    write_whole(results.path / "README.md", readme)
    paths = [results.path / "README.md"]
    return Report.of(results.path, {"sequences": table}, paths, (), results.notes)


def _jpeg(image: FilmImage) -> bytes:
    quality = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]
    return cv2.imencode(".jpg", image.pixels[..., ::-1], quality)[1].tobytes()


def _line(values: Iterable[float]) -> str:
    return ",".join(f"{value:.4f}" for value in values)
