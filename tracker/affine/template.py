"""The target's reference picture, sampled on a grid.

Template coordinates have their origin at the centre of the target and the unit sqrt(w h), the same
along both axes, so that a rotation of the template is a rotation in the image. u points right and
v down in the picture; a warp maps (u, v, 1) to image pixels.
"""

import math
from dataclasses import dataclass, field
from typing import Self

import cv2
import numpy as np

_PIXELS_PER_CELL = 5
_SAMPLE_COUNT = 360
_LEAST_COVER = 0.9
"""Share of a cell that must show the target for it to be a sample."""


@dataclass(frozen=True, eq=False)
class Template:
    """A normalised grey picture on a regular grid, with its derivatives. Build with `of_picture`.

    The Jacobian is the inverse-compositional one: constant for all warps and images.
    Source: [Kwon2014]; columns follow the algebra basis of [IGPF2021] Eq (5).
    """

    values: np.ndarray
    """(n,) float32, zero mean and unit standard deviation."""
    points: np.ndarray
    """(3, n) homogeneous template coordinates of the samples."""
    jacobian: np.ndarray
    """(n, 6) float32, derivative of the template under a right perturbation of its warp."""
    shape: tuple[int, int]
    """Rows and columns of the sampling grid, of which cells beside the target are no samples."""
    size: tuple[float, float]
    """Width and height of the target in template units; their product is 1."""
    picture: np.ndarray
    """(rows, columns) uint8 grey reference picture, for detection and drawing."""
    mask: np.ndarray
    """(rows, columns) bool, where the picture shows the target."""
    basis: np.ndarray = field(default_factory=lambda: np.empty((0, 0), np.float32))
    """(k, n) float32 orthonormal rows: ways in which the target may look different."""

    def __post_init__(self) -> None:
        for name in ("values", "points", "jacobian", "picture", "mask", "basis"):
            getattr(self, name).setflags(write=False)

    @classmethod
    def of_picture(
        cls,
        picture: np.ndarray,
        size: tuple[float, float],
        grid: tuple[int, int] | None = None,
        mask: np.ndarray | None = None,
    ) -> Self:
        """Template of a `picture` (h, w) or RGB (h, w, 3), uint8.

        Args:
            picture: the target seen square-on, its bounding rectangle filling the picture.
            size: width and height of that rectangle in any unit (metres, pixels).
            grid: rows and columns of the samples; None for 360 square cells.
            mask: (h, w) bool, where the picture shows the target; None where it does all over.
        """
        grey = _grey(picture)
        mask = np.ones(grey.shape, bool) if mask is None else np.array(mask, bool)
        if mask.shape != grey.shape:
            raise ValueError(f"mask must be {grey.shape} as the picture is, got {mask.shape}")
        rows, columns = grid or square_cells(size, _SAMPLE_COUNT)
        if min(rows, columns) < 4:
            raise ValueError(f"grid must have at least 4 rows and 4 columns, got {grid}")
        cells = _smooth_samples(grey, (rows, columns))
        return cls._build(cells, size, grey, mask)

    @classmethod
    def of_samples(
        cls, values: np.ndarray, size: tuple[float, float], texture_std: float = 1.0
    ) -> Self:
        """Template of smooth grey values (rows, columns) on a grid over the target.

        Raises ValueError where their deviation is below `texture_std`.
        """
        values = np.asarray(values, float)
        Tv, Tu = np.gradient(values)
        spread = np.ptp(values) or 1.0
        picture = np.rint(255 * (values - values.min()) / spread).astype(np.uint8)
        mask = np.ones(picture.shape, bool)
        return cls._build((values, Tu, Tv), size, picture, mask, texture_std)

    def blended(self, patch: np.ndarray, share: float) -> Self:
        """The template, one without a mask, with a share of a normalised patch in its values."""
        values = (1.0 - share) * self.values + share * patch
        return self.of_samples(values.reshape(self.shape), self.size, texture_std=0.0)

    @classmethod
    def _build(
        cls,
        cells: tuple[np.ndarray, np.ndarray, np.ndarray],
        size: tuple[float, float],
        picture: np.ndarray,
        mask: np.ndarray,
        texture_std: float = 1.0,
    ) -> Self:
        """Normalises values and their derivatives per cell, each (rows, columns)."""
        _require_size(size)
        width, height = size
        rows, columns = (int(n) for n in cells[0].shape)
        is_sample = _cover(mask, (rows, columns)) >= _LEAST_COVER
        values, Tu, Tv = (cell[is_sample] for cell in cells)
        unit = math.sqrt(width * height)
        w, h = width / unit, height / unit
        u: np.ndarray = ((np.arange(columns) + 0.5) / columns - 0.5) * w
        v: np.ndarray = ((np.arange(rows) + 0.5) / rows - 0.5) * h
        deviation = values.std() if values.size else 0.0
        if deviation <= 1e-6 or deviation < texture_std:
            raise ValueError("picture must have texture: its grey values are all but equal")
        values = (values - values.mean()) / deviation
        uu, vv = (axis[is_sample] for axis in np.meshgrid(u, v))
        J = _jacobian(Tu * columns / (w * deviation), Tv * rows / (h * deviation), uu, vv)
        return cls(
            values=values.astype(np.float32),
            points=np.stack([uu, vv, np.ones(uu.size)]),
            jacobian=J.astype(np.float32),
            shape=(rows, columns),
            size=(w, h),
            picture=picture,
            mask=mask,
        )

    def smoothing_px(self, unit_px: float) -> float:
        """Deviation of the Gaussian that blurs an image as much as a template cell averages.

        `unit_px` is the length of the template unit in the image [px].
        """
        cell_px = unit_px * math.sqrt(1.0 / (self.shape[0] * self.shape[1]))
        return cell_px / math.sqrt(12.0)

    @property
    def corners(self) -> np.ndarray:
        """(3, 4) homogeneous corners: top left, top right, bottom right, bottom left."""
        w, h = self.size
        return np.array([[-w, w, w, -w], [-h, -h, h, h], [2, 2, 2, 2]]) / 2


