"""The learned body, ``policy``: a network walks and balances, inverse kinematics moves hands and gaze on top.

What the two know of each other is little: the network is told that the joints it lends are at rest in the default pose,
and it gets velocity commands for the base. To hold is the command zero: the network goes on balancing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from humanoid_bt.control.body.body import Footstep, Setpoint
from humanoid_bt.control.body.hand_goals import HandGoals
from humanoid_bt.control.body.planar import middle, wrap
from humanoid_bt.control.body.policy.lending import VIEW, WAIST, Lending
from humanoid_bt.control.body.policy.upper_body import UpperBody
from humanoid_bt.control.body.policy.velocity import VelocityReference
from humanoid_bt.control.body.policy.walker import LearnedWalker
from humanoid_bt.control.body.references import ArmReference, GazeReference, PostureReference
from humanoid_bt.control.body.yielding import Felt, YieldingArms
from humanoid_bt.control.dynamics import RobotDynamics
from humanoid_bt.core.clock import ESTIMATE_PERIOD
from humanoid_bt.core.compiled import compiled
from humanoid_bt.core.messages import (
    SIDES,
    ArmTarget,
    Array,
    BaseTarget,
    Estimate,
    Gait,
    GazeTarget,
    HandTarget,
    Side,
    Target,
)
from humanoid_bt.robot.model import BASE_COORDINATES, BASE_DOFS, RobotModel
from humanoid_bt.robot.policy.policy import Indices, Policy

_SWAY_TIME = 0.3  # s over which the motion of the centre of mass is averaged: balancing sways and goes nowhere
_ASIDE = 0.6  # rad beside the view up to which no trunk turns for what is to be looked at
_NOTHING: Array = np.zeros(3)
_NONE: Indices = np.zeros(0, dtype=np.intp)


class LearnedBody:
    """A learned walker, and the hands and the gaze of its robot.

    Args:
        robot: the robot.
        policy: its walker.
        dynamics: as it is estimated, always up to date.
        contact: what touches it, likewise.
        waits: whether time stands still while the network computes.

    Attributes:
        dynamics: as it is estimated, always up to date.
        walker: the network at work.
        velocity: what the network is commanded.
        kinematics: the planned motion of what is lent.
        arms: which of its arms yield to what pushes them.
        lending: which joints are lent.
    """

    period = ESTIMATE_PERIOD  # what the network says is taken so soon after it was asked

    def __init__(
        self, robot: RobotModel, policy: Policy, dynamics: RobotDynamics, contact: Felt, *, waits: bool
    ) -> None:
        config, dt = robot.config, self.period
        self._robot, self._dt = robot, dt
        self.dynamics = dynamics
        names = robot.joint_names
        self._known: Indices = np.array([names.index(name) for name in policy.joints])
        self._moved = self._known[policy.moves]
        self._policy = policy
        self.walker = LearnedWalker(policy, self._known, waits=waits)
        self.velocity = VelocityReference(policy, self.walker.period)
        self.lending = Lending(robot, policy, dt)
        self.kinematics = UpperBody(robot, self.lending.groups[WAIST], dt)
        self.arms = YieldingArms(robot, dynamics, self.kinematics, dt)
        self._palms = HandGoals(robot, dynamics, self.kinematics, contact=contact, arms=self.arms, dt=dt)
        self._contact = contact
        self._bias = dynamics.bias[BASE_DOFS:]
        self._home: Array = robot.home_qpos[BASE_COORDINATES:].copy()
        self._posture = PostureReference(self._home, dt)
        self._held = {side: ArmReference(names, config.whole_body, dt) for side in _sides(robot)}
        self._lendable = frozenset(("gaze", *(f"{side}_hand" for side in self._held)))
        lent = self.lending.groups
        self._lent_wholly = {side for side in self._held if lent[f"{side}_hand"] == robot.arm_joints(side)}
        neck_range = 0.0
        if config.neck:
            yaw = robot.joint(config.neck.yaw)
            neck_range = float(min(robot.upper[yaw], -robot.lower[yaw]))
        self._gaze = GazeReference(config.whole_body, dt, neck_range)
        self._stiffness, self._damping = robot.stiffness.copy(), robot.damping.copy()
        self._stiffness[self._moved], self._damping[self._moved] = policy.stiffness, policy.damping
        self._sway = 0.0, 0.0  # m/s
        self._followed: Array | None = None  # targets of the network, of which the next one is
        self._own: Setpoint
        self._gains_with: Array | None = None  # shares of limbs, of which the next ones are
        self._blended = self._stiffness, self._damping
        self._next = 0  # control periods until the network is asked
        self._stance: Array = np.zeros(3)

    def reset(self, estimate: Estimate) -> None:
        """Begin a run: the robot stands at rest."""
        self.restart(estimate)

    def restart(self, estimate: Estimate) -> None:
        """Go on from where the robot is, with everything at rest, and nothing lent."""
        joints = estimate.qpos[BASE_COORDINATES:]
        self.walker.reset()
        self.velocity.reset()
        self.kinematics.reset(joints)
        self.lending.reset()
        self.arms.reset()
        self._palms.reset()
        self._posture = PostureReference(self._home, self._dt)
        self._posture.release_from(joints)
        for arm in self._held.values():
            arm.update(None, joints)
        self._gaze.yaw = self._gaze.pitch = 0.0
        x, y, _ = self.dynamics.com_velocity.tolist()
        self._sway = x, y
        self._next = 0
        self._stance = self._seen_stance()

    # ---- what it is doing ------------------------------------------------------------------------------------------

    @property
    def gait(self) -> Gait:
        """What the legs do, as far as the command and the motion tell."""
        return self.velocity.gait

    @property
    def still_for(self) -> float:
        """How long it stands already [s]; 0 while it steps."""
        return self.velocity.still_for

    @property
    def stance(self) -> Array:
        """Middle between the feet and its heading, shape (3,): x, y [m], yaw [rad], world frame."""
        return self._stance

    @property
    def footsteps(self) -> tuple[Footstep, ...]:
        """None: a learned walker plans none that anybody knows of."""
        return ()

    @property
    def com_speed(self) -> float:
        """Horizontal speed of the centre of mass [m/s], without sway."""
        return math.hypot(*self._sway)

    @property
    def com_error(self) -> Array:
        """Zero, shape (3,): nobody plans the centre of mass."""
        return _NOTHING

    def hand_error(self, side: Side) -> float | None:
        """How far a planned palm is from where it is to go [m]; None if nothing commands it."""
        return self.kinematics.hand_error(side)

    @property
    def hand_obstacles(self) -> Mapping[Side, str]:
        """The own link that keeps a commanded palm from its target, of those that one keeps."""
        return self.kinematics.hand_obstacles

    @property
    def fault(self) -> str:
        """Why the last setpoint is not what it should be, "" if it is."""
        if self.walker.fault:
            return self.walker.fault
        return "" if self.kinematics.solved else "inverse kinematics without a solution"

    @property
    def failure(self) -> str:
        """Why this body cannot go on, "" while it can."""
        return self.walker.failure

    # ---- every control period --------------------------------------------------------------------------------------

    def update(self, estimate: Estimate, targets: Mapping[str, Target], hold: bool) -> Setpoint:
        """Return the setpoints of this control period.

        Args:
            estimate: the robot, as it is believed to be; its dynamics are up to date with it.
            targets: resource -> target; what is missing comes to rest.
            hold: stand by the command zero, and keep hands and gaze where they are relative to the stance.
        """
        self._stance = self._seen_stance()
        (x, y), (vx, vy, _), share = self._sway, self.dynamics.com_velocity.tolist(), self._dt / _SWAY_TIME
        self._sway = x + (vx - x) * share, y + (vy - y) * share
        self.velocity.note(self.com_speed, self._dt)
        hold_hands = hold or not self.kinematics.solved
        self.arms.update(estimate.qpos, self._contact, targets)
        self.arms.homeward &= self._lent_wholly  # the walker brings others home by itself
        base = None if hold else targets.get("base")
        self._lend(estimate, targets, hold_hands, base)
        self._plan(estimate, targets, hold_hands)
        if self.walker.take():
            self._tell_what_was_done()
        if self._next == 0:
            self._ask(estimate, base)
            self._next = self._policy.period
        self._next -= 1
        return self._setpoint()

    def _ask(self, estimate: Estimate, base: Target | None) -> None:
        velocity, (vx, vy, _), yaw = self.velocity, self.dynamics.com_velocity.tolist(), -self._stance.item(2)
        sways = math.sin(yaw) * vx + math.cos(yaw) * vy  # to the left
        command = velocity.update(_place(base), self._stance, sways)
        masked = _NONE
        if len(self.lending.joints) and self._policy.config.lend.observe == "default":
            masked = np.flatnonzero(self.lending.limbs[self._known] > 0)
        self.walker.ask(estimate, command, velocity.stands, masked)

    def _tell_what_was_done(self) -> None:
        if self._policy.config.lend.last_action == "executed" and self.lending.busy:
            share = self.lending.share
            executed = np.flatnonzero(share[self._moved] > 0)
            self.walker.executed(executed, self._together(share)[self._moved[executed]])

    def _lend(self, estimate: Estimate, targets: Mapping[str, Target], hold: bool, base: Target | None) -> None:
        lending, arms = self.lending, self.arms
        if not (lending.busy or arms.sides or arms.homeward) and self._lendable.isdisjoint(targets):
            return
        wanted = {
            f"{side}_hand": f"{side}_hand" in targets
            or side in arms.sides
            or side in arms.homeward
            or (hold and lending.lends(f"{side}_hand"))
            for side in self._held
        }
        wanted["gaze"] = "gaze" in targets or (hold and lending.lends("gaze"))
        reaches = any(isinstance(targets.get(f"{side}_hand"), HandTarget) for side in self._held)
        if reaches or (hold and lending.lends(WAIST)):
            goal = _place(base)
            walks = goal is not None and self.velocity.goes(goal, self._stance)
            wanted[WAIST] = self.gait is Gait.STAND and self.velocity.stands and not walks
        else:
            wanted[VIEW] = wanted["gaze"] and not self._robot.config.neck
        planned, share = self.kinematics.joints, lending.share
        if fresh := lending.update(wanted, planned - self._home):  # they begin where they are, or are on their way
            measured = estimate.qpos[BASE_COORDINATES:]
            planned[fresh] = np.where(share > 0, self._together(share), measured)[fresh]
            self._posture.joints[fresh] = planned[fresh]

    def _plan(self, estimate: Estimate, targets: Mapping[str, Target], hold: bool) -> None:
        lending, lent, weights = self.lending, self.lending.joints, self._robot.config.whole_body
        if not lending.busy and not len(lent):
            return
        self.kinematics.see(estimate.qpos, lent)
        hands, palms = self._palms.update(targets, hold, self._stance, self.gait is not Gait.STAND)
        costs: Array = np.full(len(self._home), weights.posture)
        if not hold:
            self._posture.update()
            self._hold_arms(targets)
        for arm in self._held.values():
            if arm.joints:
                costs[arm.joints] = weights.arm
        self.arms.keep(self._posture.joints, self._home, hold)
        view = self._view(targets, hold, bool(hands))
        posture = self._posture.joints
        self.kinematics.step(lending.free, lending.kept, hands, palms, posture=posture, costs=costs, view=view)

    def _view(self, targets: Mapping[str, Target], hold: bool, hands: bool) -> tuple[float, float] | None:
        """Return where the view is to go, world frame [rad]; None if nothing that is lent turns it for that."""
        gaze, heading = targets.get("gaze"), float(self._stance[2])
        point = gaze.point if isinstance(gaze, GazeTarget) else None
        eyes = self.dynamics.gaze_position
        axis = eyes if self._robot.config.neck else self.dynamics.base_position
        self._gaze.update(point, hold, eyes, heading, axis=axis)
        config, yaw, pitch = self._robot.config, wrap(heading + self._gaze.yaw), self._gaze.pitch
        if not config.neck:  # the trunk turns and bends no farther than it must for the point to be in view
            now_yaw, now_pitch = self.kinematics.view if hands else (heading, 0.0)  # hands turn and bend it, too
            yaw += min(max(wrap(now_yaw - yaw), -_ASIDE), _ASIDE)
            pitch = max(config.gaze.down, pitch - config.whole_body.gaze_below, now_pitch)
        turned_by = ("gaze",) if config.neck else (WAIST, VIEW)
        if not any(map(self.lending.lends, turned_by)) or ("gaze" not in targets and not hold):
            return None
        return yaw, pitch

    def _hold_arms(self, targets: Mapping[str, Target]) -> None:
        for side, arm in self._held.items():
            target = targets.get(f"{side}_hand")
            asked = target if isinstance(target, ArmTarget) and side not in self.arms.sides else None
            if arm.joints or asked is not None:
                arm.update(asked, self.kinematics.joints)
                self._posture.hold(arm.joints, arm.angles)

    def _setpoint(self) -> Setpoint:
        """Return what the network and inverse kinematics make together."""
        lent, share = len(self.lending.joints), self.lending.share
        if not lent and self.arms.stiffness is None:
            return self._networks_own()
        velocity, torque = np.empty((2, len(share)))
        _lent_share(velocity, torque, share, self.kinematics.velocity, self._bias)
        if lent:
            self.arms.carry(torque)
        return Setpoint(self._together(share), velocity, torque, *self._gains())

    def _networks_own(self) -> Setpoint:
        """Return what the network makes alone: the same one until it has new targets."""
        if self._followed is not self.walker.targets:
            self._followed = self.walker.targets
            position, rest = self._together(self.lending.share), np.zeros(len(self._home))
            self._own = Setpoint(position, rest, rest, self._stiffness, self._damping)
        return self._own

    def _together(self, share: Array) -> Array:
        """Return the angles that network and inverse kinematics make together, shape (nj,) [rad].

        Args:
            share: how far each joint is lent, shape (nj,).
        """
        position: Array = np.empty(len(share))
        _join(position, self.walker.targets, self._moved, self._home, share, self.kinematics.joints)
        return position

    def _gains(self) -> tuple[Array, Array]:
        """Return stiffness and damping: the policy's, and of lent arms and neck those of ``robot.yaml``."""
        if self._gains_with is not self.lending.limbs:  # which is another one as soon as more or less is lent
            self._gains_with = share = self.lending.limbs
            stiffness = self._stiffness + share * (self._robot.stiffness - self._stiffness)
            self._blended = stiffness, self._damping + share * (self._robot.damping - self._damping)
        stiffness, damping = self._blended
        if self.arms.stiffness is not None:
            stiffness = stiffness * self.arms.stiffness
        return stiffness, damping

    def _seen_stance(self) -> Array:
        return middle(self.dynamics.soles["left"], self.dynamics.soles["right"])


