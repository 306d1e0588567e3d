"""Depth as a time-of-flight camera sees it: noise by distance and angle, edges, no returns."""

import math
from dataclasses import dataclass

import cv2
import numpy as np

from sim.checks import require, require_positive, require_within


@dataclass(frozen=True)
class TimeOfFlight:
    """Depth errors of a Kinect v2, after calibration: its constant offset is not modelled."""

    edge_step_m: float = 0.05
    """Where depth spans more than this between a pixel and its neighbours, the pixel mixes the
    light of two surfaces."""
    edge_hole_share: float = 0.5
    """Share of those pixels that the camera discards; the others show a place in between, the
    flying pixels of [Wasenmueller2016]. The share is an assumption."""
    grazing_rad: float = math.radians(80.0)
    """Surfaces seen at a flatter angle return too little light. The noise model ends here too."""

    def __post_init__(self) -> None:
        require_positive(self, "edge_step_m")
        require_within(self, 0.0, 1.0, "edge_hole_share")
        half_of_pi = 0.5 * math.pi
        require(self, "between 0 and half of pi", lambda v: 0.0 < v < half_of_pi, ["grazing_rad"])

    def measure(
        self, depth_m: np.ndarray, K: np.ndarray, normal: np.ndarray, uniform: np.ndarray
    ) -> np.ndarray:
        """The depth image that the camera gives for a true one.

        Args:
            depth_m: (h, w) float32 true depth along the optical axis.
            K: (3, 3) intrinsics of the image.
            normal: (h, w) draws from the standard normal distribution, for the noise.
            uniform: (h, w) draws from 0 to 1, for what happens at edges.

        Returns:
            (h, w) float32 depth [m]; 0 is no return.
        """
        angle_rad = incidence_angle_rad(depth_m, K)
        measured = depth_m + normal * noise_std_m(depth_m, np.minimum(angle_rad, self.grazing_rad))
        measured[angle_rad > self.grazing_rad] = 0.0
        square = np.ones((3, 3), np.uint8)
        near, far = cv2.erode(depth_m, square), cv2.dilate(depth_m, square)
        rows, columns = np.nonzero(far - near > self.edge_step_m)
        draw, closest = uniform[rows, columns], near[rows, columns]
        share = (draw - self.edge_hole_share) / max(1.0 - self.edge_hole_share, 1e-6)
        between = closest + share * (far[rows, columns] - closest)
        measured[rows, columns] = np.where(draw < self.edge_hole_share, 0.0, between)
        return measured


def noise_std_m(depth_m: np.ndarray, angle_rad: np.ndarray) -> np.ndarray:
    """Standard deviation of depth noise, any shape, under indoor light.

    Source: [Fankhauser2015], axial noise of the Kinect v2:
    `σ_z = 1.5 - 0.5 z + 0.3 z² + 0.1 z^(3/2) θ² / (π/2 - θ)²` in mm, z in m, θ in rad.

    Args:
        depth_m: Distance z along the optical axis.
        angle_rad: Angle θ between the line of sight and the surface's normal, below π/2.
    """
    tilt = angle_rad / (0.5 * math.pi - angle_rad)
    z = depth_m
    return 1e-3 * (1.5 - 0.5 * z + 0.3 * z * z + 0.1 * z * np.sqrt(z) * tilt * tilt)


def incidence_angle_rad(depth_m: np.ndarray, K: np.ndarray) -> np.ndarray:
    """(h, w) angle between each line of sight and the normal of the surface that it meets.

    Inverse depth of a plane is linear in the image: with the ray r = (x, y, 1) it is n·r, where n
    is the plane's normal over its distance. So n = (∂ρ/∂x, ∂ρ/∂y, ρ - x ∂ρ/∂x - y ∂ρ/∂y) is exact
    on planes; across edges it means nothing.
    """
    height, width = (int(n) for n in depth_m.shape)
    x = ((np.arange(width) - K[0, 2]) / K[0, 0]).astype(np.float32)
    y = ((np.arange(height) - K[1, 2]) / K[1, 1]).astype(np.float32)[:, None]
    rho = 1.0 / depth_m

    def slope(dx: int, dy: int, focal_px: float) -> np.ndarray:
        scale, edge = 0.5 * focal_px, cv2.BORDER_REPLICATE
        return cv2.Sobel(rho, cv2.CV_32F, dx, dy, ksize=1, scale=scale, borderType=edge)

    n_x, n_y = slope(1, 0, K[0, 0]), slope(0, 1, K[1, 1])
    n_z = rho - x * n_x - y * n_y
    length = np.sqrt((n_x * n_x + n_y * n_y + n_z * n_z) * (x * x + y * y + 1.0))
    return np.arccos(np.minimum(rho / length, 1.0))
