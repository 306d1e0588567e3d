"""Comparing many warped patches of an image with a template."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from tracker.affine import patch_loops
from tracker.affine.template import Template

_NO_MASK = np.empty((0, 0), np.uint8)


@dataclass(frozen=True, eq=False)
class Layers:
    """A grey image and what of it may show the target. Build with `of`."""

    grey: np.ndarray
    """(h, w) float32."""
    mask: np.ndarray
    """(h, w) uint8, 1 where a pixel may show the target; without elements if all may."""

    @classmethod
    def of(cls, image: np.ndarray, visibility: np.ndarray | None = None) -> Self:
        """Layers of a grey image (h, w) and its visibility (h, w), None where all is visible."""
        grey = np.ascontiguousarray(image, np.float32)
        if visibility is None:
            return cls(grey, _NO_MASK)
        return cls(grey, np.ascontiguousarray(visibility > 0, np.uint8))


@dataclass(frozen=True, eq=False)
class PatchFit:
    """How well patches under `n` warps match the template."""

    ncc: np.ndarray
    """(n,) correlation over the visible pixels; 0 where nothing is visible."""
    visible_fraction: np.ndarray
    """(n,) share of the samples that are visible."""
    cost: np.ndarray
    """(n,) mean Huber cost over the visible pixels [template variances]."""


class PatchMatcher:
    """One template with the buffers to compare it; belongs to one thread.

    Patches and template are normalised (zero mean, unit deviation) over the visible samples.
    """

    def __init__(self, template: Template) -> None:
        self.template = template
        samples = template.values.size
        self._points = np.ascontiguousarray(template.points[:2], np.float32)
        self._values = template.values.copy()
        self._jacobian = _of_residual(template)
        self._whole = (self._jacobian @ self._jacobian.T) / samples
        self._scratch = np.zeros((6, samples), np.float32)

    def fit(self, layers: Layers, warps: np.ndarray, clip: float) -> PatchFit:
        """Compares the patches under warps (n, 3, 3); residuals beyond `clip` count linearly."""
        out = np.empty((len(warps), 3))
        patch_loops.compare(
            layers.grey,
            layers.mask,
            warps,
            self._points,
            self._values,
            self.template.basis,
            clip,
            self._scratch,
            out,
        )
        return PatchFit(out[:, 0], out[:, 1], out[:, 2])

    def linearise(
        self, layers: Layers, warps: np.ndarray, clip: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Mean J^T r (n, 6) and J^T J (n, 6, 6) over the visible samples; (n, 2) their fit.

        Inverse compositional, as in [Kwon2014]. The fit is the visible fraction and the mean
        squared residual.
        """
        gradient = np.empty((len(warps), 6))
        information = np.empty((len(warps), 6, 6))
        fit = np.empty((len(warps), 2))
        patch_loops.linearise(
            layers.grey,
            layers.mask,
            warps,
            self._points,
            self._values,
            self.template.basis,
            self._jacobian,
            self._whole,
            clip,
            self._scratch,
            gradient,
            information,
            fit,
        )
        return gradient, information, fit

    def patch(self, layers: Layers, warp: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Normalised grey values (m,) under one warp (3, 3), and 1 (m,) where they are visible."""
        values, weights = (np.empty(self._points.shape[1], np.float32) for _ in range(2))
        total = patch_loops.sample(
            layers.grey, layers.mask, warp, self._points, values, weights, self._scratch[:3]
        )
        if total >= 1.0:
            patch_loops.normalise(values, weights, total, np.float32(1.0), values)
        return values, weights


def _of_residual(template: Template) -> np.ndarray:
    """(6, m) derivative of the normalised values less what the basis explains.

    Mean, deviation and the part in the basis move with the warp as well, so the parts along 1, the
    values and the basis drop out.
    """
    values, basis = template.values, template.basis
    J = template.jacobian.T.astype(float)
    J -= J.mean(axis=1, keepdims=True)
    J -= (J @ values / len(values))[:, None] * values
    if len(basis):
        J -= (J @ basis.T) @ basis
    return np.ascontiguousarray(J, np.float32)
