"""Graspable objects that ride on the belt."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from dm_control import composer, mjcf

from sim import ASSETS, textures


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


OBJECTS: dict[str, GraspableObject] = {
    "box": GraspableObject(
        name="box",
        description="printed carton, 200 x 80 x 80 mm",
        xml="objects/box.xml",
        size_m=(0.200, 0.080, 0.080),
        mass_kg=0.5,
        artwork=textures.carton_artwork,
    ),
}
"""Every object a trial can name."""


def get_object(name: str) -> GraspableObject:
    """The named object; raises ValueError that lists the valid names."""
    if name not in OBJECTS:
        raise ValueError(f"object must be one of {', '.join(OBJECTS)}; got {name!r}")
    return OBJECTS[name]


class Prop(composer.Entity):
    """One graspable object; its frame is the centre of the object's bounding box."""

    def _build(self, spec: GraspableObject) -> None:
        self._spec = spec
        self._mjcf_root = mjcf.from_path(str(ASSETS / spec.xml))
        if spec.artwork is not None:
            textures.apply(self._mjcf_root, "artwork", spec.artwork())

    @property
    def mjcf_model(self) -> Any:
        """PyMJCF model of the object, without its free joint."""
        return self._mjcf_root

    @property
    def spec(self) -> GraspableObject:
        """The registry entry that this prop was made from."""
        return self._spec

    @property
    def body(self) -> Any:
        """The object's only body."""
        return self._mjcf_root.worldbody.body[0]

    @property
    def geoms(self) -> tuple[Any, ...]:
        """Every geom of the object."""
        return tuple(self._mjcf_root.find_all("geom"))
