"""Where to move so that the next pixel tells most about the target: the gradient of a gain.

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

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tracker.bearing_only.frames import camera_rotation
from tracker.bearing_only.measurements import PinholeCamera, PoseBelief, TargetBelief
from tracker.bearing_only.observation import view_target
from tracker.bearing_only.target_filter import inverse_2x2

Gain: TypeAlias = Literal["trace", "log-det"]


def gain(
    kind: Gain, camera: PinholeCamera, pose: PoseBelief, target: TargetBelief, pixel_std_px: float
) -> NDArray[np.float64]:
    """(...,): J at the pose; what `gain_gradient` differentiates."""
    view = view_target(camera, pose, target.position_m)
    H, P = view.by_target, target.covariance[..., :3, :3]
    HPHT = H @ P @ np.swapaxes(H, -1, -2)
    S = HPHT + pixel_std_px**2 * np.eye(2)
    if kind == "log-det":
        return 0.5 * np.linalg.slogdet(S / pixel_std_px**2)[1]
    G = squared_position_block(target.covariance)
    return 0.5 * np.einsum("...ij,...ji->...", H @ G @ np.swapaxes(H, -1, -2), inverse_2x2(S))


def squared_position_block(P: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., 3, 3): the position's block of P P, which is G of [Wu2022] Eqs. 21 and 22.

    With the whole covariance of position and velocity, as Eq. 17 has it: P_pp^2 + P_pv P_vp.
    """
    return P[..., :3, :] @ P[..., :, :3]


def gain_gradient(
    kind: Gain, camera: PinholeCamera, pose: PoseBelief, target: TargetBelief, pixel_std_px: float
) -> NDArray[np.float64]:
    """(..., 3): dJ by a displacement of the vehicle in the world, at no displacement.

    Source: [Wu2022] Eqs. 24 to 36, f = 1, written in the camera's frame: R^(W->R) of Eqs. 25 to 36
    has z along the optical axis, unlike that of Eqs. 2, 13 and 15. Eq. 36 writes the adjugate of
    dS as det(dS) dS^-1, which is 0 times infinity when dS is singular, as it is for a target on
    the optical axis (the start of both experiments); here it is -S^-1 dS S^-1.
    """
    R_cw = camera_rotation(pose.R_world_body)
    offset = np.einsum("...ij,...j->...i", R_cw, target.position_m - pose.position_m)
    x, y, z = np.moveaxis(offset, -1, 0)
    s = np.array([camera.s_u_px, camera.s_v_px])
    H1 = np.zeros((*z.shape, 2, 3))
    H1[..., 0, 0], H1[..., 1, 1] = s
    H1[..., 0, 2], H1[..., 1, 2] = -s[0] * x / z, -s[1] * y / z
    R_wc = np.swapaxes(R_cw, -1, -2)
    P1 = R_cw @ target.covariance[..., :3, :3] @ R_wc
    R1 = z[..., None, None] ** 2 * pixel_std_px**2 * np.eye(2)
    S1_inverse = inverse_2x2(H1 @ P1 @ np.swapaxes(H1, -1, -2) + R1)
    # Per component i of the displacement, on a new axis before the matrices.
    h = -(H1 @ R_cw) / z[..., None, None]
    dz = -R_cw[..., 2, :]
    dH1 = np.zeros((*z.shape, 3, 2, 3))
    dH1[..., :, :, 2] = -np.swapaxes(h, -1, -2)
    half = dH1 @ (P1 @ np.swapaxes(H1, -1, -2))[..., None, :, :]
    dR1 = (2.0 * pixel_std_px**2 * z[..., None] * dz)[..., None, None] * np.eye(2)
    dS1 = half + np.swapaxes(half, -1, -2) + dR1
    if kind == "log-det":
        of_S1 = np.einsum("...ab,...iba->...i", S1_inverse, dS1)
        return 0.5 * of_S1 - 2.0 * dz / z[..., None]
    G1 = R_cw @ squared_position_block(target.covariance) @ R_wc
    GHS = G1 @ np.swapaxes(H1, -1, -2) @ S1_inverse
    middle = S1_inverse @ H1 @ GHS
    return np.einsum("...ja,...iaj->...i", GHS, dH1) - 0.5 * np.einsum(
        "...ab,...iba->...i", middle, dS1
    )
