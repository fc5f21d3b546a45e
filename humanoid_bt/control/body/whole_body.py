"""The model-based body, ``dcm``: footsteps, balance by the divergent component of motion, inverse kinematics.

It balances whatever the targets are, so that a robot without commands goes on standing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from humanoid_bt.control.body.arm_swing import ArmSwing
from humanoid_bt.control.body.body import Footstep, Setpoint
from humanoid_bt.control.body.body_task import BodyTargets
from humanoid_bt.control.body.bracing import Bracing
from humanoid_bt.control.body.feedforward import Feedforward
from humanoid_bt.control.body.hand_goals import HandGoals
from humanoid_bt.control.body.inverse_kinematics import InverseKinematics
from humanoid_bt.control.body.lean import LeanReference
from humanoid_bt.control.body.lunge import Lunge
from humanoid_bt.control.body.planar import ahead, seen_from
from humanoid_bt.control.body.rearranging import Rearranging
from humanoid_bt.control.body.references import (
    ArmReference,
    ComHeightReference,
    GazeReference,
    PostureReference,
    approach,
)
from humanoid_bt.control.body.stabilizer import Stabilizer
from humanoid_bt.control.body.swing import TiltCompensation
from humanoid_bt.control.body.walking import Walker
from humanoid_bt.control.body.yielding import Felt, YieldingArms
from humanoid_bt.control.dynamics import RobotDynamics
from humanoid_bt.core.clock import WHOLE_BODY_PERIOD
from humanoid_bt.core.geometry import planar_pose
from humanoid_bt.core.messages import (
    SIDES,
    ArmTarget,
    Array,
    BaseTarget,
    Estimate,
    Gait,
    GazeTarget,
    HandTarget,
    PostureTarget,
    Side,
    Target,
)
from humanoid_bt.robot.model import BASE_COORDINATES, BASE_DOFS, RobotModel

_EASE_TIME = 0.3  # s in which a body that an arm has let go of turns as fast as it may again
_BLENDED = 1e-3  # of a share; the rest is taken in one step
_FALL_MARGIN = 0.05  # share of the base's home height that is kept above the height of a fall
_GIVE_TIME = 0.3  # s in which the body is given to a reaching hand
_TAKE_BACK_TIME = 0.8  # s in which it is taken back, from wherever it leans
_NOT_FIRM = (1.0, 1.0)  # height, pelvis and torso of a body with no hand out, or that is given to it


class WholeBody:
    """Walking, balance, hands and gaze of one robot.

    Args:
        robot: the robot.
        dynamics: as it is estimated, always up to date.
        contact: what touches it, likewise.

    Attributes:
        dynamics: as it is estimated, always up to date.
        walker: its gait.
        lunge: how its trunk leans after a push.
        kinematics: its planned motion.
        arms: which of its arms yield to what pushes them.
        failure: "": it has an answer to everything.
    """

    failure = ""
    period = WHOLE_BODY_PERIOD

    def __init__(self, robot: RobotModel, dynamics: RobotDynamics, contact: Felt) -> None:
        config, dt = robot.config, self.period
        self._robot, self._dt = robot, dt
        self.dynamics = dynamics
        self.walker = Walker(config.gait, config.sole, dt)
        self._stabilizer = Stabilizer(config.gait, config.sole, robot.mass, dt)
        self._tilt = TiltCompensation(dt)
        self.lunge = Lunge(robot, dt)
        self.kinematics = InverseKinematics(robot, dt)
        self._contact = contact
        self.arms = YieldingArms(robot, dynamics, self.kinematics, dt)
        self._bracing = Bracing(robot.mass, dynamics, dt)
        self._feedforward = Feedforward(robot, self.dynamics)
        neck_range = 0.0
        if config.neck:
            yaw = robot.joint(config.neck.yaw)
            neck_range = float(min(robot.upper[yaw], -robot.lower[yaw]))
        self._gaze = GazeReference(config.whole_body, dt, neck_range)
        self._lean = LeanReference(robot, dt)
        self._arm_swing = ArmSwing(robot, dt)
        self._palms = HandGoals(robot, dynamics, self.kinematics, contact=contact, arms=self.arms, dt=dt)
        self._arms: dict[Side, ArmReference] = {}
        hands: list[Side] = [side for side in SIDES if side in config.hands]
        self._rearranging = {side: Rearranging(robot, self.kinematics, side, dt) for side in hands}
        self._home_joints: Array = robot.home_qpos[BASE_COORDINATES:]
        self._posture = PostureReference(self._home_joints, dt)
        self._height = self._home_height = 0.0
        self._firmness = (config.whole_body.walk_height_firmness, config.whole_body.walk_firmness)
        self._com_height = ComHeightReference(config.gait.rise, dt)
        self._home_base: Array = np.zeros(3)  # as seen from the stance
        self._asked: dict[Side, ArmTarget | None] = {}  # of arms that are rearranged
        self._eased, self._lunged = 1.0, False
        self._reaching = 0.0
        self._commanded: frozenset[Side] = frozenset()
        self._held_joints: tuple[int, ...] = ()
        self._zmp: Array = np.zeros(2)

    def reset(self, estimate: Estimate) -> None:
        """Begin a run: the robot stands at rest, and how it stands is its home posture."""
        self._home_joints = estimate.qpos[BASE_COORDINATES:].copy()
        self._home_height = float(self.dynamics.com[2])
        self._home_base = estimate.qpos[:3].copy()
        least_share = self._robot.config.fall.height + _FALL_MARGIN
        self.kinematics.lowest = least_share * float(estimate.qpos[2])
        self.restart(estimate)
        self._home_base[:2] = seen_from(self.walker.stance, self._home_base)

    def restart(self, estimate: Estimate) -> None:
        """Stand where the robot is, with everything at rest, and return to the home posture slowly.

        A robot that has a foot in the air, because another body walked, finishes that step first.
        """
        config, dt = self._robot.config, self._dt
        self.kinematics.reset(estimate.qpos)
        self._stabilizer.reset(self.dynamics.com)
        self.walker.reset(self.dynamics.soles, self.dynamics.footings, self._stabilizer.omega)
        if (lifted := self._lifted(estimate)) is not None:
            self.walker.go_on(lifted, self._dcm())
        self._tilt = TiltCompensation(dt)
        self._gaze.yaw = self._gaze.pitch = 0.0
        self._lean.reset()
        self._bracing.reset()
        self.lunge.reset()
        sides, names = tuple(self.dynamics.hands), self._robot.joint_names
        self._arm_swing.joints[:] = 0.0
        self._palms.reset()
        self._arms = {side: ArmReference(names, config.whole_body, dt) for side in sides}
        self._held_joints = ()
        self._posture = PostureReference(self._home_joints, dt)
        self._posture.release_from(self.kinematics.joints)
        self.arms.reset()
        for rearranging in self._rearranging.values():
            rearranging.reset()
        self._asked.clear()
        self._eased, self._lunged = 1.0, False
        self.kinematics.ease(1.0)
        self._com_height.reset(float(self.dynamics.com[2]))
        self._height = self._com_height.height - self._home_height
        self._reaching = 0.0
        self._commanded = frozenset()
        self._zmp = self.walker.zmp_reference.copy()

    def _dcm(self) -> Array:
        """Return the measured DCM, shape (2,), world frame [m]."""
        dynamics, omega = self.dynamics, self._stabilizer.omega
        (x, y, _), (speed_x, speed_y, _) = dynamics.com.tolist(), dynamics.com_velocity.tolist()
        return np.array((x + speed_x / omega, y + speed_y / omega))

    def _lifted(self, estimate: Estimate) -> Side | None:
        """Return the foot that is in the air while the other one carries the robot, if one is."""
        carries = [force > self._robot.config.gait.touchdown_force for force in estimate.foot_force.tolist()]
        return None if all(carries) or not any(carries) else SIDES[carries.index(False)]

    @property
    def fault(self) -> str:
        """Why the last setpoint is not what it should be, "" if it is."""
        return "" if self.kinematics.solved else "inverse kinematics without a solution"

    @property
    def gait(self) -> Gait:
        """What the legs do."""
        return self.walker.gait

    @property
    def still_for(self) -> float:
        """How long it stands already [s]; 0 while it steps."""
        return self.walker.still_for

    @property
    def stance(self) -> Array:
        """Middle between the feet on the ground and its heading, shape (3,): x, y [m], yaw [rad], world frame."""
        return self.walker.stance

    @property
    def footsteps(self) -> Sequence[Footstep]:
        """Planned footholds ahead, the next first."""
        return self.walker.footsteps

    @property
    def com_error(self) -> Array:
        """From where the centre of mass was planned to be to where it was to go, shape (3,) [m]."""
        return self.kinematics.com_error

    def hand_error(self, side: Side) -> float | None:
        """How far a planned palm is from where it is to go [m]; None if nothing commands it."""
        return self.kinematics.hand_error(side)

    @property
    def hand_obstacles(self) -> Mapping[Side, str]:
        """The own link that keeps a commanded palm from its target, of those that one keeps."""
        return self.kinematics.hand_obstacles

    def update(self, estimate: Estimate, targets: Mapping[str, Target], hold: bool) -> Setpoint:
        """Return the setpoints of this control period.

        Args:
            estimate: the robot, as it is believed to be; its dynamics are up to date with it.
            targets: resource -> target; what is missing comes to rest.
            hold: finish the step, stand, and keep hands, gaze and height where they are relative to the stance. They
                are kept, too, after inverse kinematics without a solution.
        """
        dynamics, walker, stabilizer = self.dynamics, self.walker, self._stabilizer
        dcm = self._dcm()
        left, right = estimate.foot_force.tolist()
        force: dict[Side, float] = {"left": left, "right": right}
        goal = None if hold else _goal(targets)
        self._bracing.update(targets, self._contact.forces, self.arms.sides, walker.stance[:2], walker.ground)
        lean = self._bracing.lean
        walker.update(
            goal, dcm - lean, self._zmp, dynamics.soles, footings=dynamics.footings, foot_force=force, stays=hold
        )
        load = stabilizer.update(
            com=dynamics.com,
            dcm=dcm,
            dcm_reference=walker.dcm_reference,
            zmp_reference=walker.zmp_reference,
            lean=lean,
            momentum_rate=self.kinematics.momentum_rate,
            soles=dynamics.soles,
            contact=walker.contact,
        )
        self._zmp = load.zmp
        self.lunge.update(walker.missed, walker.gait is Gait.STEP)
        self._tilt.update(walker.swing, estimate.qpos[:BASE_COORDINATES], self.kinematics.base_pose)
        self.arms.update(estimate.qpos, self._contact, targets)
        hold = hold or not self.kinematics.solved
        if not hold:
            targets = self._rearranged(targets)
        self._ease()
        tilt = self.lunge.tilts(walker.stance.item(2))
        self.kinematics.step(self._body_targets(targets, hold, tilt))
        position = self.kinematics.joints.copy()
        velocity = self.kinematics.velocity[BASE_DOFS:]
        upright = tilt[0], tilt[1] + self._lean.base
        torque = self._feedforward.torques(load, self.kinematics.acceleration, position, velocity, upright)
        self.arms.carry(torque)
        share = self.arms.stiffness
        return Setpoint(position, velocity, torque, None if share is None else self._robot.stiffness * share)

    def _body_targets(
        self, targets: Mapping[str, Target], hold: bool, tilt: tuple[float, float, float, float]
    ) -> BodyTargets:
        walker = self.walker
        stance = walker.stance
        heading = stance.item(2)
        hands, palms = self._hand_goals(targets, hold)
        gaze = targets.get("gaze")
        point = gaze.point if isinstance(gaze, GazeTarget) else None
        eyes, base = self.dynamics.gaze_position, self.dynamics.base_position
        self._gaze.update(point, hold, eyes, heading, axis=eyes if self._robot.config.neck else base)
        self._lean.update(point, hold, eyes, base, heading)
        standing = walker.gait is Gait.STAND  # the body of a robot that walks is not given to its hands
        if not hold:
            self._reaching = _blend(self._reaching, float(standing and bool(hands)), self._dt)
            posture = targets.get("posture")
            wanted = posture.height if isinstance(posture, PostureTarget) else 0.0
            self._height = approach(self._height, wanted, self._robot.config.whole_body.height_speed * self._dt)
            self._hold_arms(targets)
        self.arms.keep(self._posture.joints, self._home_joints, hold)
        held = [side for side, arm in self._arms.items() if arm.joints]
        busy = {*hands, *held, *self.arms.sides, *self.arms.homeward}
        self._arm_swing.update(stance, walker.foot_reference, busy)
        x, y = self._stabilizer.com_reference.tolist()
        wanted = walker.ground + self._home_height + self._height - self._lean.crouch
        measured, steps = self.dynamics.com.item(2), walker.gait is Gait.STEP
        stride = 0.0 if busy else walker.stride  # stretched legs and an arm that pulls at it would make it hop
        height = self._com_height.update(wanted, measured, steps=steps, stride=stride)
        return BodyTargets(
            com=np.array((x, y, height)),
            soles=walker.foot_reference,
            sole_footings=walker.foot_footing,
            sole_corrections=self._tilt.correction,
            heading=heading,
            torso_yaw=self._gaze.torso_yaw,
            lean=(self._lean.base, self._lean.torso),
            gaze=(self._gaze.yaw, self._gaze.pitch),
            hands=hands,
            reaching=self._reaching,
            posture=self._posture.joints + self._arm_swing.joints,
            palms=palms,
            arms=self._held_joints,
            firmness=self._firmness if hands and not standing else _NOT_FIRM,
            swings=walker.swing.side if walker.swing else None,
            tilt=tilt,
        )

    def _rearranged(self, targets: Mapping[str, Target]) -> Mapping[str, Target]:
        """Return the targets, but for arms that are stuck: those go to other angles first."""
        standing = self.walker.gait is Gait.STAND
        found = targets
        for side, rearranging in self._rearranging.items():
            target = targets.get(f"{side}_hand") if standing and side not in self.arms.sides else None
            if (arm := rearranging.update(target, self._upright)) is not None:
                found = {**found, f"{side}_hand": arm}
                if self._asked.get(side) is None:
                    self._eased = 0.0  # the body that the hand had pulled at comes back, and must not jerk
            self._asked[side] = arm
        return found

    def _ease(self) -> None:
        """Let the body come back to its speed, at once if it steps, and be quicker than that while it lunges."""
        if self._eased < 1.0 or self._lunged != self.lunge.active:
            standing = self.walker.gait is Gait.STAND
            self._eased = min(1.0, self._eased + self._dt / _EASE_TIME) if standing else 1.0
            self._lunged = self.lunge.active
            self.kinematics.ease(self._eased, lunges=self._lunged)

    def _upright(self) -> Array:
        """Return the planned configuration with all but the arms as if no hand bent the body: shape (7 + nj,)."""
        joints, arms = self._home_joints.copy(), [joint for side in SIDES for joint in self._robot.arm_joints(side)]
        joints[arms] = self.kinematics.joints[arms]
        x, y, yaw = ahead(self.walker.stance, *self._home_base[:2].tolist()).tolist()
        return np.concatenate([planar_pose(x, y, float(self._home_base[2]), yaw), joints])

    def _hand_goals(
        self, targets: Mapping[str, Target], hold: bool
    ) -> tuple[dict[Side, Array], dict[Side, HandTarget]]:
        """Return the places of the hands that are commanded, and the goals of those that are more than a place."""
        positions, palms = self._palms.update(targets, hold, self.walker.stance, self.walker.gait is not Gait.STAND)
        commanded = frozenset(positions)
        if self._commanded - commanded:
            self._posture.release_from(self.kinematics.joints)
        if self._commanded and not commanded:
            sunk = self.walker.ground + self._home_height - self._lean.crouch
            self._height = self.kinematics.com_height - sunk  # it rises from there, slowly
        self._commanded = commanded
        return positions, palms

    def _hold_arms(self, targets: Mapping[str, Target]) -> None:
        """Move the posture: home, and the joints of arms that are commanded to where they are to be."""
        self._posture.update()
        held: list[int] = []
        for side, arm in self._arms.items():
            target = targets.get(f"{side}_hand")
            asked = target if isinstance(target, ArmTarget) and side not in self.arms.sides else None
            if arm.joints or asked is not None:
                arm.update(asked, self.kinematics.joints)
                self._posture.hold(arm.joints, arm.angles)
                held += arm.joints
        self._held_joints = tuple(held)

    @property
    def com_speed(self) -> float:
        """Horizontal speed of the centre of mass [m/s]."""
        return math.hypot(*self.dynamics.com_velocity[:2].tolist())


def _blend(value: float, goal: float, dt: float) -> float:
    """Return a share moved toward its goal, which it reaches in the end."""
    after = value + (goal - value) * min(1.0, dt / (_GIVE_TIME if goal > value else _TAKE_BACK_TIME))
    return goal if abs(goal - after) < _BLENDED else after


def _goal(targets: Mapping[str, Target]) -> Array | None:
    base = targets.get("base")
    if not isinstance(base, BaseTarget):
        return None
    goal = np.empty(3)
    goal[:2], goal[2] = base.position, base.heading
    return goal
