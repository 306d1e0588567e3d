"""The grasp: from waiting above the belt to holding the object, as a table of phases.

It sees what a robot sees: predictions of the target, its own commanded pose and the width between
its fingers. `Phase` says what each phase aims at; `Grasp._next_phase` is the table of what ends a
phase and what breaks it off.
"""

import math
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from sim.arm.motion import Ramp, TargetMotion, UniformMotion, run_up, top_down_pose
from sim.checks import require


class Phase(StrEnum):
    """What the hand is doing."""

    SEARCH = "search"
    """It waits at home; no target is known."""
    TRACK = "track"
    """It waits at home while the target's poses are counted."""
    APPROACH = "approach"
    """It joins the target, at the height of hovering."""
    SYNC = "sync"
    """It moves with the target, at the height of hovering."""
    DESCEND = "descend"
    """It moves with the target, down to the depth of the grasp."""
    CLOSE = "close"
    """It moves with the target, at the depth of the grasp, and the fingers close."""
    LIFT = "lift"
    """It rises with the object and brakes."""
    HOLD = "hold"
    """It holds the object up."""


_WAITING = (Phase.SEARCH, Phase.TRACK)
_AT_DEPTH = (Phase.DESCEND, Phase.CLOSE)
_CARRYING = (Phase.LIFT, Phase.HOLD)


@dataclass(frozen=True)
class GraspConfig:
    """Heights, gates and speeds of the grasp."""

    wait_y_m: float = -0.58
    """Where along the belt the hand waits for the target."""
    join_y_m: float = -0.18
    """Where a fast target is joined, after a third of the reach: there the hand's turn counts."""
    hover_m: float = 0.075
    """Height of the tool centre point above the target's top while it follows."""
    depth_m: float = 0.035
    """How far below the top the tool centre point goes."""
    depth_error_m: float = 0.004
    """The fingers may begin to move so far above that depth."""
    lift_m: float = 0.16
    run_up_mps2: float = 4.0
    """Acceleration along the belt with which the hand joins the target."""
    descent_mps: float = 0.6
    descent_mps2: float = 6.0
    sync_error_m: float = 0.008
    sync_yaw_rad: float = math.radians(4.0)
    sync_time_s: float = 0.05
    """The error stays under both gates this long before the descent begins."""
    abort_error_m: float = 0.020
    """The descent waits above the target while the error is larger."""
    track_poses: int = 3
    open_width_m: float = 0.110
    """The gripper's stroke."""
    closed_width_m: float = 0.0
    moved_m: float = 0.004
    """Fingers that have closed by more than this have left their stops."""
    resisted_mps: float = 0.06
    """Closing fingers slower than this have met something."""
    still_m: float = 0.001
    grip_settle_s: float = 0.06
    """Fingers that stayed within `still_m` this long hold what they have met."""
    close_timeout_s: float = 0.8
    stop_mps2: float = 4.0
    """Deceleration along the belt once the target is off it."""

    def __post_init__(self) -> None:
        require(self, "finite", math.isfinite, self.__dataclass_fields__)
        if self.wait_y_m >= self.join_y_m:
            raise ValueError(
                f"wait_y_m must lie before join_y_m={self.join_y_m}, got {self.wait_y_m}"
            )


@dataclass(frozen=True, eq=False)
class GraspCommand:
    """What the hand shall do now."""

    T_world_tcp: np.ndarray
    """(4, 4) goal pose of the tool centre point."""
    twist: np.ndarray
    """(6,) velocity of the goal in world axes [m/s, rad/s]."""
    width_m: float
    phase: Phase


