"""The referee: judges an attempt by the physics. It reads the ground truth, for scoring alone.

Success: the object's lowest point is 0.10 m above the belt and for 1 s nothing but the hand
touches it. Clean success: also no touch before the close command, less than 10
degrees of tilt, less than 5 mm of slip in the hand, and a grip within 20 mm of the centre.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from sim.arm.robot import Robot
from sim.belt.objects import Prop
from sim.geometry import transform

LIFT_HEIGHT_M = 0.10
HOLD_S = 1.0
SETTLED_GRIP_S = 0.05
"""Slip counts from when both fingers have had the object this long."""
GONE_Y_M = 0.85
"""An object on the belt past this cannot be reached any more."""

CLEAN_TILT_RAD = math.radians(10.0)
CLEAN_SLIP_M = 0.005
CLEAN_GRIP_ERROR_M = 0.020


@dataclass
class PhysicalRecord:
    """What happened in an attempt; None for what never did. Times are in simulated seconds."""

    close_command_s: float | None = None
    first_touch_s: float | None = None
    gripped_s: float | None = None
    """When both fingers first touched the object after the close command."""
    lifted_off_s: float | None = None
    """When the object, in the fingers, was first 10 mm above the belt."""
    held_s: float = 0.0
    """How long it has been high enough with nothing but the hand touching it."""
    max_height_m: float = 0.0
    max_tilt_rad: float = 0.0
    slip_m: float | None = None
    """Largest displacement in the hand since the grip settled."""
    grip_error_m: np.ndarray | None = None
    """(2,) from the object's centre to the hand at the first touch while closing: along the
    closing axis, and across it."""
    grip_yaw_error_rad: float | None = None
    collision: str = ""
    """The first contact of the robot that must not happen: two geom names."""
    has_fallen: bool = False
    has_left: bool = False

    @property
    def is_success(self) -> bool:
        """Whether the object was lifted and held."""
        return self.held_s >= HOLD_S

    @property
    def is_early_contact(self) -> bool:
        """Whether the robot touched the object before the close command."""
        if self.first_touch_s is None:
            return False
        return self.close_command_s is None or self.first_touch_s < self.close_command_s

    @property
    def is_clean_success(self) -> bool:
        """Whether it is a success in which nothing was knocked, tilted, dragged or let slip."""
        return (
            self.is_success
            and not self.is_early_contact
            and self.max_tilt_rad < CLEAN_TILT_RAD
            and self.slip_m is not None
            and self.slip_m < CLEAN_SLIP_M
            and self.grip_error_m is not None
            and float(np.linalg.norm(self.grip_error_m)) < CLEAN_GRIP_ERROR_M
        )

    @property
    def is_over(self) -> bool:
        """Whether nothing that can still happen would change the outcome."""
        return self.is_success or self.has_fallen or self.has_left


class Referee:
    """Watches one attempt, control step by control step."""

    def __init__(self, physics: Any, prop: Prop, robot: Robot) -> None:
        """Both entities are parts of the compiled model."""

        def ids(elements: Iterable[Any]) -> set[int]:
            return {int(physics.bind(e).element_id) for e in elements}

        self._body = prop.body
        self._half_m = 0.5 * np.asarray(prop.spec.size_m)
        self._site = robot.tcp_site
        self._object = ids(prop.geoms)
        self._pads = ids(robot.pad_geoms)
        self._hand = ids(robot.hand_geoms)
        self._robot = ids(robot.arm_geoms) | self._hand
        self._p_settled: np.ndarray | None = None
        self._high_since_s: float | None = None
        self.record = PhysicalRecord()

    def object_pose(self, physics: Any) -> np.ndarray:
        """(4, 4) pose of the object in the world."""
        body = physics.bind(self._body)
        return transform(body.xmat, body.xpos)

    def tcp_pose(self, physics: Any) -> np.ndarray:
        """(4, 4) pose of the tool centre point in the world."""
        site = physics.bind(self._site)
        return transform(site.xmat, site.xpos)

    def watch(self, physics: Any, is_closing_commanded: bool) -> None:
        """Takes in the state after a control step."""
        record, time_s = self.record, float(physics.data.time)
        if is_closing_commanded and record.close_command_s is None:
            record.close_command_s = time_s
        T_object, T_tcp = self.object_pose(physics), self.tcp_pose(physics)
        touching = self._touching(physics)
        self._watch_grip(time_s, T_object, T_tcp, touching)
        self._watch_lift(time_s, T_object, touching)
        self._watch_slip(time_s, T_object, T_tcp)

    def _touching(self, physics: Any) -> set[int]:
        """Geoms that touch the object; notes the robot's own collisions on the way."""
        touching: set[int] = set()
        contact = physics.data.contact
        for first, second in contact.geom[contact.exclude == 0]:
            first, second = int(first), int(second)
            if first in self._object or second in self._object:
                touching.add(second if first in self._object else first)
            elif (first in self._robot or second in self._robot) and not (
                first in self._hand and second in self._hand
            ):
                names = (physics.model.id2name(g, "geom") for g in (first, second))
                self.record.collision = self.record.collision or " and ".join(names)
        return touching

    def _watch_grip(
        self, time_s: float, T_object: np.ndarray, T_tcp: np.ndarray, touching: set[int]
    ) -> None:
        record = self.record
        if touching & self._robot and record.first_touch_s is None:
            record.first_touch_s = time_s
        if record.close_command_s is None or not touching & self._hand:
            return
        if record.grip_error_m is None:
            offset = T_tcp[:2, :2].T @ (T_tcp[:2, 3] - T_object[:2, 3])
            record.grip_error_m = offset
            record.grip_yaw_error_rad = _yaw_error(T_object, T_tcp)
        if record.gripped_s is None and self._pads <= touching:
            record.gripped_s = time_s

    def _watch_lift(self, time_s: float, T_object: np.ndarray, touching: set[int]) -> None:
        record = self.record
        height = float(T_object[2, 3] - np.abs(T_object[2, :3]) @ self._half_m)
        tilt = math.acos(min(max(float(T_object[2, 2]), -1.0), 1.0))
        record.max_height_m = max(record.max_height_m, height)
        record.max_tilt_rad = max(record.max_tilt_rad, tilt)
        is_in_hand = bool(touching) and touching <= self._hand
        if is_in_hand and height > 0.01 and record.lifted_off_s is None:
            record.lifted_off_s = time_s
        if not (is_in_hand and height >= LIFT_HEIGHT_M):
            self._high_since_s = None
        elif self._high_since_s is None:
            self._high_since_s = time_s
        else:
            record.held_s = max(record.held_s, time_s - self._high_since_s)
        record.has_fallen = height < -0.03
        record.has_left = float(T_object[1, 3]) > GONE_Y_M and not is_in_hand

    def _watch_slip(self, time_s: float, T_object: np.ndarray, T_tcp: np.ndarray) -> None:
        record = self.record
        if record.gripped_s is None or time_s < record.gripped_s + SETTLED_GRIP_S:
            return
        p_tcp_object = T_tcp[:3, :3].T @ (T_object[:3, 3] - T_tcp[:3, 3])
        if self._p_settled is None:
            self._p_settled = p_tcp_object
        slip = float(np.linalg.norm(p_tcp_object - self._p_settled))
        record.slip_m = max(record.slip_m or 0.0, slip)


def _yaw_error(T_object: np.ndarray, T_tcp: np.ndarray) -> float:
    """Angle from straight across the object's long axis to the closing axis, modulo half a turn."""
    across = math.atan2(T_object[1, 0], T_object[0, 0]) + 0.5 * math.pi
    closing = math.atan2(T_tcp[1, 0], T_tcp[0, 0])
    return math.remainder(closing - across, math.pi)
