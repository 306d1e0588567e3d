"""Views of a spheroid without a renderer: exact outlines, to which noise is added."""

import math

import numpy as np

from tracker.apple.attitude import unit
from tracker.apple.next_view import looking_at
from tracker.apple.spheroid import Spheroid, ellipse_of_cone
from tracker.apple.view import CameraPose, FruitStatus, FruitView, Sighting
from tracker.geometry import project, rays_of

K = np.array([[579.4, 0.0, 319.5], [0.0, 579.4, 239.5], [0.0, 0.0, 1.0]])
SIZE_PX = (640, 480)
CENTRE_M = np.array([0.9, 0.1, 0.5])
SEEN_FACING = 0.15
SKIN_STEP_PX = 8.0


def rotation(vector):
    """Rotation by a vector [rad]."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = np.asarray(vector) / angle
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * skew + (1.0 - math.cos(angle)) * skew @ skew


def direction(tilt_deg, turn_deg):
    """Unit vector so far from vertical, towards so many degrees about it."""
    tilt, turn = np.radians([tilt_deg, turn_deg])
    return np.array([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)])


def apple(axis=(0.0, 0.0, 1.0), aspect=0.85, radius_m=0.04, centre_m=CENTRE_M):
    return Spheroid(np.array(centre_m), unit(np.array(axis, float)), radius_m, aspect)


def hanging(rng, **fruit):
    """Calyx down, out of sight of a camera at the fruit's height."""
    return apple(direction(25.0 * math.sqrt(rng.uniform()), 360.0 * rng.uniform()), **fruit)


def facing(rng, **fruit):
    """Calyx towards the camera, 15 to 50 degrees off."""
    aside, turn = np.radians(rng.uniform(15.0, 50.0)), rng.uniform(0.0, 2.0 * math.pi)
    axis = [math.cos(aside), math.sin(aside) * math.cos(turn), math.sin(aside) * math.sin(turn)]
    return apple(axis, **fruit)


def approach(count=8, arc_deg=25.0, near_m=0.22, far_m=0.6, target_m=CENTRE_M):
    """Poses on an arc about the fruit that come nearer, the fruit a little off the middle."""
    poses = []
    for share in np.linspace(0.0, 1.0, count):
        yaw = math.radians(arc_deg) * (2.0 * share - 1.0)
        pitch = 0.5 * math.radians(arc_deg) * math.sin(0.5 * math.pi * 2.5 * share)
        back = np.array(
            [-math.cos(yaw) * math.cos(pitch), math.sin(yaw) * math.cos(pitch), math.sin(pitch)]
        )
        aim = target_m + 0.015 * np.array([math.sin(7.0 * share), math.cos(5.0 * share), 0.5])
        poses.append(looking_at(aim, target_m + (far_m + (near_m - far_m) * share) * back))
    return poses


def sighting(fruit, pose, **changes):
    """What a perfect camera and a perfect segmentation tell."""
    outline = fruit.outline_px(K, pose, 120)
    centre, semi_axes, angle = ellipse_of_cone(fruit.cone(pose), K)
    steps = np.arange(-semi_axes[0], semi_axes[0], SKIN_STEP_PX)
    grid = centre + np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    rays = rays_of(grid, K)
    inside = np.einsum("ni,ij,nj->n", rays, fruit.cone(pose), rays) > 0.0
    view = {
        "status": FruitStatus.FOUND,
        "centre_px": centre,
        "semi_axes_px": semi_axes,
        "major_angle_rad": angle,
        "calyx_px": fruit.calyx_px(K, pose) if fruit.calyx_facing(pose) > SEEN_FACING else None,
        "contour_px": outline,
        "skin_px": grid[inside],
        "skin_step_px": SKIN_STEP_PX,
    }
    return Sighting(FruitView(**(view | changes)), K, pose)


def noisy(fruit, pose, rng, *, noise_px=0.25, edge_px=0.3, pose_deg=0.5, leaves=()):
    """What a real one tells: a shifted, noisy outline, a rough pose, and no outline at leaves."""
    exact = sighting(fruit, pose)
    view = exact.view
    outline = view.contour_px
    count = len(outline)
    kernel = np.fft.fft([0.5, 0.5, 0.5, 0.5], count)
    along = np.real(np.fft.ifft(np.fft.fft(rng.standard_normal(count)) * kernel)) * noise_px
    outline = outline + unit(outline - view.centre_px) * (edge_px + along)[:, None]
    keep, bare, is_covered = np.ones(count, bool), np.ones(len(view.skin_px), bool), False
    for place, size in leaves:
        at = pose.rotation.T @ (place - pose.position_m)
        middle, reach = project(at, K), size * K[0, 0] / at[2]
        keep &= np.linalg.norm(outline - middle, axis=1) > reach
        bare &= np.linalg.norm(view.skin_px - middle, axis=1) > reach
        is_covered |= bool(np.linalg.norm(fruit.calyx_px(K, pose) - middle) < reach)
    calyx = view.calyx_px
    if calyx is not None:
        calyx = None if is_covered else calyx + rng.normal(0.0, 1.0, 2)
    told = CameraPose(
        pose.rotation @ rotation(rng.normal(0.0, math.radians(pose_deg), 3)),
        pose.position_m + rng.normal(0.0, 0.001, 3),
    )
    seen = sighting(
        fruit,
        pose,
        calyx_px=calyx,
        contour_px=outline[keep],
        arc_fraction=float(keep.mean()),
        skin_px=view.skin_px[bare],
    )
    return Sighting(seen.view, K, told)


def leaves_before(rng, count=3):
    """Leaves 3 cm in front of the fruit, that hide parts of its outline."""
    return [
        (CENTRE_M + np.array([-0.03, *rng.uniform(-0.045, 0.045, 2)]), rng.uniform(0.02, 0.03))
        for _ in range(count)
    ]
