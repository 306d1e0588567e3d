"""Template feature matching over position and full rotation, without a previous estimate.

Normalised correlation with a bank of rotated templates at reduced resolution proposes candidates
(by FFT, the bank transformed once); Gauss-Newton on the group refines them, first on a coarse then
on the full template. Starts a track and finds the target again after a loss.
Source: [IGPF2021] Algorithm 1, step (b).
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np

from tracker.affine import aff2
from tracker.affine.likelihood import LikelihoodConfig, TemplateObservation, climb
from tracker.affine.patches import Layers, PatchMatcher
from tracker.affine.template import Template, square_cells
from tracker.checks import require_count, require_positive, require_share

_COARSE_COUNT = 160
"""Samples of the coarse level."""
_COARSE_BLUR = 0.03
"""Extra blur of the coarse level, template and image alike [template units]: a wider basin."""
_FLAT_DEVIATION = 1.0


@dataclass(frozen=True)
class DetectionConfig:
    """Search grid and what counts as found."""

    reduction: int = 4
    """Image pixels per pixel of the coarse search."""
    rotation_count: int = 24
    """Rotations in the bank, over a full turn; even."""
    candidate_count: int = 8
    """Coarse maxima that are refined."""
    iterations: int = 8
    """Gauss-Newton steps on each of the two refinement levels."""
    min_ncc: float = 0.72
    """Correlation of the refined match from which it counts."""
    min_margin: float = 0.05
    """Lead in correlation over the next different pose; 0 for objects with a symmetry."""
    min_visible_fraction: float = 0.7
    """Share of the template that must be visible, and its surface at the right height."""
    max_height_m: float = 0.03
    """A surface further than this above or below the plane is not the target's."""

    def __post_init__(self) -> None:
        require_count(self, "reduction", "candidate_count", "iterations")
        if self.rotation_count < 4 or self.rotation_count % 2:
            raise ValueError(
                f"rotation_count must be even and at least 4, got {self.rotation_count}"
            )
        require_share(self, "min_ncc", "min_margin", "min_visible_fraction")
        require_positive(self, "max_height_m")


@dataclass(frozen=True, eq=False)
class Detection:
    """One match of the template."""

    warp: np.ndarray
    """(3, 3) template -> image [px]."""
    ncc: float
    """Correlation over the visible template."""
    visible_fraction: float
    """Visible share of the template."""


@dataclass(frozen=True)
class Sighting:
    """A detection and when its image was exposed."""

    found: Detection
    time_s: float


@dataclass(frozen=True, eq=False)
class _Level:
    """One step of the refinement."""

    matcher: PatchMatcher
    blur_px: float


