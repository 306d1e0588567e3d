"""Velocity-level servo: drives the tool centre point onto a moving goal through mink's QP.

The goal has a pose and a twist. The servo asks mink for the twist plus a correction of the pose
error whose speed never exceeds what the arm can brake from (square-root profile), so that it
converges without overshoot under an acceleration limit, and without the lag `v dt / gain` that a
FrameTask alone would have.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import mink
import mujoco
import numpy as np

from sim.checks import require_positive


@dataclass(frozen=True)
class ServoConfig:
    """Gains and limits of the servo."""

    rate_hz: float = 120.0
    """Solves per second; one a control step."""
    gain_hz: float = 25.0
    """Share of a small pose error removed per second."""
    max_speed_mps: float = 1.6
    """Speed of the position correction, on top of the goal's own twist."""
    braking_mps2: float = 5.0
    """Deceleration that the position correction plans with."""
    max_turn_radps: float = 2.5
    braking_radps2: float = 10.0
    joint_acceleration_radps2: float = 25.0
    """Own choice, since the manufacturer publishes none; torque limits hold besides."""
    clearance_m: float = 0.004
    """Smallest allowed distance between the hand and the belt."""
    approach_gain_hz: float = 30.0
    """Fastest approach of hand and belt, as a share of their remaining distance per second."""

    def __post_init__(self) -> None:
        require_positive(self, *self.__dataclass_fields__)


class AccelerationLimit(mink.Limit):
    """Joint acceleration limit that also keeps enough room to brake before a joint's end stop.

    With the velocity of the last step known, the displacement of this one is bounded by
    `(v_last ± a dt) dt`, and by the displacement after which braking at `a` still stops in time:
    `v <= sqrt(2 a d)` for a distance `d` to the stop.
    """

    def __init__(self, model: mujoco.MjModel, acceleration_radps2: float) -> None:
        self._acceleration = acceleration_radps2
        is_limited = model.jnt_limited.astype(bool)
        self._lower = np.where(is_limited, model.jnt_range[:, 0], -np.inf)
        self._upper = np.where(is_limited, model.jnt_range[:, 1], np.inf)
        self._G = np.vstack([np.eye(model.nv), -np.eye(model.nv)])
        self.last_velocity = np.zeros(model.nv)

    def compute_qp_inequalities(
        self, configuration: mink.Configuration, dt: float
    ) -> mink.Constraint:
        """Bounds on the displacement of this step, (2 nv,) rows."""
        q, a = configuration.q, self._acceleration
        brake_up = np.sqrt(2.0 * a * np.maximum(self._upper - q, 0.0))
        brake_down = np.sqrt(2.0 * a * np.maximum(q - self._lower, 0.0))
        # A joint too fast to stop in time brakes as hard as it may: the box never becomes empty.
        floor = self.last_velocity - a * dt
        ceiling = self.last_velocity + a * dt
        upper = np.clip(brake_up, floor, ceiling)
        lower = np.clip(-brake_down, floor, ceiling)
        return mink.Constraint(G=self._G, h=np.concatenate([upper, -lower]) * dt)


def braking_speed(distance: np.ndarray | float, gain_hz: float, braking: float) -> np.ndarray:
    """Speed with which to close `distance`: proportional when near, square root when far.

    The two pieces join with equal value and slope at `braking / gain_hz**2`, so that the demanded
    deceleration never exceeds `braking`.
    """
    knee = braking / gain_hz**2
    far = np.sqrt(np.maximum(2.0 * braking * (distance - 0.5 * knee), 0.0))
    return np.where(distance <= knee, gain_hz * np.asarray(distance), far)