def square_cells(size: tuple[float, float], count: int) -> tuple[int, int]:
    """Rows and columns of about `count` square cells over a target of a width and a height."""
    _require_size(size)
    width, height = size
    rows = max(round(math.sqrt(count * height / width)), 4)
    return rows, max(round(count / rows), 4)


def _require_size(size: tuple[float, float]) -> None:
    if not (len(size) == 2 and all(math.isfinite(side) and side > 0 for side in size)):
        raise ValueError(f"size must be two positive numbers (width, height), got {size}")


def _cover(mask: np.ndarray, grid: tuple[int, int]) -> np.ndarray:
    """(rows, columns) share of each cell that shows the target."""
    fine = tuple(_PIXELS_PER_CELL * n for n in grid[::-1])
    cover = cv2.resize(mask.astype(np.float32), fine, interpolation=cv2.INTER_LINEAR)
    return cv2.resize(cover, grid[::-1], interpolation=cv2.INTER_AREA)


def _smooth_samples(
    grey: np.ndarray, grid: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cell averages on the grid and their derivatives along columns and rows, per cell.

    Differentiated at several pixels a cell: differences between neighbouring cells would miss most
    of the gradient of a fine texture.
    """
    rows, columns = grid
    fine = _PIXELS_PER_CELL
    size = (columns * fine, rows * fine)
    is_reduced = grey.shape[0] >= size[1] and grey.shape[1] >= size[0]
    interpolation = cv2.INTER_AREA if is_reduced else cv2.INTER_LINEAR
    picture = cv2.resize(grey, size, interpolation=interpolation).astype(np.float64)
    smooth = cv2.blur(picture, (fine, fine), borderType=cv2.BORDER_REPLICATE)
    Tv, Tu = np.gradient(smooth)
    centre = (slice(fine // 2, None, fine), slice(fine // 2, None, fine))
    return smooth[centre], fine * Tu[centre], fine * Tv[centre]


def _jacobian(Tu: np.ndarray, Tv: np.ndarray, uu: np.ndarray, vv: np.ndarray) -> np.ndarray:
    """(n, 6) columns `grad T . (E_i p)` of (n,) samples. [IGPF2021] Eq (5), [Kwon2014]."""
    columns = [uu * Tu + vv * Tv, uu * Tu - vv * Tv, uu * Tv - vv * Tu, vv * Tu + uu * Tv, Tu, Tv]
    return np.stack(columns, axis=1)


def _grey(picture: np.ndarray) -> np.ndarray:
    """(h, w) uint8 copy of a grey or RGB picture; ValueError for anything else."""
    picture = np.asarray(picture)
    is_grey = picture.ndim == 2
    is_rgb = picture.ndim == 3 and picture.shape[2] == 3
    if picture.dtype != np.uint8 or not (is_grey or is_rgb) or min(picture.shape[:2]) < 4:
        raise ValueError(
            "picture must be uint8 (h, w) or (h, w, 3), at least 4 px a side, "
            f"got {picture.dtype} {picture.shape}"
        )
    return picture.copy() if is_grey else cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