class TemplateDetector:
    """Finds a template of known size anywhere in images of one shape, at any rotation."""

    def __init__(
        self,
        template: Template,
        unit_px: float,
        image_shape_px: tuple[int, int],
        config: DetectionConfig,
    ) -> None:
        """Transforms the bank of rotated templates.

        Args:
            template: what to find.
            unit_px: length of the template unit in the image [px].
            image_shape_px: rows and columns of the images.
            config: search settings.
        """
        if not (math.isfinite(unit_px) and unit_px > 0):
            raise ValueError(f"unit_px must be a positive number, got {unit_px!r}")
        self._config = config
        self._unit_px = unit_px
        blurred = _blurred(template)
        grid = square_cells(template.size, _COARSE_COUNT)
        coarse = Template.of_picture(blurred, template.size, grid, template.mask)
        coarse_px = math.hypot(coarse.smoothing_px(unit_px), _COARSE_BLUR * unit_px)
        self._levels = (
            _Level(PatchMatcher(coarse), coarse_px),
            _Level(PatchMatcher(template), template.smoothing_px(unit_px)),
        )
        self._likelihood = LikelihoodConfig(independent_pixel_count=100.0, shape_std=0.02)
        coarse_unit = unit_px / config.reduction
        side = math.hypot(*template.size) * coarse_unit
        self._short_side = max(1, round(min(template.size) * coarse_unit))
        self._radius = max(2, math.ceil(side / 2))
        self._coarse_shape = tuple(math.ceil(n / config.reduction) for n in image_shape_px)
        padded = (n + 4 * self._radius for n in self._coarse_shape)
        self._fft_shape = tuple(cv2.getOptimalDFTSize(n) for n in padded)
        self._angles = np.arange(config.rotation_count) * 2 * np.pi / config.rotation_count
        self._bank, self._masks, self._mask_sums = self._transform_bank(template, coarse_unit)

    def detect(
        self,
        image: np.ndarray,
        visibility: np.ndarray | None = None,
        height_m: np.ndarray | None = None,
    ) -> Detection | None:
        """The best match in a grey image (h, w) if it is good, visible and unrivalled.

        Args:
            image: (h, w) uint8.
            visibility: (h, w) uint8, 0 where the plane is hidden.
            height_m: (h, w) height of the surface above the plane, NaN where unknown. A few grey
                pixels look like much; few things stand at the height of the target's face.
        """
        if visibility is None:
            visibility = np.ones(image.shape, np.uint8)
        support = visibility
        if height_m is not None:
            is_off = np.abs(height_m) > self._config.max_height_m  # false where unknown
            support = np.where(is_off, np.uint8(0), visibility)
        supported = support > 0
        if not supported.any() or float(image[supported].std()) < _FLAT_DEVIATION:
            return None
        warps = self._candidates(image, visibility, support)
        coarse, fine = (self._observe(level, image, visibility) for level in self._levels)
        for observation in (coarse, fine):
            warps = climb(observation, warps, self._config.iterations)
        share = self._observe(self._levels[1], image, support).fit(warps).visible_fraction
        return self._choose(warps, fine, share)

    def _observe(
        self, level: _Level, image: np.ndarray, visibility: np.ndarray
    ) -> TemplateObservation:
        smooth = cv2.GaussianBlur(image, (0, 0), level.blur_px)
        layers = Layers.of(smooth, visibility)
        return TemplateObservation(level.matcher, layers, self._likelihood, 0.5, self._unit_px)

    def _choose(
        self, warps: np.ndarray, observation: TemplateObservation, supported_share: np.ndarray
    ) -> Detection | None:
        config = self._config
        fit = observation.fit(warps)
        ncc = np.where(supported_share >= config.min_visible_fraction, fit.ncc, -1.0)
        best = int(np.argmax(ncc))
        if ncc[best] < config.min_ncc:
            return None
        away = aff2.difference(warps[best], warps)
        is_other = (np.hypot(away[:, 4], away[:, 5]) > 0.3) | (np.abs(away[:, 2]) > 0.35)
        if is_other.any() and ncc[is_other].max() > ncc[best] - config.min_margin:
            return None
        return Detection(warps[best], float(ncc[best]), float(fit.visible_fraction[best]))

    def _candidates(
        self, image: np.ndarray, visibility: np.ndarray, support: np.ndarray
    ) -> np.ndarray:
        """(k, 3, 3) warps at the largest, mutually different coarse correlations."""
        config = self._config
        scores = self._correlate(image, visibility)
        scores[:, self._support_about(support) < 0.5] = -2.0
        reach = max(1, self._radius // 4)
        warps: list[np.ndarray] = []
        for _ in range(config.candidate_count):
            turn, row, column = np.unravel_index(int(np.argmax(scores)), scores.shape)
            offset = 0.5 * (config.reduction - 1)
            centre = np.array([column, row]) * config.reduction + offset
            warps.append(aff2.similarity(self._unit_px, self._angles[turn], centre))
            near = np.arange(turn - 2, turn + 3) % config.rotation_count
            rows = slice(max(row - reach, 0), row + reach + 1)
            columns = slice(max(column - reach, 0), column + reach + 1)
            scores[near, rows, columns] = -2.0
        return np.stack(warps)

    def _support_about(self, support: np.ndarray) -> np.ndarray:
        """Share of support around every coarse pixel, as far as the template reaches each way."""
        small = cv2.resize(
            support.astype(np.float32), self._coarse_shape[::-1], interpolation=cv2.INTER_AREA
        )
        return cv2.blur(small, (self._short_side, self._short_side), borderType=cv2.BORDER_CONSTANT)

    def _correlate(self, image: np.ndarray, visibility: np.ndarray) -> np.ndarray:
        """(rotations, rows, columns) normalised correlation at every coarse pixel."""
        visible = visibility > 0
        filled = np.where(visible, image, image[visible].mean()).astype(np.float32)
        size = self._coarse_shape[::-1]
        small = cv2.resize(filled, size, interpolation=cv2.INTER_AREA)
        small -= small.mean()
        spectrum = np.fft.rfft2(small, self._fft_shape)
        square = np.fft.rfft2(small * small, self._fft_shape)
        product = self._back(spectrum * self._bank)
        total = self._back(spectrum * self._masks)
        total_square = self._back(square * self._masks)
        n = self._mask_sums[:, None, None]
        variance = np.maximum(total_square / n - (total / n) ** 2, _FLAT_DEVIATION**2)
        deviation = np.sqrt(np.concatenate([variance, variance]))
        return product / (np.concatenate([n, n]) * deviation)

    def _back(self, spectrum: np.ndarray) -> np.ndarray:
        rows, columns = self._coarse_shape
        r = self._radius
        return np.fft.irfft2(spectrum, self._fft_shape)[:, r : r + rows, r : r + columns]

    def _transform_bank(
        self, template: Template, coarse_unit: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Conjugate spectra of rotated templates (rotations) and masks (half a turn), mask sums."""
        side = 2 * self._radius + 1
        bank: list[np.ndarray] = []
        masks: list[np.ndarray] = []
        sums: list[float] = []
        for angle in self._angles:
            values, mask = _rotated(template, coarse_unit, angle, side)
            bank.append(values[::-1, ::-1])
            masks.append(mask[::-1, ::-1])
            sums.append(mask.sum())
        half = len(self._angles) // 2
        shape = self._fft_shape
        spectra = np.fft.rfft2(np.array(bank, np.float32), shape)
        mask_spectra = np.fft.rfft2(np.array(masks[:half], np.float32), shape)
        return spectra, mask_spectra, np.array(sums[:half])


def _blurred(template: Template) -> np.ndarray:
    """Reference picture blurred for the coarse level."""
    unit = math.sqrt(template.picture.shape[0] * template.picture.shape[1])
    return cv2.GaussianBlur(template.picture, (0, 0), _COARSE_BLUR * unit)


def _rotated(
    template: Template, coarse_unit: float, angle: float, side: int
) -> tuple[np.ndarray, np.ndarray]:
    """Normalised template (side, side) rotated about its centre, zero outside its mask."""
    height, width = template.picture.shape
    w, h = template.size
    fine = 4
    X = aff2.similarity(coarse_unit * fine, angle, np.full(2, (side * fine - 1) / 2))
    to_template = np.array(
        [[w / width, 0, (0.5 / width - 0.5) * w], [0, h / height, (0.5 / height - 0.5) * h]]
    )
    M = X[:2] @ np.vstack([to_template, [0, 0, 1]])
    size = (side * fine, side * fine)
    picture = cv2.warpAffine(template.picture.astype(np.float32), M, size, flags=cv2.INTER_AREA)
    cover = cv2.warpAffine(template.mask.astype(np.float32), M, size)
    picture = cv2.resize(picture, (side, side), interpolation=cv2.INTER_AREA)
    cover = cv2.resize(cover, (side, side), interpolation=cv2.INTER_AREA)
    mask = (cover > 0.9).astype(np.float32)
    values = picture - (picture * mask).sum() / mask.sum()
    values *= mask
    return values / math.sqrt((values**2).sum() / mask.sum()), mask
