"""Graspable objects that ride on the belt."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from dm_control import composer, mjcf

from sim import ASSETS, textures
from sim.belt import artwork
from sim.checks import look_up


@dataclass(frozen=True)
class GraspableObject:
    """What is known of an object, and the file that models it."""

    name: str
    description: str
    xml: str
    """Path of the MJCF file inside the assets folder."""
    size_m: tuple[float, float, float]
    """Extent along its long axis x, across the grasp y, and height z."""
    mass_kg: float
    artwork: Callable[[], np.ndarray] | None = None
    """Paints the (h, w, 3) uint8 picture for the material `artwork` of the file, if it has one."""

    @property
    def grasp_depth_m(self) -> float:
        """How far below its top a hand takes it; the fingers of a low object stay off the belt."""
        return min(_GRASP_DEPTH_M, self.size_m[2] - _LOWEST_GRASP_M)


_GRASP_DEPTH_M = 0.035
_LOWEST_GRASP_M = 0.045
"""Least height of the tool centre point above the belt: 13 mm of it are below the fingers."""

OBJECTS: dict[str, GraspableObject] = {
    "box": GraspableObject(
        name="box",
        description="printed carton, 200 x 80 x 80 mm",
        xml="objects/box.xml",
        size_m=(0.200, 0.080, 0.080),
        mass_kg=0.5,
        artwork=artwork.carton,
    ),
    "small-carton": GraspableObject(
        name="small-carton",
        description="printed carton, 120 x 60 x 60 mm: a third of the face of the box",
        xml="objects/small-carton.xml",
        size_m=(0.120, 0.060, 0.060),
        mass_kg=0.2,
        artwork=artwork.small_carton,
    ),
    "plain-box": GraspableObject(
        name="plain-box",
        description="white carton, 200 x 80 x 80 mm: hardly any texture",
        xml="objects/plain-box.xml",
        size_m=(0.200, 0.080, 0.080),
        mass_kg=0.5,
        artwork=artwork.plain_carton,
    ),
    "can": GraspableObject(
        name="can",
        description="standing can, 66 mm wide, 110 mm high: only the print of its lid has a yaw",
        xml="objects/can.xml",
        size_m=(0.066, 0.066, 0.110),
        mass_kg=0.35,
        artwork=artwork.can,
    ),
    "flask": GraspableObject(
        name="flask",
        description="lying flat flask, 190 x 72 x 50 mm: round ends, and a neck off its face",
        xml="objects/flask.xml",
        size_m=(0.190, 0.072, 0.050),
        mass_kg=0.3,
        artwork=artwork.flask,
    ),
}
"""Every object a trial can name."""


def get_object(name: str) -> GraspableObject:
    """Returns the named object; ValueError for an unknown name."""
    return look_up("object", name, OBJECTS)


_RAY_START_M = 0.01
_FACE_FLATNESS_M = 0.002
"""What lies deeper than this below the top belongs to a rim or a shoulder."""


class Prop(composer.ModelWrapperEntity):
    """One graspable object; its frame is the centre of the object's bounding box."""

    def _build(self, spec: GraspableObject) -> None:
        self.spec = spec
        """The registry's entry that this prop was made from."""
        self._mjcf_model = mjcf.from_path(str(ASSETS / spec.xml))
        if spec.artwork is not None:
            textures.apply(self._mjcf_model, "artwork", spec.artwork())
        self.body: Any = self._mjcf_model.worldbody.body[0]
        """The object's only body."""
        self.geoms: tuple[Any, ...] = tuple(self._mjcf_model.find_all("geom"))
        """Every geom of the object."""

    def face(self, physics: Any, shape: tuple[int, int]) -> np.ndarray:
        """(rows, columns) bool, where the object's upper side is its top face.

        Seen from straight above, x along the columns and y against the rows, the bounding
        rectangle filling the array. Nothing may stand above the object, and it must lie level.
        """
        body = physics.bind(self.body)
        half = 0.5 * np.asarray(self.spec.size_m)
        rows, columns = shape
        along = ((np.arange(columns) + 0.5) / columns - 0.5) * 2.0 * half[0]
        across = (0.5 - (np.arange(rows) + 0.5) / rows) * 2.0 * half[1]
        R, centre = np.reshape(body.xmat, (3, 3)), np.array(body.xpos)
        down, geom = np.array([0.0, 0.0, -1.0]), np.zeros(1, np.int32)
        model, data = physics.model.ptr, physics.data.ptr
        drop = np.empty(shape)
        for row, y in enumerate(across):
            for column, x in enumerate(along):
                start = centre + R @ [x, y, half[2] + _RAY_START_M]
                drop[row, column] = mujoco.mj_ray(model, data, start, down, None, 1, -1, geom)
        return np.abs(drop - _RAY_START_M) < _FACE_FLATNESS_M


class LookAlike(Prop):
    """The object's mirror image, like a left part beside a right one: the same colours and shape.

    No turn makes it look like the object. It has no joint; its frame is led.
    """

    def _build(self, spec: GraspableObject, number: int = 0) -> None:
        super()._build(spec)
        self._mjcf_model.model = f"look_alike_{number}"
        for mesh in self._mjcf_model.find_all("mesh"):
            mesh.scale = (1.0, -1.0, 1.0)
