"""Where to move so that the next pixel says most about the target: the gradient of a gain.

Two gains of a displacement of the vehicle, both at the predicted covariance P:

- `trace`, [Wu2022] Eq. 22 without its penalty: J = 1/2 tr(G H^T S^-1 H), half of what the update
  takes off the trace of the covariance;
- `log-det`: J = 1/2 log det(I + R^-1 H P H^T), the information that the pixel brings. [Wu2022]
  means the volume of the ellipsoid in Eq. 16 and replaces it by the trace in Eq. 17; this is the
  volume itself, since det(P+) = det(P-) det(R) / det(S).

Eq. 23 reads as if the displacement could be solved for, but its right side depends on it; evaluated
at zero it is one step along the gradient. Eq. 14 then normalises the step, so that B = b I and the
factor 1/2 of Eqs. 16 to 23 have no effect.
"""

from typing import Literal, TypeAlias

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tracker.bearing_only.measurements import PinholeCamera, PoseBelief, TargetBelief
from tracker.bearing_only.small_matrices import dot, inverse_and_determinant, product, sandwich
from tracker.geometry import camera_rotation

Gain: TypeAlias = Literal["trace", "log-det"]


def gain_gradient(
    kind: Gain, camera: PinholeCamera, pose: PoseBelief, target: TargetBelief, pixel_std_px: float
) -> NDArray[np.float64]:
    """(..., 3): dJ by a displacement of the vehicle in the world, at no displacement.

    Source: [Wu2022] Eqs. 24 to 36, f = 1, written in the camera's frame: R^(W->R) of Eqs. 25 to 36
    has z along the optical axis, unlike that of Eqs. 2, 13 and 15. Eq. 36 writes the adjugate of
    dS as det(dS) dS^-1, which is 0 times infinity when dS is singular, as it is for a target on
    the optical axis (the start of both experiments); here it is -S^-1 dS S^-1. G of Eqs. 21 and 22
    is the position's block of P P, with the whole covariance as Eq. 17 has it: P_pp^2 + P_pv P_vp.
    """
    leading = target.position_m.shape[:-1]
    gradients = _gradients(
        kind == "trace",
        camera.intrinsics_px[:2],
        pixel_std_px**2,
        camera_rotation(pose.R_world_body).reshape(-1, 3, 3),
        (target.position_m - pose.position_m).reshape(-1, 3),
        target.covariance.reshape(-1, 6, 6),
    )
    return gradients.reshape(*leading, 3)


@njit(cache=True, error_model="numpy")
def _gradients(
    is_trace: bool,
    s: np.ndarray,
    variance: float,
    R_camera_world: np.ndarray,
    offsets: np.ndarray,
    covariances: np.ndarray,
) -> np.ndarray:
    """`gain_gradient` for rotations (n, 3, 3), offsets to the target (n, 3), covariances (n, 6, 6).

    `s` (2,) are the focal lengths, and `variance` is that of a pixel's coordinates.
    """
    gradients, dH1, R1 = np.empty((len(offsets), 3)), np.zeros((2, 3)), np.zeros((2, 2))
    for n in range(len(offsets)):
        R_cw, P, offset = R_camera_world[n], covariances[n], offsets[n]
        x, y, z = dot(R_cw[0], offset), dot(R_cw[1], offset), dot(R_cw[2], offset)
        H1 = np.array([[s[0], 0.0, -s[0] * x / z], [0.0, s[1], -s[1] * y / z]])
        P1_H1_T = product(sandwich(R_cw, P[:3, :3]), H1.T)
        R1[0, 0] = R1[1, 1] = z**2 * variance
        S1 = product(H1, P1_H1_T) + R1
        S1_inverse, _ = inverse_and_determinant(S1)
        G1 = sandwich(R_cw, product(P[:3], P[:, :3]))
        GHS = product(product(G1, H1.T), S1_inverse)
        middle = product(product(S1_inverse, H1), GHS)
        h = -product(H1, R_cw) / z
        for i in range(3):  # the components of the displacement
            dz = -R_cw[2, i]
            dH1[:, 2] = -h[:, i]
            half = product(dH1, P1_H1_T)
            dS1 = half + half.T
            dS1[0, 0] += 2.0 * variance * z * dz
            dS1[1, 1] += 2.0 * variance * z * dz
            if is_trace:
                gradients[n, i] = np.sum(GHS.T * dH1) - 0.5 * np.sum(middle.T * dS1)
            else:
                gradients[n, i] = 0.5 * np.sum(S1_inverse.T * dS1) - 2.0 * dz / z
    return gradients
