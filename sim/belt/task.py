"""The composer task: a cell, an object on a running belt, a delayed camera and a slow gripper."""

import functools
import itertools
from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np
from dm_control import composer
from dm_control.composer.observation import observable
from dm_env import specs

from sim.arm.embodiments import Embodiment, Gripper, get_embodiment
from sim.arm.robot import Robot
from sim.belt.arena import Cell, Scenery
from sim.belt.carriers import CARRIERS, Pose
from sim.belt.objects import Prop, get_object
from sim.belt.referee import Referee
from sim.belt.task_config import Episode, TaskConfig
from sim.geometry import project, yaw_quaternion
from sim.imaging.camera import STUDIO, CameraView, OffscreenRenderer, add_camera, get_view
from sim.imaging.degradations import Condition, get_condition
from sim.imaging.sensor import CameraImage, Develop, Pixels, Sensor
from sim.world_config import PHYSICS_HZ

CONTROL_HZ = 120
_CUBE_CORNERS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))


class _GripperControl:
    """The gripper's own controller: a delay, then a set-point of limited speed."""

    def __init__(self, gripper: Gripper, delay_s: float) -> None:
        self._pending = deque([gripper.stroke_m] * round(delay_s * CONTROL_HZ))
        self._step_m = gripper.speed_mps / CONTROL_HZ
        self._width_m = gripper.stroke_m

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
        self.embodiment: Embodiment = get_embodiment(config.embodiment)
        self._arena = Cell(self.embodiment)
        self.robot = Robot(self.embodiment)
        self.carrier = CARRIERS[config.carrier]()
        self.prop = Prop(get_object(config.object))
        self._arena.attach_robot(self.robot)
        self._arena.attach_carrier(self.carrier)
        self._arena.add_free_entity(self.prop)
        self._scenery = Scenery(self._arena, self.carrier, self.view, self.prop.spec)
        add_camera(self._arena.mjcf_model, "sensor", self.view)
        add_camera(self._arena.mjcf_model, "studio", STUDIO)
        self.set_timesteps(1.0 / CONTROL_HZ, 1.0 / PHYSICS_HZ)
        self._renderer: OffscreenRenderer | None = None
        self._observables = self._make_observables()
        self.configure(config)

    def configure(self, config: TaskConfig) -> None:
        """Changes what needs no new model, from the next reset on.

        Raises ValueError for another embodiment, object, camera or carrier, or where one camera
        has a renderer and the other none.
        """
        for name in ("embodiment", "object", "camera", "carrier", "has_camera"):
            if getattr(config, name) != getattr(self.config, name):
                raise ValueError(
                    f"{name} is {getattr(self.config, name)!r} in the compiled model, "
                    f"got {getattr(config, name)!r}"
                )
        self.config = config
        self.condition: Condition = get_condition(config.condition)
        self._sensor = self._make_sensor(np.random.default_rng(0))
        for name, observed in self._observables.items():
            is_seen = config.has_camera and config.observes_camera
            observed.enabled = is_seen or not name.startswith("camera/")
        if self._renderer is not None:
            self._renderer.resize(self.condition.width_px, self.condition.height_px)

    # What composer asks for.

    @property
    def root_entity(self) -> composer.Arena:
        """The arena."""
        return self._arena

    @property
    def task_observables(self) -> dict[str, Any]:
        """Camera and proprioception."""
        return self._observables

    def action_spec(self, physics: Any) -> specs.BoundedArray:
        """Joint positions, joint velocities, opening."""
        speeds, stroke_m = self.embodiment.arm.joint_speed_radps, self.embodiment.gripper.stroke_m
        high = np.concatenate([np.full(6, 2 * np.pi), speeds, [stroke_m]])
        low = np.concatenate([-high[:12], [0.0]])
        return specs.BoundedArray((13,), float, low, high, name="joint_targets_and_width")

    def after_compile(self, physics: Any, random_state: np.random.RandomState) -> None:
        """Makes the renderer for the newly compiled model."""
        self.close()
        if self.config.has_camera:
            self._renderer = OffscreenRenderer(
                physics.model.ptr, self.condition.width_px, self.condition.height_px
            )

    def initialize_episode(self, physics: Any, random_state: np.random.RandomState) -> None:
        """Places the object, starts its carrier, opens the hand at home, sets the lights."""
        episode = self.next_episode or self._draw_episode(random_state)
        self.next_episode = None
        self.scenario = episode.scenario
        self._sensor = self._make_sensor(episode.sensor_rng)
        self._gripper = _GripperControl(self.embodiment.gripper, self.config.gripper_delay_s)
        self._arena.set_light_scale(physics, self.condition.light(0.0, episode.scenario.start.y_m))
        self.robot.go_home(physics)
        start, speed_mps = self.scenario.start, self.scenario.profile(0.0)
        self.place_object(physics, start)
        vx, vy, yaw_rate = self.carrier.velocity_at(start, speed_mps)
        self.prop.set_velocity(physics, (vx, vy, 0.0), (0.0, 0.0, yaw_rate))
        self.carrier.set_speed(physics, speed_mps)
        self._scenery.arrange(physics, self.condition, self.scenario)
        self.referee = Referee(physics, self.prop, self.robot)

    def before_step(
        self, physics: Any, action: np.ndarray, random_state: np.random.RandomState
    ) -> None:
        """Applies the action and the carrier's speed at this time."""
        self.robot.command_arm(physics, action[:6], action[6:12])
        self.robot.command_width(physics, self._gripper.step(float(action[12])))
        self._is_closing = action[12] < self.embodiment.gripper.stroke_m - 1e-6
        self.carrier.set_speed(physics, self.scenario.profile(float(physics.data.time)))

    def before_substep(
        self, physics: Any, action: np.ndarray, random_state: np.random.RandomState
    ) -> None:
        """Moves what rides along."""
        self._scenery.before_physics_step(physics)

    def after_substep(self, physics: Any, random_state: np.random.RandomState) -> None:
        """Lets the camera look."""
        if self.config.has_camera:
            self._look(physics)

    def after_step(self, physics: Any, random_state: np.random.RandomState) -> None:
        """Lets the referee look."""
        self.referee.watch(physics, self._is_closing)

    def should_terminate_episode(self, physics: Any) -> bool:
        """Whether the object has been held long enough, has fallen or is gone."""
        return self.referee.record.is_over

    def get_reward(self, physics: Any) -> float:
        """Returns 1 when the object has been held long enough, else 0."""
        return float(self.referee.record.is_success)

    # The parts.

    def render(self, physics: Any, camera: str) -> Pixels:
        """Noise-free colours and depth of the `sensor` or the `studio` camera."""
        rows, columns = self.condition.height_px, self.condition.width_px
        return self.expose(physics, camera)((slice(0, rows), slice(0, columns)))

    def expose(self, physics: Any, camera: str) -> Develop:
        """What the `sensor` or the `studio` camera sees now; its pixels are rendered on demand."""
        if self._renderer is None:
            raise ValueError("has_camera is False: this task renders nothing")
        exposure = self._renderer.expose(
            physics.model.ptr, physics.data.ptr, camera, shadows=self.condition.shadows
        )
        return functools.partial(self._renderer.develop, exposure)

    def image(self, physics: Any) -> CameraImage:
        """The image of the sensor that has arrived last; a black one before the first."""
        self._look(physics)  # at time 0 no physics step has let the camera look
        return self._sensor.newest(float(physics.data.time))

    @property
    def rendering_s(self) -> float:
        """Wall-clock time of all rendering so far."""
        return self._renderer.spent_s if self._renderer else 0.0

    @property
    def K(self) -> np.ndarray:
        """(3, 3) intrinsics of the sensor at the condition's resolution."""
        return self.view.intrinsics(self.condition.width_px, self.condition.height_px)

    def place_object(self, physics: Any, pose: Pose) -> None:
        """Lays the object on the surface, at rest."""
        position = pose.x_m, pose.y_m, 0.5 * self.prop.spec.size_m[2]
        self.prop.set_pose(physics, position, yaw_quaternion(pose.yaw_rad))
        self.prop.set_velocity(physics, np.zeros(3), np.zeros(3))

    def lay_for_teaching(self, physics: Any, pose: Pose) -> None:
        """Lays the object there, in a cell at rest and in normal light.

        All that shows is as in a new cell, whatever ran before. Reset the environment afterwards.
        """
        with physics.reset_context():
            self.robot.go_home(physics)
            self.place_object(physics, pose)
            self._scenery.hide(physics)
        self.carrier.show_mark(physics)
        self._arena.set_light_scale(physics, 1.0)

    def is_in_view(self, physics: Any) -> bool:
        """Whether every corner of the object projects into the sensor's image."""
        T_camera_object = np.linalg.inv(self.view.T_world_camera) @ self.referee.object_pose(
            physics
        )
        corners = 0.5 * np.asarray(self.prop.spec.size_m) * _CUBE_CORNERS
        p_camera = corners @ T_camera_object[:3, :3].T + T_camera_object[:3, 3]
        uv = project(self.K @ np.eye(3, 4), p_camera)
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
        return Sensor(self.condition, c.camera_rate_hz, c.delay_s, PHYSICS_HZ, rng, self.K)

    def _make_observables(self) -> dict[str, Any]:
        read: dict[str, Callable[[Any], Any]] = {
            "camera/rgb": lambda physics: self.image(physics).whole[0],
            "camera/depth_m": lambda physics: self.image(physics).whole[1],
            "camera/time_s": lambda physics: self.image(physics).time_s,
            "camera/count": lambda physics: self.image(physics).count,
            "robot/q_rad": self.robot.q,
            "robot/qd_radps": self.robot.qd,
            "robot/width_m": self.robot.width_m,
        }
        interval = PHYSICS_HZ // CONTROL_HZ
        return {
            name: observable.Generic(function, update_interval=interval)
            for name, function in read.items()
        }

    def _look(self, physics: Any) -> None:
        def expose() -> Develop:
            target_y_m = float(physics.bind(self.prop.body).xpos[1])
            self._arena.set_light_scale(physics, self.condition.light(time_s, target_y_m))
            return self.expose(physics, "sensor")

        time_s = float(physics.data.time)
        self._sensor.look(time_s, expose)