def _sides(robot: RobotModel) -> list[Side]:
    """Return the sides on which a robot has a hand."""
    return [side for side in SIDES if side in robot.config.hands]


def _place(base: Target | None) -> Array | None:
    """Return where a target of the base is, and the heading there, shape (3,); None if it is none."""
    if not isinstance(base, BaseTarget):
        return None
    x, y = base.position.tolist()
    return np.array((x, y, base.heading), dtype=float)


@compiled("void(f8[::1], f8[::1], i8[::1], f8[::1], f8[::1], f8[::1])")
def _join(position: Array, targets: Array, moved: Indices, home: Array, share: Array, planned: Array) -> None:
    """Write the angles that network and inverse kinematics make together.

    Args:
        position: is written, shape (nj,) [rad].
        targets, moved: of the network, shape (m,) [rad], and of which joints.
        home: where the others are, shape (nj,) [rad].
        share: how far each joint is lent, shape (nj,).
        planned: where it is then, shape (nj,) [rad].
    """
    position[:] = home
    for i in range(len(moved)):
        position[moved[i]] = targets[i]
    for joint in range(len(position)):
        position[joint] += share[joint] * (planned[joint] - position[joint])


@compiled("void(f8[::1], f8[::1], f8[::1], f8[::1], f8[::1])")
def _lent_share(velocity: Array, torque: Array, share: Array, speed: Array, bias: Array) -> None:
    """Write the share of speeds and torques, of joints that are lent, and zeros for the others, each of shape (nj,)."""
    for joint in range(len(share)):
        lent = share[joint] > 0
        velocity[joint] = share[joint] * speed[joint] if lent else 0.0
        torque[joint] = share[joint] * bias[joint] if lent else 0.0
