"""What the target looks like: a template cut from the first box that follows slow changes.

The patches of a tracked target change; their running average, anchored on the first picture, is the
template, and where a basis is kept their main variations cost nothing.
"""

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np

from tracker.affine.patches import Layers, PatchMatcher
from tracker.affine.template import Template
from tracker.checks import require_count, require_share
from tracker.video.window import Window

_LEAST_VISIBLE = 0.8
"""Share of a patch that must be in the image for the template to learn it."""


@dataclass(frozen=True)
class SubspaceConfig:
    """Size and memory of the basis."""

    rank: int = 4
    """Components kept; a large basis explains the background as well."""
    batch: int = 5
    """Patches gathered before the basis is updated."""
    forgetting: float = 0.95
    """Factor on the old singular values at each update."""

    def __post_init__(self) -> None:
        require_count(self, "rank", "batch")
        require_share(self, "forgetting")


class Subspace:
    """The main variations of the normalised patches seen so far, around their running mean.

    A sequential Karhunen-Loeve update with forgetting, as in the incremental visual tracker
    [Ross2008].
    """

    def __init__(self, config: SubspaceConfig, first: np.ndarray) -> None:
        """Begins with the patch `first` (n,) as the mean and an empty basis."""
        self._config = config
        self._mean = first.astype(float)
        self._count = 1.0
        self._singular_values = np.zeros(0)
        self._waiting: list[np.ndarray] = []
        self.basis = np.empty((0, len(first)), np.float32)
        """(k, n) orthonormal rows, each also orthogonal to a constant patch."""

    def add(self, patch: np.ndarray) -> None:
        """Takes a patch (n,) of zero mean; every `batch` of them the basis is new."""
        self._waiting.append(patch.astype(float))
        if len(self._waiting) == self._config.batch:
            self._merge(np.stack(self._waiting))
            self._waiting.clear()

    def _merge(self, patches: np.ndarray) -> None:
        """One SVD of old basis, centred patches and shift of the mean. [Ross2008] section 3.1."""
        old, new = self._config.forgetting * self._count, float(len(patches))
        batch_mean = patches.mean(axis=0)
        shift = math.sqrt(old * new / (old + new)) * (batch_mean - self._mean)
        weighted = (self._config.forgetting * self._singular_values)[:, None] * self.basis
        stack = np.vstack([weighted, patches - batch_mean, shift])
        _, singular_values, rows = np.linalg.svd(stack, full_matrices=False)
        known = singular_values > 1e-6 * max(singular_values[0], 1e-12)
        kept = slice(min(self._config.rank, int(known.sum())))
        self._singular_values = singular_values[kept]
        self.basis = rows[kept].astype(np.float32)
        self._mean += new / (old + new) * (batch_mean - self._mean)
        self._count = old + new


@dataclass(frozen=True)
class AppearanceConfig:
    """Samples, smoothing and learning of the template."""

    grid: int = 32
    """Rows and columns of template samples; also the window's pixels to a template unit."""
    blurs: tuple[float, ...] = (0.1,)
    """Deviations of the Gaussians that smooth window and template [template units], from coarse to
    fine: successive linearisations of an image take one after the other, the last one weighs."""
    update_rate: float = 0.02
    """Share of a well matched new patch in the running average of the template."""
    anchor: float = 0.0
    """Share of the first picture in the template, against drift; the average has the rest."""
    update_ncc: float = 0.5
    """Correlation from which a patch counts as well matched."""
    subspace: SubspaceConfig | None = None
    """Variations of the patches that cost nothing; None: every difference counts."""

    def __post_init__(self) -> None:
        require_count(self, "grid", least=4)
        is_good = all(math.isfinite(blur) and blur > 0 for blur in self.blurs)
        if not (self.blurs and is_good and sorted(self.blurs, reverse=True) == list(self.blurs)):
            raise ValueError(f"blurs must be positive and fall, got {self.blurs!r}")
        require_share(self, "update_rate", "anchor", "update_ncc")


@dataclass(frozen=True, eq=False)
class Fit:
    """What an image shows at the estimate."""

    patch: np.ndarray
    """(n,) normalised grey values."""
    visible_fraction: float
    """Share of the patch inside the image."""
    ncc: float
    """Correlation with the template over what is visible."""


class Appearance:
    """The target under one of the blurs."""

    def __init__(
        self, config: AppearanceConfig, blur: float, window: Window, box: np.ndarray
    ) -> None:
        """Cuts the template from `box` (x, y, w, h) [px] of the image that `window` shows.

        Raises ValueError where there is no texture.
        """
        self._config = config
        self._blur_px = blur * config.grid
        values = _samples(self._smooth(window), window.to_window, box, config.grid)
        self._first = Template.of_samples(values, (float(box[2]), float(box[3])))
        self._average = self._first.values.copy()
        self._subspace = None
        if config.subspace is not None:
            self._subspace = Subspace(config.subspace, self._first.values)
        self.matcher = PatchMatcher(self._first)

    def layers(self, window: Window) -> Layers:
        """The window as smooth as the template."""
        return Layers.of(self._smooth(window))

    def fit(self, layers: Layers, warp: np.ndarray) -> Fit:
        """How the patch under one warp (3, 3) of the window matches."""
        patch, visible = self.matcher.patch(layers, warp)
        ncc = _correlation(self.matcher.template.values, patch, visible)
        return Fit(patch, float(visible.mean()), ncc)

    def learn(self, fit: Fit) -> None:
        """Follows a well matched patch."""
        config = self._config
        is_good = fit.ncc >= config.update_ncc and fit.visible_fraction > _LEAST_VISIBLE
        if not is_good or config.update_rate == 0.0:
            return
        self._average += config.update_rate * (fit.patch - self._average)
        template = self._first.blended(self._average, 1.0 - config.anchor)
        if self._subspace is not None:
            self._subspace.add(fit.patch)
            template = replace(template, basis=self._subspace.basis)
        self.matcher = PatchMatcher(template)

    def _smooth(self, window: Window) -> np.ndarray:
        return cv2.GaussianBlur(window.grey, (0, 0), self._blur_px)


def _samples(grey: np.ndarray, to_window: np.ndarray, box: np.ndarray, grid: int) -> np.ndarray:
    """(grid, grid) values of the window over the box."""
    x, y, w, h = (float(v) for v in box)
    left, top = x - 0.5 + 0.5 * w / grid, y - 0.5 + 0.5 * h / grid
    step = np.array([[w / grid, 0, left], [0, h / grid, top], [0, 0, 1.0]])
    return cv2.warpAffine(
        grey,
        (to_window @ step)[:2],
        (grid, grid),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )


def _correlation(template: np.ndarray, patch: np.ndarray, visible: np.ndarray) -> float:
    """Correlation of normalised values over the visible samples; 0 where none is."""
    count = float(visible.sum())
    if count < 1:
        return 0.0
    return float(np.clip((visible * template * patch).sum() / count, -1.0, 1.0))
