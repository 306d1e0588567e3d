"""The composer task: a cell, an object on a running belt, a delayed camera and a slow gripper."""

from __future__ import annotations

import itertools
import math
import time
from collections import deque
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from dm_control import composer
from dm_control.composer.observation import observable
from dm_env import specs

from sim.arena import Cell
from sim.camera import STUDIO, CameraView, OffscreenRenderer, add_camera, get_view
from sim.conveyor import BELT_CENTRE_X_M, Conveyor
from sim.degradations import NORMAL, Condition, get_condition
from sim.motions import draw_profile
from sim.objects import Prop, get_object
from sim.referee import Referee
from sim.robot import HOME_Q_RAD, STROKE_M, Robot
from sim.scenario import Scenario, ScenarioRange
from sim.sensor import Frame, Image, Sensor

PHYSICS_HZ = 480
CONTROL_HZ = 120
_CUBE_CORNERS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))


@dataclass(frozen=True)
class TaskConfig:
    """What the cell looks like and where its delays lie."""

    object: str = "box"
    camera: str = "far-side"
    condition: str = NORMAL
    motion: str = "constant"
    """How the belt runs in episodes that are drawn from the environment's own state."""
    speed_mps: float = 0.25
    """At which speed it does."""
    scenarios: ScenarioRange = field(default_factory=ScenarioRange)
    camera_rate_hz: float = 30.0
    """Must divide the physics rate of 480 Hz."""
    delay_s: float = 0.066
    """From exposure until the image (and what is computed from it) can be used [s]."""
    gripper_delay_s: float = 0.05
    """From a new width command to the first finger motion [s]."""
    finger_speed_mps: float = 0.127
    """Speed of the opening, both fingers together."""
    has_camera: bool = True
    """Without a camera nothing is rendered; for control arms that see no image."""

    def __post_init__(self) -> None:
        get_object(self.object)
        get_view(self.camera)
        get_condition(self.condition)
        draw_profile(self.motion, self.speed_mps, np.random.default_rng(0))
        steps = PHYSICS_HZ / self.camera_rate_hz
        if not (math.isfinite(steps) and steps >= 1.0 and abs(steps - round(steps)) < 1e-9):
            rates = [str(r) for r in (10, 12, 15, 20, 24, 30, 40, 48, 60, 80, 96, 120)]
            raise ValueError(
                f"camera_rate_hz must divide {PHYSICS_HZ} (as {', '.join(rates)} do), "
                f"got {self.camera_rate_hz!r}"
            )
        for name in ("delay_s", "gripper_delay_s", "finger_speed_mps"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0.0):
                raise ValueError(f"{name} must be a number of 0 or more, got {value!r}")


@dataclass(frozen=True, eq=False)
class Episode:
    """The world of the next reset, where it shall not be drawn from the environment's state."""

    scenario: Scenario
    sensor_rng: np.random.Generator


class _Gripper:
    """The gripper's own controller: a delay, then a set-point of limited speed."""

    def __init__(self, delay_s: float, speed_mps: float) -> None:
        self._pending = deque([STROKE_M] * round(delay_s * CONTROL_HZ))
        self._step_m = speed_mps / CONTROL_HZ
        self._width_m = STROKE_M

    def step(self, command_m: float) -> float:
        self._pending.append(command_m)
        change = self._pending.popleft() - self._width_m
        self._width_m += min(max(change, -self._step_m), self._step_m)
        return self._width_m


