"""A discriminative correlation filter: where around the last place the target looks like itself.

Multi-channel, closed form per frequency, running averages of numerator and denominator: [DSST2014].
Features are orientation histograms of gradients [HOG2005] and cell means of grey and colour. It
knows translation, and size where several are tried [SAMF2014]; particles know the rest of the warp.
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np

from tracker.checks import require_count, require_positive
from tracker.video.histogram_loops import orientation_histograms

_CELL_PX = 4
_BINS = 9
_FARTHEST = 200
"""Cells from the last place to the border of a search in the whole image."""
_LEAST_SCORE = 0.05
"""No filter is amplified beyond what makes this a one: a target without edges scores nothing."""


@dataclass(frozen=True)
class CorrelationConfig:
    """Window, learning and regularisation of the correlation filter."""

    padding: float = 3.5
    """Side of the window in target sides."""
    support: float = 1.2
    """Side of the part of the window that the filter may look at [target sides]: background that
    stays would otherwise hold the score at the place that a target has left."""
    learning_rate: float = 0.025
    """Share of a new image in the running averages."""
    regularisation: float = 0.01
    """Added to the denominator."""
    target_width: float = 0.1
    """Deviation of the wanted response [target sides]."""
    scales: int = 3
    """Sizes of the target that are tried in each image, the last one in the middle."""
    scale_step: float = 1.04
    """Ratio of one size to the next smaller one."""

    def __post_init__(self) -> None:
        require_positive(
            self, "padding", "support", "learning_rate", "regularisation", "target_width"
        )
        require_count(self, "scales")
        if not (math.isfinite(self.scale_step) and self.scale_step > 1.0):
            raise ValueError(f"scale_step must be greater than 1, got {self.scale_step!r}")


@dataclass(frozen=True, eq=False)
class Response:
    """What a correlation filter answers in one image."""

    scores: np.ndarray
    """(rows, columns) float32; about 1 where the target is as learnt."""
    to_image: np.ndarray
    """(3, 3) column and row of a cell, counted from 0, to pixels x and y of its middle."""

    @property
    def peak(self) -> float:
        """Largest score."""
        return float(self.scores.max())

    @property
    def peak_px(self) -> np.ndarray:
        """(2,) x and y of the largest score, to a fraction of a cell."""
        row, column = np.unravel_index(int(np.argmax(self.scores)), self.scores.shape)
        x = column + _parabola(self.scores[row, :], int(column))
        y = row + _parabola(self.scores[:, column], int(row))
        return self._places(np.array([[x, y]]))[0]

    def at(self, points_px: np.ndarray) -> np.ndarray:
        """(n,) scores at points (n, 2), bilinear; 0 outside the window."""
        from_image = np.linalg.inv(self.to_image)
        cells = points_px @ from_image[:2, :2].T + from_image[:2, 2]
        cells = np.clip(cells, -1e4, 1e4).astype(np.float32)
        return cv2.remap(
            self.scores, cells[None, :, 0], cells[None, :, 1], cv2.INTER_LINEAR, borderValue=0
        )[0]

    def draw(self, count: int, sharpness: float, rng: np.random.Generator) -> np.ndarray:
        """(count, 2) places drawn with density exp(sharpness * score), even inside a cell.

        A clear peak takes them all; where several places compete, each gets its share.
        """
        density = np.exp(sharpness * (self.scores - self.peak).astype(float))
        cumulative: np.ndarray = np.cumsum(density)
        thresholds: np.ndarray = rng.random(count) * cumulative[-1]
        chosen = np.searchsorted(cumulative, thresholds)
        rows, columns = np.unravel_index(chosen, self.scores.shape)
        return self._places(np.stack([columns, rows], axis=1) + rng.random((count, 2)) - 0.5)

    def _places(self, cells: np.ndarray) -> np.ndarray:
        """(n, 2) pixels of columns and rows (n, 2)."""
        return cells @ self.to_image[:2, :2].T + self.to_image[:2, 2]


@dataclass(frozen=True, eq=False)
class ResponsePyramid:
    """Answers for several sizes of the target in one image."""

    levels: tuple[Response, ...]
    """The answers from the smallest size to the largest."""
    log_units: np.ndarray
    """(k,) logarithm of the template unit in pixels, rising."""

    @property
    def best(self) -> Response:
        """The level with the largest score."""
        return max(self.levels, key=lambda level: level.peak)

    @property
    def middle(self) -> Response:
        """The level of the size that was expected."""
        return self.levels[len(self.levels) // 2]

    def at(self, points_px: np.ndarray, log_units: np.ndarray) -> np.ndarray:
        """(n,) scores at points (n, 2) for sizes (n,), linear between levels.

        The end levels hold for sizes beyond.
        """
        scores = np.stack([level.at(points_px) for level in self.levels])
        if len(scores) == 1:
            return scores[0]
        place = np.interp(log_units, self.log_units, np.arange(len(scores)))
        low = np.minimum(place.astype(int), len(scores) - 2)
        share, each = place - low, np.arange(len(place))
        return (1.0 - share) * scores[low, each] + share * scores[low + 1, each]


class CorrelationFilter:
    """Learns one target and answers where it is; positions in pixels of BGR images."""

    def __init__(
        self, config: CorrelationConfig, size: tuple[float, float], unit_px: float
    ) -> None:
        """`size` is the target's width and height in template units, `unit_px` the resolution."""
        self._config = config
        columns, rows = (max(8, round(config.padding * side * unit_px / _CELL_PX)) for side in size)
        self._shape = rows, columns
        self._cell_units = _CELL_PX / unit_px
        self._taper = np.outer(np.hanning(rows + 2)[1:-1], np.hanning(columns + 2)[1:-1])
        sigma = config.target_width * unit_px / _CELL_PX
        self._wanted = np.fft.rfft2(_gaussian(rows, columns, sigma)).conj()
        reach = 0.5 * config.support * np.array(self._shape) / config.padding
        self._mask = np.outer(_plateau(rows, reach[0]), _plateau(columns, reach[1])).astype(
            np.float32
        )
        self._numerator = self._denominator = self._filter = np.zeros(0)
        self._gain = 1.0

    def start(self, image: np.ndarray, pose: np.ndarray) -> None:
        """Learns the target at `pose` (3, 3), a similarity from template units to pixels."""
        self._numerator, self._denominator = self._train(image, pose)
        self._gain = 1.0
        self._filter = self._solve()
        self._gain = 1.0 / max(self.respond(image, pose).peak, _LEAST_SCORE)
        self._filter *= self._gain

    def learn(self, image: np.ndarray, pose: np.ndarray) -> None:
        """Adds one more view of the target."""
        rate = self._config.learning_rate
        numerator, denominator = self._train(image, pose)
        self._numerator = (1 - rate) * self._numerator + rate * numerator
        self._denominator = (1 - rate) * self._denominator + rate * denominator
        self._filter = self._solve()

    def search(self, image: np.ndarray, pose: np.ndarray) -> ResponsePyramid:
        """Answers for the sizes of the configuration around that of `pose`."""
        step, count = math.log(self._config.scale_step), self._config.scales
        growths = step * (np.arange(count) - (count - 1) / 2)
        levels = [
            self.respond(image, pose @ np.diag([math.exp(g), math.exp(g), 1.0])) for g in growths
        ]
        return ResponsePyramid(tuple(levels), _log_unit(pose) + growths)

    def respond_everywhere(self, image: np.ndarray, pose: np.ndarray) -> Response:
        """Scores in the whole image for the size and the turn of `pose`.

        Its cells lie anywhere on the target, so a score is lower than where the window is centred.
        """
        height, width = image.shape[:2]
        corners = np.array([[0, width, 0, width], [0, 0, height, height]]) - 0.5
        to_pose = np.linalg.inv(pose)
        places = (to_pose[:2, :2] @ corners + to_pose[:2, 2:]) / self._cell_units
        places = np.clip(places, -_FARTHEST, _FARTHEST)
        low, high = np.floor(places.min(axis=1)), np.ceil(places.max(axis=1))
        own = np.array(self._shape[::-1])
        margin = np.maximum(np.ceil(0.5 * (high - low - own)), 0).astype(int)
        (x, y), (columns, rows) = margin, own + 2 * margin
        kernel = np.pad(np.fft.irfft2(self._filter, self._shape), ((0, 0), (y, y), (x, x)))
        middle = np.eye(3)
        middle[:2, 2] = 0.5 * (low + high) * self._cell_units
        return self._respond(image, pose @ middle, np.fft.rfft2(kernel), np.ones((rows, columns)))

    def respond(self, image: np.ndarray, pose: np.ndarray) -> Response:
        """Scores in a window around `pose`, turned as it is."""
        return self._respond(image, pose, self._filter, self._taper)

    def _respond(
        self, image: np.ndarray, pose: np.ndarray, spectrum: np.ndarray, taper: np.ndarray
    ) -> Response:
        scores = np.fft.irfft2(
            (spectrum * self._spectrum(image, pose, taper)).sum(axis=0), taper.shape
        )
        scores = np.fft.fftshift(scores).astype(np.float32)
        middle = np.array(taper.shape[::-1]) // 2
        return Response(scores, pose @ _from_grid(self._cell_units, middle))

    def _train(self, image: np.ndarray, pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        spectrum = self._spectrum(image, pose, self._taper)
        energy = (np.real(spectrum) ** 2 + np.imag(spectrum) ** 2).sum(axis=0)
        return self._wanted.conj() * spectrum.conj(), energy + self._config.regularisation

    def _solve(self) -> np.ndarray:
        """The filter of each channel, cut to its support as in [CSRT2017], in one step.

        What the cut takes from the score of the target on the first image, the gain gives back.
        """
        quotient = self._numerator / self._denominator
        space = np.fft.irfft2(quotient, self._shape)
        return np.fft.rfft2(space * (self._gain * self._mask))

    def _spectrum(self, image: np.ndarray, pose: np.ndarray, taper: np.ndarray) -> np.ndarray:
        """(channels, rows, columns // 2 + 1) of the features around `pose` times the taper."""
        size = np.array(taper.shape[::-1]) * _CELL_PX
        to_image = pose @ _from_grid(self._cell_units / _CELL_PX, 0.5 * (size - 1))
        patch = cv2.warpAffine(
            image,
            to_image[:2],
            size.tolist(),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )
        return np.fft.rfft2(features(patch) * taper)


def _from_grid(step: float, middle: np.ndarray) -> np.ndarray:
    """(3, 3) from column and row to coordinates with `step` between them, 0 at `middle` (2,)."""
    x, y = -step * middle
    return np.array([[step, 0, x], [0, step, y], [0, 0, 1.0]])


def _log_unit(pose: np.ndarray) -> float:
    """Logarithm of the template unit in pixels."""
    return 0.5 * math.log(np.linalg.det(pose[:2, :2]))


def features(patch: np.ndarray) -> np.ndarray:
    """(12, rows / 4, columns / 4) orientation histograms and cell means of a BGR patch, uint8."""
    rows, columns = patch.shape[0] // _CELL_PX, patch.shape[1] // _CELL_PX
    lab = cv2.cvtColor(patch, cv2.COLOR_BGR2Lab).astype(np.float32)
    grey = np.ascontiguousarray(lab[..., 0])
    out = np.empty((_BINS + 3, rows, columns), np.float32)
    orientation_histograms(grey, _CELL_PX, out[:_BINS])
    squares: np.ndarray = (out[:_BINS] ** 2).sum(axis=0)
    energy = cv2.blur(squares, (3, 3))
    out[:_BINS] = np.minimum(out[:_BINS] / np.sqrt(energy + 1.0), 0.6)
    means = cv2.resize(lab, (columns, rows), interpolation=cv2.INTER_AREA) / 255.0
    out[_BINS:] = np.moveaxis(means - means.mean(axis=(0, 1)), -1, 0)
    return out


def _gaussian(rows: int, columns: int, sigma: float) -> np.ndarray:
    """(rows, columns) response with its peak of 1 at the first element, wrapped around."""
    y, x = (np.fft.fftfreq(n, 1.0 / n) for n in (rows, columns))
    return np.exp(-0.5 * (x[None, :] ** 2 + y[:, None] ** 2) / sigma**2)


def _plateau(count: int, reach: float) -> np.ndarray:
    """(count,) 1 up to `reach` from the middle and 0 farther out, with a slope of two cells."""
    away = np.abs(np.arange(count) - count // 2)
    return np.clip(0.5 * (reach + 1.0 - away), 0.0, 1.0)


def _parabola(line: np.ndarray, place: int) -> float:
    """Offset of the peak of the parabola through a maximum and its neighbours, within 1/2."""
    if not 0 < place < len(line) - 1:
        return 0.0
    left, middle, right = (float(v) for v in line[place - 1 : place + 2])
    bend = left - 2 * middle + right
    return 0.5 * (left - right) / bend if bend < 0 else 0.0