class Servo:
    """Turns a goal pose and twist of the tool centre point into joint positions and velocities."""

    def __init__(
        self,
        model: mujoco.MjModel,
        config: ServoConfig,
        joint_speed_radps: Sequence[float],
        tcp_site: str,
        hand_geoms: list[str],
        belt_geoms: list[str],
    ) -> None:
        """Prepares the quadratic programme.

        Args:
            model: The arm alone, fingers fixed, so that the programme has six unknowns.
            config: Gains and limits.
            joint_speed_radps: (6,) largest speed of each joint.
            tcp_site: Name of the tool centre point.
            hand_geoms: Names of what must stay off the belt.
            belt_geoms: Names of the belt and its rails.
        """
        if model.nv != 6:
            raise ValueError(f"model must have the arm's 6 joints alone, got nv={model.nv}")
        self._config = config
        self._dt = 1.0 / config.rate_hz
        self._site = tcp_site
        self._configuration = mink.Configuration(model)
        self._task = mink.FrameTask(
            tcp_site, "site", position_cost=1.0, orientation_cost=0.3, gain=1.0, lm_damping=1e-6
        )
        self._acceleration = AccelerationLimit(model, config.joint_acceleration_radps2)
        joints = [model.joint(i).name for i in range(model.njnt)]
        speeds = dict(zip(joints, joint_speed_radps, strict=True))
        self._hard_limits: list[mink.Limit] = [
            mink.ConfigurationLimit(model),
            mink.VelocityLimit(model, speeds),
            mink.CollisionAvoidanceLimit(
                model,
                [(hand_geoms, belt_geoms)],
                gain=config.approach_gain_hz * self._dt,
                minimum_distance_from_collisions=config.clearance_m,
                collision_detection_distance=0.08,
            ),
        ]
        self.is_feasible = True
        """Whether the last solve found joint motion within the hard limits."""

    @property
    def q(self) -> np.ndarray:
        """(6,) commanded joint positions [rad]."""
        return self._configuration.q.copy()

    @property
    def qd(self) -> np.ndarray:
        """(6,) commanded joint velocities [rad/s]."""
        return self._acceleration.last_velocity.copy()

    @property
    def T_world_tcp(self) -> np.ndarray:
        """(4, 4) commanded pose of the tool centre point."""
        return self._configuration.get_transform_frame_to_world(self._site, "site").as_matrix()

    def reset(self, q_rad: np.ndarray) -> None:
        """Starts at rest from a joint configuration (6,)."""
        self._configuration.update(np.asarray(q_rad, float))
        self._acceleration.last_velocity = np.zeros(6)
        self.is_feasible = True

    def step(
        self, goal_T_world_tcp: np.ndarray, goal_twist: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Advances the commanded configuration by one control step.

        Args:
            goal_T_world_tcp: (4, 4) pose to reach at the end of this step.
            goal_twist: (6,) velocity of the goal [m/s, rad/s], in world axes.

        Returns:
            (6,) joint positions [rad] and (6,) joint velocities [rad/s] to hold during the step:
            those of its middle, because a set-point held constant acts like its mean. A goal out
            of reach leaves the arm as near as the limits allow.
        """
        twist = self._desired_twist(goal_T_world_tcp, goal_twist)
        T = self._configuration.get_transform_frame_to_world(self._site, "site")
        world_to_tcp = T.rotation().inverse()
        step = np.concatenate([world_to_tcp.apply(twist[:3]), world_to_tcp.apply(twist[3:])])
        self._task.set_target(T.multiply(mink.SE3.exp(step * self._dt)))
        # Rather brake harder than planned than hit the belt: the arm's torques still bound it.
        velocity = self._solve([*self._hard_limits, self._acceleration])
        if velocity is None:
            velocity = self._solve(self._hard_limits)
        self.is_feasible = velocity is not None
        if velocity is None:
            velocity = self._braked_velocity()
        before = self.q
        self._configuration.integrate_inplace(velocity, self._dt)
        self._acceleration.last_velocity = velocity
        return 0.5 * (before + self.q), self.qd

    def _solve(self, limits: list[mink.Limit]) -> np.ndarray | None:
        """(6,) joint velocities, None where no motion satisfies the limits."""
        try:
            velocity = mink.solve_ik(
                self._configuration, [self._task], self._dt, "daqp", damping=1e-8, limits=limits
            )
        except mink.NoSolutionFound:
            return None
        return velocity if np.all(np.isfinite(velocity)) else None

    def _desired_twist(self, goal_T: np.ndarray, goal_twist: np.ndarray) -> np.ndarray:
        c = self._config
        T = self.T_world_tcp
        twist = np.array(goal_twist, float)
        position_error = goal_T[:3, 3] - T[:3, 3]
        turn_error = mink.SO3.from_matrix(goal_T[:3, :3] @ T[:3, :3].T).log()
        bounds = (c.max_speed_mps, c.braking_mps2), (c.max_turn_radps, c.braking_radps2)
        for part, error, (fastest, braking) in zip(
            (slice(0, 3), slice(3, 6)), (position_error, turn_error), bounds, strict=True
        ):
            size = float(np.linalg.norm(error))
            if size > 1e-9:
                speed = min(float(braking_speed(size, c.gain_hz, braking)), fastest)
                twist[part] += error / size * speed
        return twist

    def _braked_velocity(self) -> np.ndarray:
        last = self._acceleration.last_velocity
        change = self._config.joint_acceleration_radps2 * self._dt
        return np.sign(last) * np.maximum(np.abs(last) - change, 0.0)
