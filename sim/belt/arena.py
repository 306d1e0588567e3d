"""The work cell: room, lights, and by condition a bar in the way, print and look-alikes.

Bar and look-alikes are in every compiled model, so that a cell takes another condition without a
new model. What a condition does not ask for lies under the floor, where no camera sees it and
nothing meets it. They are solid, and are led instead of pushed.
"""

import math
from typing import Any

import numpy as np
from dm_control import composer, mjcf

from sim import ASSETS, textures
from sim.arm.embodiments import UR5_RG2, Embodiment
from sim.arm.robot import Robot
from sim.belt.carriers import Carrier, Pose
from sim.belt.objects import GraspableObject, LookAlike
from sim.belt.scenario import Scenario
from sim.geometry import quaternion, yaw_quaternion
from sim.imaging.camera import CameraView
from sim.imaging.degradations import LOOK_ALIKE_COUNT, WIDEST_BAR_M, Condition
from sim.world_config import PHYSICS_HZ

PHYSICS_STEP_S = 1.0 / PHYSICS_HZ
FLOOR_Z_M = -0.75

_HIDDEN_Z_M = FLOOR_Z_M - 1.0
_BAR_LENGTH_M = 0.9
_BAR_THICKNESS_M = 0.006
_WAY_TO_TARGET = 0.5
"""Where on the line of sight the bar stands; it hides its width divided by this share."""
_HIDDEN_SHARE = 0.7
"""The hidden place: this share of the way from the middle of the surface to its upstream end. An
object has come wholly into view before it, and the hand takes it beyond, at 0.5 m/s at least."""
_CARRIED_Y_M = 1.2
"""Past this along y a look-alike is off the belt; no view reaches so far."""


class Cell(composer.Arena):
    """Work cell with a place for the robot and one for what carries the object."""

    def _build(self, embodiment: Embodiment = UR5_RG2) -> None:
        self._mjcf_root = mjcf.from_path(str(ASSETS / "cell.xml"))
        self._raise_pedestal(embodiment)
        textures.apply(self._mjcf_root, "concrete", textures.concrete())
        textures.apply(self._mjcf_root, "busy", textures.busy_print())
        self.lights = tuple(self._mjcf_root.find("light", name) for name in ("key", "fill"))
        """The light elements `key`, which can cast shadows, and `fill`, which does not."""

    def attach_robot(self, robot: Robot) -> Any:
        """Stands the robot on its pedestal; returns the attachment frame."""
        return self.attach(robot, self._mjcf_root.find("site", "robot"))

    def attach_carrier(self, carrier: Carrier) -> Any:
        """Puts the belt or the turntable in front of the robot; returns the attachment frame."""
        return self.attach(carrier, self._mjcf_root.find("site", "carrier"))

    def set_clutter(self, physics: Any, opacity: float) -> None:
        """Shows a busy print on the floor, 0 for none and 1 for all of it."""
        floor = physics.bind(self._mjcf_root.find("geom", "busy_floor")).element_id
        physics.model.geom_rgba[floor, 3] = opacity

    def _raise_pedestal(self, embodiment: Embodiment) -> None:
        """Puts the pedestal under the embodiment's mounting face."""
        x, top = embodiment.base_x_m, embodiment.base_height_m
        half = 0.5 * (top - FLOOR_Z_M)
        heights = {"pedestal": top - half, "pedestal_cap": top - 0.011, "pedestal_foot": -0.74}
        for name, z in heights.items():
            geom = self._mjcf_root.find("geom", name)
            geom.pos = x, 0.0, z
            # The model's own pedestal has the radius of the UR5's.
            geom.size[0] *= embodiment.pedestal_radius_m / UR5_RG2.pedestal_radius_m
        self._mjcf_root.find("geom", "pedestal").size[1] = half
        self._mjcf_root.find("site", "robot").pos = x, 0.0, top

    def set_light_scale(self, physics: Any, scale: float) -> None:
        """Dims (or brightens) every light of the cell, 1 being the compiled brightness."""
        if not (math.isfinite(scale) and scale >= 0.0):
            raise ValueError(f"scale must be finite and >= 0, got {scale!r}")
        model = physics.model
        for light in self.lights:
            # Written past the binding, which would have the whole scene computed anew.
            index = physics.bind(light).element_id
            model.light_diffuse[index] = scale * np.asarray(light.diffuse)
            model.light_specular[index] = scale * np.asarray(light.specular)
        ambient = self._mjcf_root.visual.headlight.ambient
        model.vis.headlight.ambient[:] = scale * np.asarray(ambient)


