"""Films of video: the box of a tracker on every image of a sequence, beside the true one."""

from pathlib import Path

import cv2
import numpy as np

from experiments.report.movie import Movie, caption
from experiments.video.job import VideoJob
from experiments.video.rendered import RenderJob
from experiments.video.scores import overlaps
from experiments.video.tracking import FROM_ONE, load_job_sequence, track

_FPS = 20
_TRUE, _ESTIMATE = (255, 255, 255), (255, 90, 40)


def film(job: VideoJob, path: Path) -> None:
    """Runs the job again and films its first run."""
    sequence = load_job_sequence(job)
    one = track(job, sequence)[0]
    with Movie(path, _FPS) as movie:
        for index, box in enumerate(one.boxes, start=one.run.first):
            picture = np.ascontiguousarray(sequence.image(index)[..., ::-1])
            true = sequence.boxes[index]
            _draw_box(picture, true, _TRUE)
            _draw_box(picture, np.array(box), _ESTIMATE)
            overlap = float(overlaps(np.array([box]), true[None])[0])
            caption(picture, f"{job}   image {index + 1}   overlap {overlap:.2f}")
            movie.add(_even(picture))


def film_sequence(job: RenderJob, path: Path) -> None:
    """Renders a sequence again into a film, with the true box."""
    from experiments.video.clips import RECIPES
    from experiments.video.make import sequence_rng
    from sim.video.film import shoot

    with Movie(path, _FPS) as movie:
        for image in shoot(RECIPES[job.name].clip, sequence_rng(job.name, job.seed)):
            picture = np.array(image.pixels)
            _draw_box(picture, image.truth.box + FROM_ONE, _TRUE)
            movie.add(_even(picture))


def _draw_box(picture: np.ndarray, box: np.ndarray, colour: tuple[int, int, int]) -> None:
    """Draws a 1-based box (4,) in place; none that has no area."""
    if np.isfinite(box).all() and (box[2:] > 0).all():
        x, y, w, h = (round(float(value)) for value in box)
        cv2.rectangle(picture, (x - 1, y - 1), (x + w - 2, y + h - 2), colour, 1, cv2.LINE_AA)


def _even(picture: np.ndarray) -> np.ndarray:
    """The picture without a last odd row or column, which the film's format cannot hold."""
    return picture[: picture.shape[0] // 2 * 2, : picture.shape[1] // 2 * 2]