class ConveyorGrasp(composer.Task):
    """Grasp the object off the belt and hold it up.

    Action, (13,): six joint positions [rad], six joint velocities [rad/s], finger opening [m].
    Observations: `camera/rgb`, `camera/depth_m`, `camera/time_s` (exposure), `camera/count`
    (images so far; 0 before the first arrives), `robot/q_rad`, `robot/qd_radps`, `robot/width_m`.
    Reward: 1 in the step in which the object has been held up long enough, else 0.
    """

    def __init__(self, config: TaskConfig) -> None:
        self.config = config
        self.view: CameraView = get_view(config.camera)
        self.next_episode: Episode | None = None
        self._arena = Cell()
        self.robot = Robot()
        self._conveyor = Conveyor()
        self.prop = Prop(get_object(config.object))
        self._arena.attach_robot(self.robot)
        self._arena.attach_conveyor(self._conveyor)
        self._arena.add_free_entity(self.prop)
        add_camera(self._arena.mjcf_model, "sensor", self.view)
        add_camera(self._arena.mjcf_model, "studio", STUDIO)
        self.set_timesteps(1.0 / CONTROL_HZ, 1.0 / PHYSICS_HZ)
        self._renderer: OffscreenRenderer | None = None
        self.render_wall_s = 0.0
        """Wall-clock time spent in rendering so far."""
        self._observables = self._make_observables()
        self.configure(config)

    def configure(self, config: TaskConfig) -> None:
        """Changes what needs no new model, from the next reset on.

        Raises ValueError for another object or camera, or where one camera has a renderer and
        the other none.
        """
        for name in ("object", "camera", "has_camera"):
            if getattr(config, name) != getattr(self.config, name):
                raise ValueError(
                    f"{name} is {getattr(self.config, name)!r} in the compiled model, "
                    f"got {getattr(config, name)!r}"
                )
        self.config = config
        self.condition: Condition = get_condition(config.condition)
        self._sensor = self._make_sensor(np.random.default_rng(0))
        if self._renderer is not None:
            self._renderer.resize(self.condition.width_px, self.condition.height_px)

    # What composer asks for.

    @property
    def root_entity(self) -> composer.Arena:
        """The arena."""
        return self._arena

    @property
    def task_observables(self) -> dict[str, observable.Observable]:
        """Camera and proprioception."""
        return self._observables

    def action_spec(self, physics: Any) -> specs.BoundedArray:
        """Joint positions, joint velocities, opening."""
        del physics
        high = np.concatenate([np.full(6, 2 * np.pi), np.full(6, np.pi), [STROKE_M]])
        low = np.concatenate([-high[:12], [0.0]])
        return specs.BoundedArray((13,), float, low, high, name="joint_targets_and_width")

    def after_compile(self, physics: Any, random_state: np.random.RandomState) -> None:
        """Makes the renderer for the newly compiled model."""
        del random_state
        self.close()
        if self.config.has_camera:
            self._renderer = OffscreenRenderer(
                physics.model.ptr, self.condition.width_px, self.condition.height_px
            )

    def initialize_episode(self, physics: Any, random_state: np.random.RandomState) -> None:
        """Places the object, starts the belt, opens the hand at home, sets the lights."""
        episode = self.next_episode or self._draw_episode(random_state)
        self.next_episode = None
        self.scenario = episode.scenario
        self._sensor = self._make_sensor(episode.sensor_rng)
        self._gripper = _Gripper(self.config.gripper_delay_s, self.config.finger_speed_mps)
        self.set_light_scale(physics, self.condition.light(0.0, self.scenario.start_y_m))
        self.robot.set_configuration(physics, HOME_Q_RAD, STROKE_M)
        s = self.scenario
        x_m = BELT_CENTRE_X_M + s.offset_m
        self.place_object(physics, x_m=x_m, y_m=s.start_y_m, yaw_rad=s.yaw_rad)
        self.prop.set_velocity(physics, (0.0, s.profile(0.0), 0.0), np.zeros(3))
        self._conveyor.set_speed(physics, self.scenario.profile(0.0))
        self.referee = Referee(physics, self.prop, self.robot)

    def before_step(
        self, physics: Any, action: np.ndarray, random_state: np.random.RandomState
    ) -> None:
        """Applies the action and the belt's speed at this time."""
        del random_state
        self.robot.command_arm(physics, action[:6], action[6:12])
        self.robot.command_width(physics, self._gripper.step(float(action[12])))
        self._is_closing = action[12] < STROKE_M - 1e-6
        self._conveyor.set_speed(physics, self.scenario.profile(float(physics.data.time)))

    def after_substep(self, physics: Any, random_state: np.random.RandomState) -> None:
        """Lets the camera look."""
        del random_state
        if self.config.has_camera:
            self._look(physics)

    def after_step(self, physics: Any, random_state: np.random.RandomState) -> None:
        """Lets the referee look."""
        del random_state
        self.referee.watch(physics, self._is_closing)

    def should_terminate_episode(self, physics: Any) -> bool:
        """Held long enough, fallen, or gone."""
        del physics
        return self.referee.record.is_over

    def get_reward(self, physics: Any) -> float:
        """1 when the object has been held long enough."""
        del physics
        return float(self.referee.record.is_success)

    # The parts.

    def render(self, physics: Any, camera: str) -> tuple[np.ndarray, np.ndarray]:
        """Noise-free colours and depth of the `sensor` or the `studio` camera."""
        if self._renderer is None:
            raise ValueError("has_camera is False: this task renders nothing")
        started = time.perf_counter()
        image = self._renderer.render(
            physics.model.ptr, physics.data.ptr, camera, shadows=self.condition.shadows
        )
        self.render_wall_s += time.perf_counter() - started
        return image

    @property
    def K(self) -> np.ndarray:
        """(3, 3) intrinsics of the sensor at the condition's resolution."""
        return self.view.intrinsics(self.condition.width_px, self.condition.height_px)

    def set_light_scale(self, physics: Any, scale: float) -> None:
        """Brightness of the cell, 1 being normal."""
        self._arena.set_light_scale(physics, scale)

    def place_object(self, physics: Any, *, x_m: float, y_m: float, yaw_rad: float) -> None:
        """Lays the object on the belt, at rest."""
        quaternion = math.cos(0.5 * yaw_rad), 0.0, 0.0, math.sin(0.5 * yaw_rad)
        position = x_m, y_m, 0.5 * self.prop.spec.size_m[2]
        self.prop.set_pose(physics, position, quaternion)
        self.prop.set_velocity(physics, np.zeros(3), np.zeros(3))

    def rewind_belt(self, physics: Any) -> None:
        """Puts the drawn belt at its mark, as at the start of an episode."""
        self._conveyor.rewind(physics)

    def is_in_view(self, physics: Any) -> bool:
        """Whether every corner of the object projects into the sensor's image."""
        T_camera_object = np.linalg.inv(self.view.T_world_camera) @ self.referee.object_pose(
            physics
        )
        corners = 0.5 * np.asarray(self.prop.spec.size_m) * _CUBE_CORNERS
        p_camera = corners @ T_camera_object[:3, :3].T + T_camera_object[:3, 3]
        uvw = p_camera @ self.K.T
        uv = uvw[:, :2] / uvw[:, 2:]
        last = self.condition.width_px - 1, self.condition.height_px - 1
        return bool(np.all(uv >= 0.0) and np.all(uv <= last))

    @property
    def gl_renderer(self) -> str:
        """Name of what renders, or `none`."""
        return self._renderer.gl_renderer if self._renderer else "none"

    def close(self) -> None:
        """Frees the renderer."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def _draw_episode(self, random_state: np.random.RandomState) -> Episode:
        seeds = np.random.SeedSequence(random_state.randint(0, 2**32, 4, np.uint32).tolist())
        scene_rng, sensor_rng = (np.random.default_rng(s) for s in seeds.spawn(2))
        c = self.config
        return Episode(c.scenarios.draw(c.motion, c.speed_mps, scene_rng), sensor_rng)

    def _make_sensor(self, rng: np.random.Generator) -> Sensor:
        c = self.config
        return Sensor(self.condition, c.camera_rate_hz, c.delay_s, PHYSICS_HZ, rng)

    def _make_observables(self) -> dict[str, observable.Observable]:
        sensor = {
            "camera/rgb": lambda physics: self._newest(physics).rgb,
            "camera/depth_m": lambda physics: self._newest(physics).depth_m,
            "camera/time_s": lambda physics: self._newest(physics).time_s,
            "camera/count": lambda physics: self._newest(physics).count,
        }
        robot = {
            "robot/q_rad": self.robot.q,
            "robot/qd_radps": self.robot.qd,
            "robot/width_m": self.robot.width_m,
        }
        made: dict[str, observable.Observable] = {}
        for name, read in (sensor | robot).items():
            made[name] = observable.Generic(read, update_interval=PHYSICS_HZ // CONTROL_HZ)
            made[name].enabled = name in robot or self.config.has_camera
        return made

    def _newest(self, physics: Any) -> Frame:
        """The image that has arrived last; at time 0 no physics step has let the camera look."""
        self._look(physics)
        return self._sensor.newest(float(physics.data.time))

    def _look(self, physics: Any) -> None:
        def photograph() -> Image:
            target_y_m = float(physics.bind(self.prop.body).xpos[1])
            self.set_light_scale(physics, self.condition.light(time_s, target_y_m))
            return self.render(physics, "sensor")

        time_s = float(physics.data.time)
        self._sensor.look(time_s, photograph)