class Scenery:
    """The bar, the print and the look-alikes of one cell."""

    def __init__(
        self, arena: Cell, carrier: Carrier, view: CameraView, spec: GraspableObject
    ) -> None:
        """Adds them to the arena, out of sight."""
        self._arena, self._carrier, self._view = arena, carrier, view
        self._bar = arena.mjcf_model.worldbody.add("body", name="bar", mocap="true")
        self._bar_geom = self._bar.add(
            "geom",
            name="bar",
            type="box",
            size=(0.5 * WIDEST_BAR_M, 0.5 * _BAR_LENGTH_M, 0.5 * _BAR_THICKNESS_M),
            material="steel",
            group=2,
        )
        self._look_alikes = [LookAlike(spec, number) for number in range(LOOK_ALIKE_COUNT)]
        self._frames = [arena.attach(look_alike) for look_alike in self._look_alikes]
        for frame in self._frames:
            frame.mocap = "true"
        self._height_m = 0.5 * spec.size_m[2]
        self._riding: tuple[Pose, ...] = ()
        self._way_m = 0.0

    def hide(self, physics: Any) -> None:
        """Takes everything away, as in the normal condition."""
        self._riding, self._way_m = (), 0.0
        self._arena.set_clutter(physics, 0.0)
        self._carrier.set_clutter(physics, 0.0)
        for number, body in enumerate([self._bar, *self._frames]):
            self._put(physics, body, (2.0 * number, 0.0, _HIDDEN_Z_M), (1.0, 0.0, 0.0, 0.0))

    def arrange(self, physics: Any, condition: Condition, scenario: Scenario) -> None:
        """Puts in place what the condition asks for, at the start of an episode."""
        self.hide(physics)
        self._arena.set_clutter(physics, condition.clutter)
        self._carrier.set_clutter(physics, condition.clutter)
        if condition.bar_m > 0.0:
            self._raise_bar(physics, condition.bar_m)
        self._riding = scenario.look_alikes[: condition.look_alike_count]
        self._show_riding(physics)

    def before_physics_step(self, physics: Any) -> None:
        """Leads the look-alikes to where the surface takes them in this step."""
        if self._riding:
            self._way_m += self._carrier.speed_mps(physics) * PHYSICS_STEP_S
            self._show_riding(physics)

    def _raise_bar(self, physics: Any, width_m: float) -> None:
        """Puts the bar upright in the image, between the camera and the place that it hides."""
        (x_low, x_high), (y_low, _) = self._carrier.face_range_m
        hidden = np.array([0.5 * (x_low + x_high), _HIDDEN_SHARE * y_low, self._height_m])
        camera = np.array(self._view.position_m)
        upright = quaternion(self._view.T_world_camera[:3, :3])
        self._put(physics, self._bar, camera + _WAY_TO_TARGET * (hidden - camera), upright)
        physics.model.geom_size[physics.bind(self._bar_geom).element_id, 0] = 0.5 * width_m

    def _show_riding(self, physics: Any) -> None:
        for frame, start in zip(self._frames, self._riding, strict=False):
            pose = self._carrier.carried(start, self._way_m)
            z_m = self._height_m if pose.y_m < _CARRIED_Y_M else _HIDDEN_Z_M
            place = pose.x_m, pose.y_m, z_m
            self._put(physics, frame, place, yaw_quaternion(pose.yaw_rad))

    @staticmethod
    def _put(physics: Any, body: Any, position_m: Any, quat: Any) -> None:
        # Written past the binding, which would have the whole scene computed anew.
        index = physics.model.body_mocapid[physics.model.name2id(body.full_identifier, "body")]
        physics.data.mocap_pos[index] = position_m
        physics.data.mocap_quat[index] = quat
