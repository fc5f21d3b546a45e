"""The robot's body as decision knows it: where its parts are, and which joints its arms have."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from humanoid_bt.core.errors import HumanoidBtError
from humanoid_bt.core.geometry import quaternion, rotation_matrix
from humanoid_bt.core.messages import SIDES, Array, Pose, Side, State
from humanoid_bt.robot.arms import arms_of, joints_fault
from humanoid_bt.robot.config import RobotConfig
from humanoid_bt.robot.model import RobotModel, carriers
from humanoid_bt.robot.published import OWN

_NEAR = 5  # names that are told, at most
_ALIKE = 0.5  # share of two names that is the same from which on they are near each other


@dataclass(frozen=True, slots=True)
class ArmJoint:
    """A joint of an arm.

    Attributes:
        angle: measured [rad].
        lower, upper: its limits [rad].
    """

    angle: float
    lower: float
    upper: float


class Anatomy:
    """Kinematics of the robot in a state: of the estimate, as everything that decision knows of where it is.

    Args:
        robot: its model, or what its ``robot.yaml`` says.
    """

    def __init__(self, robot: RobotModel | RobotConfig) -> None:
        self._robot = robot = RobotModel(robot) if isinstance(robot, RobotConfig) else robot
        model = robot.model
        self._arms = arms_of(robot)
        self._data = mujoco.MjData(model)
        self._state: State | None = None  # that of the data
        sites = {model.site(site).name: site for site in range(model.nsite)}
        self._sites = {name: site for name, site in sites.items() if not name.startswith(OWN)}
        self._bodies = {model.body(body).name: body for body in range(1, model.nbody)}
        own = {name.removeprefix(OWN): site for name, site in sites.items() if name.startswith(OWN)}
        self._bodies = {name: body for name, body in self._bodies.items() if name not in own}
        self._sites |= own
        for side in SIDES:
            if shoulder := robot.arm_joints(side):
                self._bodies.setdefault(f"{side}_shoulder", int(model.jnt_bodyid[shoulder[0] + 1]))
        self._palms: dict[str, Side] = {f"{side}_palm": side for side in SIDES if side in robot.palm_axes}

    def pose(self, name: str, state: State) -> Pose:
        """Return where a body or a site is in a state.

        Raises:
            HumanoidBtError: the robot has neither of this name.
        """
        if (side := self._palms.get(name)) is not None:
            return _pose(state.hands[side], state.hand_orientations[side])
        data = self._at(state)
        if (body := self._bodies.get(name)) is not None:
            return _pose(data.xpos[body], data.xquat[body])
        if (site := self._sites.get(name)) is not None:
            return _pose(data.site_xpos[site], quaternion(data.site_xmat[site].reshape(3, 3)))
        raise HumanoidBtError(
            f"the robot has no body or site {name!r}; {_near(str(name), {**self._bodies, **self._sites})}"
        )

    def arm_joints(self, side: Side, state: State) -> dict[str, ArmJoint]:
        """Return the joints of an arm in a state by their names, from the shoulder to the hand; none without hands."""
        names = self._robot.joint_names
        return {
            name: ArmJoint(float(state.joint_positions[names.index(name)]), low, high)
            for name, (low, high) in self._arms.get(side, {}).items()
        }

    def arm_length(self, side: Side) -> float:
        """Return the way from the shoulder to a palm, from joint to joint [m]; 0 without hands."""
        joints, model = self._robot.arm_joints(side), self._robot.model
        if not joints:
            return 0.0
        links = carriers(model, model.body(self._robot.config.hands[side].body).id)
        shoulder = links.index(int(model.jnt_bodyid[joints[0] + 1]))
        ways = [model.body_pos[body] for body in links[:shoulder]] + [np.array(self._robot.config.hands[side].position)]
        return float(sum(np.linalg.norm(way) for way in ways))

    def joints_fault(self, side: Side, joints: Mapping[str, float]) -> str:
        """Return what is wrong with angles [rad] asked of an arm's joints, "" for nothing."""
        return joints_fault(self._arms, side, joints)

    def _at(self, state: State) -> mujoco.MjData:
        data = self._data
        if self._state is not state:
            data.qpos[:] = np.concatenate([state.base_position, state.base_quaternion, state.joint_positions])
            mujoco.mj_kinematics(self._robot.model, data)
            self._state = state
        return data


def _pose(position: Array, turn: Array) -> Pose:
    """Return a pose that stays, whatever comes of the arrays, and that nobody can write into."""
    values = position.copy(), turn.copy(), rotation_matrix(turn)
    for value in values:
        value.setflags(write=False)
    return Pose(*values)


def _near(name: str, known: Mapping[str, object]) -> str:
    within = [one for one in known if name and name in one]
    near = difflib.get_close_matches(name, known, n=_NEAR, cutoff=_ALIKE)
    found = list(dict.fromkeys((*within, *near)))[:_NEAR]
    return f"near it: {', '.join(found)}" if found else f"it has {', '.join(sorted(known))}"
