"""The UR5 that carries the camera: it drives to views by the servo, and reports its pose.

The reported pose comes from the joint angles through the published kinematics, with the error of a
real hand-eye calibration and of the arm on top; the true pose is the simulator's alone.
"""

from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np

from sim.apple.world import FLANGE_CAMERA_M, HAND_CAMERA
from sim.arm.embodiments import UR5
from sim.arm.servo import Servo, ServoConfig
from sim.checks import require_at_least
from sim.geometry import transform

HOME_Q_RAD = (-0.3566, -1.7957, 1.9462, -0.1505, 1.2142, 3.1416)
"""Camera 0.45 m in front of the arm's first axis, level, looking along x."""

_HAND = ("camera_housing", "wrist_3_flange", "wrist_2_housing", "wrist_1_housing")
_SPEED_RADPS = (1.0,) * 6
"""Joint speeds beside a tree: a third of what the arm can do."""
_LIMIT_S = 8.0
_RATE_HZ = round(ServoConfig().rate_hz)
_PROGRESS = 0.98
"""An arm that is not so much nearer after a quarter of a second will not arrive."""


@dataclass(frozen=True)
class PoseNoise:
    """Standard deviations of a reported pose, about each axis, from one view to the next."""

    rotation_rad: float = float(np.radians(0.5))
    position_m: float = 0.0

    def __post_init__(self) -> None:
        require_at_least(self, 0.0, *self.__dataclass_fields__)

    def disturbed(self, T: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Returns the (4, 4) pose with an error, which is drawn even where it is zero."""
        turn, shift = rng.standard_normal((2, 3))
        wrong = T.copy()
        quaternion, R = np.empty(4), np.empty(9)
        mujoco.mju_euler2Quat(quaternion, self.rotation_rad * turn, "xyz")
        mujoco.mju_quat2Mat(R, quaternion)
        wrong[:3, :3] = T[:3, :3] @ R.reshape(3, 3)
        wrong[:3, 3] += self.position_m * shift
        return wrong


def camera_pose(q_rad: np.ndarray) -> np.ndarray:
    """Returns the (4, 4) pose T_base_camera from joint angles (6,) and the DH table.

    The camera's axes are those of the flange: x right, y down, z forward; it stands off the flange
    along z alone.  Source: [UR5DH] through `sim.arm.embodiments`.
    """
    return UR5.forward(q_rad) @ transform(np.eye(3), FLANGE_CAMERA_M)


class EyeInHand:
    """Moves the arm to camera poses, clear of the fruit, within its joint speeds."""

    def __init__(self, model: mujoco.MjModel) -> None:
        """`model` is an orchard's, of which the arm's six joints are all that moves."""
        fruits = [name for i in range(model.ngeom) if (name := model.geom(i).name)[:4] == "skin"]
        self._servo = Servo(model, ServoConfig(), _SPEED_RADPS, HAND_CAMERA, list(_HAND), fruits)
        self.reset()

    def reset(self, q_rad: np.ndarray | tuple[float, ...] = HOME_Q_RAD) -> None:
        """Puts the arm at rest in a configuration (6,)."""
        self._servo.reset(np.asarray(q_rad, float))

    @property
    def q_rad(self) -> np.ndarray:
        """(6,) joint angles."""
        return self._servo.q

    def reach(
        self, T_base_camera: np.ndarray, on_step: Callable[[np.ndarray], None] | None = None
    ) -> bool:
        """Drives to a camera pose; returns False, and goes back, where it is out of reach.

        A pose is reached within a millimetre and a tenth of a degree. `on_step` is called with the
        joint angles (6,) of each step, a 120th of a second.
        """
        before, still, nearest = self.q_rad, np.zeros(6), np.inf
        for step in range(round(_LIMIT_S * _RATE_HZ)):
            self._servo.step(T_base_camera, still)
            if on_step is not None:
                on_step(self._servo.q)
            off_m, turn_rad = self._distance(T_base_camera)
            if off_m < 1e-3 and turn_rad < np.radians(0.1):
                return True
            if step % (_RATE_HZ // 4) == 0:
                if off_m + 0.3 * turn_rad > _PROGRESS * nearest:
                    break
                nearest = off_m + 0.3 * turn_rad
        self.reset(before)
        return False

    def _distance(self, T: np.ndarray) -> tuple[float, float]:
        """How far the camera is from a pose, [m] and [rad]."""
        error = np.linalg.inv(self._servo.T_world_tcp) @ T
        turn = np.arccos(np.clip(0.5 * (np.trace(error[:3, :3]) - 1.0), -1.0, 1.0))
        return float(np.linalg.norm(error[:3, 3])), float(turn)
