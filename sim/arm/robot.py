"""An arm with its gripper, as one composer entity.

The arm is servoed in position with velocity feed-forward, the gripper by a force-limited position
servo on the opening.
"""

from typing import Any

import numpy as np
from dm_control import composer, mjcf
from numpy.typing import ArrayLike

from sim import ASSETS
from sim.arm.embodiments import JOINT_NAMES, UR5_RG2, Embodiment


class Robot(composer.ModelWrapperEntity):
    """Arm with gripper; its frame is the mounting face of the arm, x towards the work."""

    def _build(self, embodiment: Embodiment = UR5_RG2, *, fixed_fingers: bool = False) -> None:
        """Reads both models and bolts the gripper to the flange.

        Args:
            embodiment: Which arm and gripper, and their waiting pose.
            fixed_fingers: Weld the fingers fully open and leave out everything that moves them:
                the six-joint model that inverse kinematics wants.
        """
        self._home_q_rad = np.array(embodiment.home_q_rad)
        self._stroke_m = embodiment.gripper.stroke_m
        self._mjcf_model = mjcf.from_path(str(ASSETS / embodiment.arm.xml))
        self._gripper = mjcf.from_path(str(ASSETS / embodiment.gripper.xml))
        if fixed_fingers:
            _weld_fingers_open(self._gripper, self._stroke_m)
        self._mjcf_model.find("site", "tool_mount").attach(self._gripper)

        def of_arm(kind: str) -> tuple[Any, ...]:
            return tuple(self._mjcf_model.find(kind, name) for name in JOINT_NAMES)

        def of_fingers(name: str) -> tuple[Any, ...]:
            joints = (self._gripper.find("joint", f"{side}_{name}") for side in ("right", "left"))
            return tuple(joint for joint in joints if joint is not None)

        self.arm_joints = of_arm("joint")
        """The six joint elements, in the order of JOINT_NAMES."""
        self.arm_actuators = of_arm("actuator")
        """The six position servos, in the order of JOINT_NAMES."""
        self.finger_joints = of_fingers("finger")
        """Right and left slide, 0 m closed to half the stroke open; empty with fixed fingers."""
        self.finger_springs = of_fingers("bend")
        """Right and left hinge [rad] of fingers that give way; empty for stiff ones."""
        self.gripper_actuator: Any | None = self._gripper.find("actuator", "grip")
        """The force-limited servo of the opening; None with fixed fingers."""
        self.tcp_site: Any = self._gripper.find("site", "tcp")
        """Midpoint of the pads' centres: z out of the hand, x the closing axis."""
        self.flange_site: Any = self._mjcf_model.find("site", "flange")
        """Tool flange of the arm, the end of the DH chain."""
        self.pad_geoms = tuple(self._gripper.find("geom", f"{s}_pad") for s in ("right", "left"))
        """Right and left pad."""
        solid = [g for g in self._mjcf_model.find_all("geom") if not _is_visual(g)]
        self.hand_geoms = tuple(g for g in solid if g.root is self._gripper)
        """Every colliding geom of the gripper, the pads among them."""
        self.arm_geoms = tuple(g for g in solid if g.root is self._mjcf_model)
        """Every colliding geom of the arm."""

    def command_arm(self, physics: Any, q_rad: np.ndarray, qd_radps: np.ndarray) -> None:
        """Sets the joint servos to follow a moving configuration without velocity lag.

        A position servo trails a moving set-point by (kv / kp) qd; that much is added to it. The
        set-point then stands still until the next command, so give the configuration wanted in
        the middle of the control step; its end would make the arm lead by half a step.

        Args:
            physics: Physics of the compiled scene.
            q_rad: (6,) wanted joint angles.
            qd_radps: (6,) wanted joint speeds.
        """
        servos = physics.bind(self.arm_actuators)
        lead_s = servos.biasprm[:, 2] / servos.biasprm[:, 1]
        self._set_control(physics, servos, np.asarray(q_rad) + lead_s * np.asarray(qd_radps))

    def command_width(self, physics: Any, width_m: float) -> None:
        """Sets the opening the gripper moves to; a set-point inside an object squeezes it."""
        servo = physics.bind(self.gripper_actuator)
        self._set_control(physics, servo, 0.5 * np.clip(width_m, 0.0, self._stroke_m))

    @staticmethod
    def _set_control(physics: Any, servos: Any, control: Any) -> None:
        # A binding's `ctrl` would mark the state as changed, and whoever next reads a derived
        # quantity would have the scene computed anew: slow, and the last bits would then depend
        # on who looks.
        physics.data.ctrl[servos.element_id] = control

    def q(self, physics: Any) -> np.ndarray:
        """(6,) joint angles [rad]."""
        return np.array(physics.bind(self.arm_joints).qpos)

    def qd(self, physics: Any) -> np.ndarray:
        """(6,) joint speeds [rad/s]."""
        return np.array(physics.bind(self.arm_joints).qvel)

    def width_m(self, physics: Any) -> float:
        """Opening as the drive has it; fingers that give way bend out of it."""
        return float(np.sum(physics.bind(self.finger_joints).qpos))

    def go_home(self, physics: Any) -> None:
        """Puts the arm at its waiting pose with the hand open; as `set_configuration` does."""
        self.set_configuration(physics, self._home_q_rad, self._stroke_m)

    def set_configuration(self, physics: Any, q_rad: ArrayLike, width_m: float) -> None:
        """Puts arm and fingers in place, at rest, with their servos holding them there.

        Call inside `physics.reset_context()`, which brings all that depends on them up to date.
        """
        arm = physics.bind(self.arm_joints)
        q = np.asarray(q_rad, float)
        arm.qpos, arm.qvel = q, 0.0
        self.command_arm(physics, q, np.zeros(6))
        fingers = physics.bind(self.finger_joints)
        fingers.qpos, fingers.qvel = 0.5 * width_m, 0.0
        if self.finger_springs:
            springs = physics.bind(self.finger_springs)
            springs.qpos, springs.qvel = springs.qpos_spring, 0.0
        self.command_width(physics, width_m)


def _is_visual(geom: Any) -> bool:
    return geom.dclass is not None and geom.dclass.dclass == "visual"


def _weld_fingers_open(gripper: Any, stroke_m: float) -> None:
    """Removes every joint, coupling, tendon and actuator, leaving the fingers open and straight."""
    for kind in ("actuator", "equality", "tendon", "joint"):
        for element in gripper.find_all(kind):
            element.remove()
    for name, direction in (("right_finger", 1.0), ("left_finger", -1.0)):
        finger = gripper.find("body", name)
        finger.pos = finger.pos + np.array([0.5 * direction * stroke_m, 0.0, 0.0])
