"""Teaching: reference photographs of the object, from which the trackers' template is cut.

As in a real cell: before production the operator lays the object at a marked place on the still
belt, in normal light and without the arm in between, and the system's own camera takes pictures,
the object shifted by thirds of a pixel in between. Their mean shows what pixels average over; a
single one shows how they happened to fall, which counts when the object is a few pixels wide.
Which part of its bounding rectangle is the object's face is known from its drawing, as its size is.
Nothing of a later trial is known then.
"""

import math
from typing import Any

import numpy as np

from sim.belt.carriers import BELT_CENTRE_X_M, Pose
from sim.belt.task import ConveyorGrasp
from tracker.affine.template import Template
from tracker.belt.image import ArrayImage
from tracker.belt.rectify import OverheadView

PICTURE_M_PER_PX = 0.001
SHIFTS = 3
"""Places a pixel apart are divided into, each way."""


def reference_picture(task: ConveyorGrasp, physics: Any) -> np.ndarray:
    """(h, w) uint8 square-on picture of the object's top face, long axis along the columns.

    Leaves the physics in the teaching scene: reset the environment before going on.
    """
    distance_m = math.dist(task.view.position_m, (BELT_CENTRE_X_M, 0.0, 0.0))
    step_m = distance_m / task.K[0, 0] / SHIFTS
    shifts_m = [step_m * (k - 0.5 * (SHIFTS - 1)) for k in range(SHIFTS)]
    places = [(BELT_CENTRE_X_M + x, y) for x in shifts_m for y in shifts_m]
    pictures = [_picture_at(task, physics, *place) for place in places]
    return np.rint(np.mean(pictures, axis=0)).astype(np.uint8)


def _picture_at(task: ConveyorGrasp, physics: Any, x_m: float, y_m: float) -> np.ndarray:
    task.lay_for_teaching(physics, Pose(x_m, y_m, yaw_rad=0.5 * math.pi))
    rgb, _ = task.render(physics, "sensor")
    photograph = ArrayImage(rgb, None)
    length, width, height = task.prop.spec.size_m
    view = OverheadView(
        K=task.K,
        T_world_camera=task.view.T_world_camera,
        image_shape_px=photograph.shape_px,
        plane_z_m=height,
        x_range_m=(x_m - 0.5 * width, x_m + 0.5 * width),
        y_range_m=(y_m - 0.5 * length, y_m + 0.5 * length),
        m_per_px=PICTURE_M_PER_PX,
    )
    return view.rectify(photograph).grey


def reference_template(task: ConveyorGrasp, physics: Any) -> Template:
    """The trackers' template of the object on this cell's camera."""
    length, width, _ = task.prop.spec.size_m
    picture = reference_picture(task, physics)
    mask = task.prop.face(physics, picture.shape)
    return Template.of_picture(picture, size=(length, width), mask=mask)