@dataclass
class Grasp:
    """The state machine of one attempt."""

    config: GraspConfig
    dt_s: float
    """Control step."""
    closing_delay_s: float
    """Known time from the close command to the first finger motion; Δt₂ of [IGPF2021] Eq. (30)."""
    home_T_world_tcp: np.ndarray
    base_x_m: float = 0.0
    """World x of the arm's first axis."""
    phase: Phase = Phase.SEARCH
    entered_s: dict[Phase, float] = field(default_factory=dict[Phase, float])
    """When each phase began."""
    _closing_yaw: float | None = None
    _pose_count: int = 0
    _in_gate_s: float = 0.0
    _error_m: float = math.inf
    _hand_z_m: float = 0.0
    _top_z_m: float = 0.0
    _have_fingers_met: bool = False
    _last_width: float = math.inf
    _rest_width: float = math.inf
    _rest_since_s: float = 0.0
    _gripped: UniformMotion | None = None
    _carry_velocity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    _hold_position: np.ndarray = field(default_factory=lambda: np.zeros(3))
    _lift_goal: float = 0.0

    def __post_init__(self) -> None:
        self._height = Ramp(float(self.home_T_world_tcp[2, 3]))

    @property
    def has_gripped(self) -> bool:
        """Whether the fingers have met resistance: what the camera shows follows the hand."""
        return self._gripped is not None or self.phase in _CARRYING

    def step(
        self,
        time_s: float,
        target: TargetMotion | None,
        pose_count: int,
        T_world_tcp: np.ndarray,
        width_m: float,
    ) -> GraspCommand:
        """Returns the command for this control step.

        Args:
            time_s: Simulated time.
            target: Predicted motion at `time_s`, or None while nothing is tracked.
            pose_count: Usable poses so far.
            T_world_tcp: (4, 4) pose of the hand.
            width_m: Measured opening between the fingers.
        """
        if self.phase in _CARRYING:
            return self._carry(time_s)
        self._pose_count = pose_count
        for waiting in _WAITING:  # both may end in one step
            if target is not None and self.phase is waiting:
                self._advance(time_s)
        if target is None or self.phase in _WAITING:
            return self._command(self.home_T_world_tcp, np.zeros(6))
        return self._follow(time_s, target, T_world_tcp, width_m)

    def _next_phase(self) -> Phase:
        """The table: the phase that follows on this one as things stand, or this one."""
        c = self.config
        is_above = self._hand_z_m > self._top_z_m + 0.5 * c.hover_m
        remaining_m = self._hand_z_m - (self._top_z_m - c.depth_m)
        # [IGPF2021] Eq. (30): the fingers begin to move closing_delay_s after the command.
        way_in_delay_m = self.closing_delay_s * abs(self._height.speed)
        match self.phase:
            case Phase.SEARCH:
                return Phase.TRACK
            case Phase.TRACK if self._pose_count >= c.track_poses:
                return Phase.APPROACH
            case Phase.APPROACH if self._in_gate_s > 0.0:
                return Phase.SYNC
            case Phase.SYNC if self._in_gate_s == 0.0:
                return Phase.APPROACH
            case Phase.SYNC if self._in_gate_s >= c.sync_time_s:
                return Phase.DESCEND
            case Phase.DESCEND if is_above and self._error_m > c.abort_error_m:
                return Phase.APPROACH
            case Phase.DESCEND if remaining_m < c.depth_error_m + way_in_delay_m:
                return Phase.CLOSE
            case Phase.CLOSE if self._have_fingers_met:
                return Phase.LIFT
            case Phase.LIFT if abs(self._height.value - self._lift_goal) < 1e-3:
                return Phase.HOLD
            case phase:
                return phase

    def _advance(self, time_s: float) -> None:
        self.phase = self._next_phase()
        self.entered_s.setdefault(self.phase, time_s)

    def _follow(
        self, time_s: float, target: TargetMotion, T_world_tcp: np.ndarray, width_m: float
    ) -> GraspCommand:
        c = self.config
        if self._gripped is not None:
            target = self._gripped = self._gripped.after(self.dt_s)
        yaw = self._choose_closing_yaw(target, T_world_tcp)
        position = np.array(target.position_m, float)
        velocity = np.array(target.velocity_mps, float)
        y, speed = position[1], velocity[1]
        position[1], velocity[1] = run_up(y, speed, c.wait_y_m, c.run_up_mps2)
        self._measure(target, T_world_tcp, has_joined=position[1] == y)
        if self.phase is Phase.CLOSE:
            self._watch_fingers(time_s, target, width_m)
        self._advance(time_s)
        self._lift_goal = self._height.value + c.lift_m
        top = self._top_z_m
        goal_height = top - c.depth_m if self.phase in _AT_DEPTH else top + c.hover_m
        self._height.step(goal_height, c.descent_mps, c.descent_mps2, self.dt_s)
        position[2], velocity[2] = self._height.value, self._height.speed
        twist = np.concatenate([velocity, [0.0, 0.0, target.yaw_rate_radps]])
        if self.phase is Phase.LIFT:
            self._hold_position, self._carry_velocity = position, velocity
        return self._command(top_down_pose(position, yaw), twist)

    def _measure(self, target: TargetMotion, T_world_tcp: np.ndarray, *, has_joined: bool) -> None:
        """Notes how hand and target stand to each other."""
        c = self.config
        self._error_m = float(np.linalg.norm((target.position_m - T_world_tcp[:3, 3])[:2]))
        hand_yaw = math.atan2(T_world_tcp[1, 0], T_world_tcp[0, 0])
        yaw_error = math.remainder((self._closing_yaw or 0.0) - hand_yaw, 2.0 * math.pi)
        is_near = self._error_m < c.sync_error_m and abs(yaw_error) < c.sync_yaw_rad
        self._in_gate_s = self._in_gate_s + self.dt_s if is_near and has_joined else 0.0
        self._hand_z_m, self._top_z_m = float(T_world_tcp[2, 3]), float(target.position_m[2])

    def _watch_fingers(self, time_s: float, target: TargetMotion, width_m: float) -> None:
        """Notes when the fingers stand still, which ends the closing, as does its time limit.

        From the first resistance on the target is taken to move on as it did: what perception
        reports of an object in the hand follows the hand.
        """
        c = self.config
        if abs(width_m - self._rest_width) > c.still_m:
            self._rest_width, self._rest_since_s = width_m, time_s
        has_moved = width_m < c.open_width_m - c.moved_m
        finger_speed = (self._last_width - width_m) / self.dt_s
        self._last_width = width_m
        if has_moved and finger_speed < c.resisted_mps and self._gripped is None:
            self._gripped = UniformMotion.of(target)
        is_still = has_moved and time_s - self._rest_since_s >= c.grip_settle_s
        is_late = time_s - self.entered_s[Phase.CLOSE] > c.close_timeout_s
        self._have_fingers_met = is_still or is_late

    def _carry(self, time_s: float) -> GraspCommand:
        c = self.config
        self._height.step(self._lift_goal, c.descent_mps, c.descent_mps2, self.dt_s)
        speed = float(np.linalg.norm(self._carry_velocity[:2]))
        slower = max(speed - c.stop_mps2 * self.dt_s, 0.0)
        self._carry_velocity = self._carry_velocity * (slower / speed if speed > 0.0 else 0.0)
        self._carry_velocity[2] = self._height.speed
        self._hold_position = self._hold_position + self._carry_velocity * self.dt_s
        self._hold_position[2] = self._height.value
        self._advance(time_s)
        T = top_down_pose(self._hold_position, self._closing_yaw or 0.0)
        return self._command(T, np.concatenate([self._carry_velocity, np.zeros(3)]))

    def _choose_closing_yaw(self, target: TargetMotion, T_world_tcp: np.ndarray) -> float:
        """The closing direction nearest to the last one, of the two that fit the target.

        The hand closes across the long axis; a parallel gripper fits in two directions half a
        turn apart. The first choice is the one that turns the wrist less where the target is
        joined, the base having turned along by then, and holds afterwards.
        """
        last = self._closing_yaw
        if last is None:
            x, y = T_world_tcp[:2, 3] - [self.base_x_m, 0.0]
            base_turn = math.atan2(self.config.join_y_m, x) - math.atan2(y, x)
            last = math.atan2(T_world_tcp[1, 0], T_world_tcp[0, 0]) + base_turn
        across = target.yaw_rad + 0.5 * math.pi
        self._closing_yaw = last + math.remainder(across - last, math.pi)
        return self._closing_yaw

    def _command(self, T_world_tcp: np.ndarray, twist: np.ndarray) -> GraspCommand:
        c = self.config
        is_closed = self.phase is Phase.CLOSE or self.phase in _CARRYING
        width = c.closed_width_m if is_closed else c.open_width_m
        return GraspCommand(T_world_tcp, twist, width, self.phase)
