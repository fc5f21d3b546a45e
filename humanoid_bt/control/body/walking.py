"""The gait: stand, step, settle; which foot carries, where the feet's references are, what DCM is wanted."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from humanoid_bt.control.body.body import Footstep
from humanoid_bt.control.body.catching import Catching
from humanoid_bt.control.body.dcm import DcmPlan, plan_settle, plan_walk
from humanoid_bt.control.body.footsteps import OTHER, FootstepPlanner
from humanoid_bt.control.body.planar import middle, put_between, seen_from, wrap
from humanoid_bt.control.body.swing import Swing
from humanoid_bt.core.compiled import compiled, inlined
from humanoid_bt.core.messages import SIDES, Array, Gait, Side
from humanoid_bt.robot.config import GaitConfig, SoleConfig

_FOLLOW_TIME = 0.08  # s, a standing foot's reference follows the measured foot
_LEVEL_TIME = 0.3  # s, its tilt does so: a slope stays, a foot that tips over its edge does not
_LANDS_AT = 0.05  # rad that a foot is pitched at most when it has landed: its heel is down before it
_ROLL_TIME = 0.05  # s in which a foot that has landed on its heel lies flat
_GROUND_TIME = 0.15  # s in which the body follows the ground
_STEEPEST = 0.2  # rad
_SINK_SPEED = 0.4  # m/s at which a foot is lowered that has not found the ground where it was to be
_ELSEWHERE = 0.05  # m from where it was planned, of a foothold that caught a push
_CAUGHT_SHIFT = 0.03  # s of weight shift after it: the DCM runs on
_WAIT_FROM = 0.02  # m that the DCM is too near to the foot that is to swing
_WAIT_MOST = 0.3  # s
_ASTRAY, _TURNED = 0.05, 0.3  # m and rad that a foot may have slipped from its place beside the other one
_CALM, _CALM_FOR = 0.02, 1.0  # m of the DCM from the middle, and s of standing, before it is put there again

_NOTHING: Array = np.zeros(2)  # that a step misses while there is none


class Walker:
    """Walks to a goal and stands there.

    Args:
        gait, sole: the robot's numbers.
        dt: control period [s].

    Attributes:
        gait: what the legs do.
        contact: whether each foot is meant to be on the ground.
        foot_reference: poses of the soles (x, y, yaw), world frame; those of feet on the ground move in place.
        foot_footing: height of each sole, and its tilt about the world's x and y, shape (3,) [m, rad]; likewise.
        stance: pose of the middle between the references of the feet, shape (3,), world frame.
        zmp_reference, dcm_reference: shape (2,), world frame [m].
        swing: the swing that is going on, if any.
        footsteps: planned footholds, the next first.
        ground: height of what carries the robot [m].
        stride: how much of the longest step straight ahead it makes, in [0, 1]: as the last swing.
        still_for: how long it has been standing [s].
    """

    def __init__(self, gait: GaitConfig, sole: SoleConfig, dt: float) -> None:
        self._numbers, self._sole, self._dt = gait, sole, dt
        self._planner = FootstepPlanner(gait, sole)
        self._catching = Catching(gait, sole)
        self._single, self._settled = round(gait.single_support / dt), round(gait.last_shift / dt)
        self._omega = 1.0
        self.gait = Gait.STAND
        self.foot_reference: dict[Side, Array] = {}
        self.foot_footing: dict[Side, Array] = {}
        self.stance: Array = np.zeros(3)
        self.contact: dict[Side, bool] = dict.fromkeys(SIDES, True)
        self.zmp_reference: Array = np.zeros(2)
        self.dcm_reference: Array = np.zeros(2)
        self.swing: Swing | None = None
        self.footsteps: list[Footstep] = []
        self.ground = 0.0
        self.stride = 0.0
        self.still_for = 0.0
        self._plan: DcmPlan | None = None
        self._elapsed = 0.0  # control periods in the plan; not whole when a step hurries
        self._double = 0  # control periods of weight shift before the swing
        self._stepping: Side = "left"
        self._waited = 0.0  # s for the weight to leave the foot that is to swing
        self._ends = False  # whether the walk ends with this step
        self._stood_at = 0.0  # rad, heading of the foot that carries the robot, when the other one was lifted
        self._rolled = _flat()  # of each foot's footing, what is left of its roll
        self._found = dict.fromkeys(SIDES, True)  # whether each foot has been loaded since it landed

    def reset(self, soles: Mapping[Side, Array], footings: Mapping[Side, Array], omega: float) -> None:
        """Stand where the feet are."""
        self._omega = omega
        self._planner.reset()
        self.foot_reference = {side: soles[side].copy() for side in SIDES}
        self.foot_footing = {side: footings[side].copy() for side in SIDES}
        self._rolled = _flat()
        self.contact = dict.fromkeys(SIDES, True)
        self.ground = (self.foot_footing["left"].item(0) + self.foot_footing["right"].item(0)) / 2
        self.stance = self._middle()
        self.gait, self.swing, self.footsteps, self._plan = Gait.STAND, None, [], None
        self.zmp_reference = self.dcm_reference = self.stance[:2].copy()
        self.stride = self.still_for = 0.0

    def go_on(self, lifted: Side, dcm: Array) -> None:
        """Finish a step that something else has begun, toward where the robot is moving; call it after :meth:`reset`.

        Args:
            lifted: the foot that is in the air.
            dcm: measured, shape (2,) [m].
        """
        support = self.foot_reference[OTHER[lifted]]
        goal = np.array([*dcm, self._planner.stance_beside(OTHER[lifted], support).item(2)])
        self._start_step(lifted, goal, support[:2], 0.0)
        self.swing, self._stood_at = self._lift_off(lifted), support.item(2)

    @property
    def missed(self) -> Array:
        """From where the DCM should be when the foot lands that swings to where it will be, shape (2,), world [m]."""
        return _NOTHING if self.swing is None else self.swing.missed

    def _middle(self) -> Array:
        return middle(self.foot_reference["left"], self.foot_reference["right"])

    def update(
        self,
        goal: Array | None,
        dcm: Array,
        zmp: Array,
        soles: Mapping[Side, Array],
        *,
        footings: Mapping[Side, Array],
        foot_force: Mapping[Side, float],
        stays: bool = False,
    ) -> None:
        """Go on for one control period.

        Args:
            goal: pose (x, y, yaw) to stand at, world frame; None to stop after the step.
            dcm: measured, shape (2,) [m].
            zmp: that the feet were last asked for, shape (2,) [m].
            soles: measured poses, shape (3,).
            footings: measured heights and tilts, shape (3,), as in ``foot_footing``.
            foot_force: measured normal forces [N].
            stays: whether it makes no step that it need not make, and comes to stand on flat feet.
        """
        self.contact = dict.fromkeys(SIDES, True)
        self.still_for = self.still_for + self._dt if self.gait is Gait.STAND else 0.0
        if self.gait is Gait.STAND:
            self.zmp_reference = self.dcm_reference = self.stance[:2]
            if goal is not None and self._planner.must_walk(self.stance, goal):
                swing = self._planner.first_swing(self.stance, goal)
                self._start_step(swing, goal, self.zmp_reference, self._numbers.first_shift, begins=self.dcm_reference)
            elif not stays:
                self._tidy(dcm)
        elif self.gait is Gait.SETTLE:
            self._settle()
        if self.gait is not Gait.STEP:
            self._catch(dcm, zmp, soles, foot_force)
        if self.gait is Gait.STEP:
            self._step(goal, dcm, soles, foot_force, stops=stays)
        self._follow_ground(soles, footings, foot_force)

    def _start_step(
        self,
        swing: Side,
        goal: Array | None,
        zmp: Array,
        shift: float,
        *,
        in_place: bool = False,
        begins: Array | None = None,
    ) -> None:
        support = self.foot_reference[OTHER[swing]]
        if in_place:
            self.footsteps, done = self._planner.in_place(swing, support), False
        else:
            self.footsteps, done = self._planner.plan(swing, support, goal)
        self._ends = done and len(self.footsteps) == 1
        self._double = round(shift / self._dt)
        self._plan = plan_walk(
            self._numbers,
            self._omega,
            self._dt,
            zmp=zmp,
            support=support,
            shift=shift,
            steps=self.footsteps,
            begins=begins,
        )
        self._elapsed, self._stepping, self.swing = 0.0, swing, None
        self._waited = 0.0
        self.gait = Gait.STEP

    def _step(
        self,
        goal: Array | None,
        dcm: Array,
        soles: Mapping[Side, Array],
        foot_force: Mapping[Side, float],
        *,
        stops: bool,
    ) -> None:
        assert self._plan is not None
        now = int(self._elapsed)
        self.zmp_reference, self.dcm_reference = self._plan.zmp[now], self._plan.dcm[now]
        side, landed, rate = self._stepping, False, 1.0
        if now >= self._double and self.swing is None and self._waited < _WAIT_MOST and self._must_wait(dcm, soles):
            self._waited += self._dt
            self.zmp_reference = self.dcm_reference  # the DCM's reference stays
            return
        if now >= self._double:
            self.contact[side] = False
            if self.swing is None:
                self.swing = self._lift_off(side)
                self._stood_at = soles[OTHER[side]].item(2)
            self.swing.update(self._elapsed - self._double, dcm, self.zmp_reference, stops=stops)
            self.foot_reference[side], self.foot_footing[side] = self.swing.pose, self.swing.footing
            rate, self.stride = self.swing.rate, self.swing.stride
            share = (self._elapsed - self._double) / self._single
            touches = share > self._numbers.touchdown_after and foot_force[side] > self._numbers.touchdown_force
            landed = touches and math.hypot(*self.swing.rolled[1:].tolist()) < _LANDS_AT
        self._elapsed += rate
        if landed:
            self.contact[side] = True
        if landed or self._elapsed >= self._double + self._single:
            self._planner.stood(wrap(soles[OTHER[side]].item(2) - self._stood_at))
            self._touch_down(side, goal)

    def _must_wait(self, dcm: Array, soles: Mapping[Side, Array]) -> bool:
        """Return whether the foot that is to swing is still needed to bring the DCM to the other one."""
        swing, support = soles[self._stepping], soles[OTHER[self._stepping]]
        back = swing[:2] - support[:2]
        behind = float((dcm - self.dcm_reference) @ back) / math.hypot(*back.tolist())
        return behind > _WAIT_FROM and self._catching.holds(dcm, soles)

    def _lift_off(self, side: Side) -> Swing:
        assert self._plan is not None
        return Swing(
            self._numbers,
            self._sole,
            self._omega,
            self._dt,
            side=side,
            start=self.foot_reference[side],
            foothold=self.footsteps[0].pose,
            support=self.foot_reference[OTHER[side]],
            footings=(self.foot_footing[side], self.foot_footing[OTHER[side]]),
            dcm_end=self._plan.dcm[self._double + self._single - 1],
        )

    def _touch_down(self, side: Side, goal: Array | None) -> None:
        assert self.swing is not None
        elsewhere = math.dist(self.swing.target[:2], self.footsteps[0].pose[:2]) > _ELSEWHERE
        self.foot_reference[side] = np.array([*self.swing.pose[:2], self.swing.target[2]])
        self._rolled[side] = self.swing.rolled
        self.swing, self._found[side] = None, False
        if elsewhere or not self._ends:
            early = max(0.0, self._double + self._single - self._elapsed) * self._dt  # the DCM is where it is
            shift = _CAUGHT_SHIFT if elsewhere else self._numbers.double_support + early
            self._start_step(OTHER[side], goal, self.zmp_reference, shift, in_place=elsewhere)
            return
        middle = self._middle()[:2]
        self._plan = plan_settle(self._numbers, self._omega, self._dt, zmp=self.zmp_reference, middle=middle)
        self.gait, self._elapsed, self.footsteps, self.stride = Gait.SETTLE, 0.0, [], 0.0

    def _settle(self) -> None:
        assert self._plan is not None
        now = int(self._elapsed)
        self.zmp_reference, self.dcm_reference = self._plan.zmp[now], self._plan.dcm[now]
        self._elapsed += 1
        if self._elapsed >= self._settled:
            self.gait, self._plan = Gait.STAND, None

    def _catch(self, dcm: Array, zmp: Array, soles: Mapping[Side, Array], foot_force: Mapping[Side, float]) -> None:
        """Step when a push moves the DCM of a robot on both feet to where they cannot stop it."""
        step = self._catching.step(dcm, soles, foot_force, self._omega)
        if step is not None:
            side, shift = step
            self._start_step(side, None, zmp, shift, in_place=True)

    def _tidy(self, dcm: Array) -> None:
        """Put a foot beside the other one again: quick hands turn the body, and feet slip little by little."""
        if self.still_for < _CALM_FOR:
            return
        ahead, aside = seen_from(self.stance, dcm).tolist()
        if math.hypot(ahead, aside) > _CALM:
            return
        swing: Side = "left" if aside < 0 else "right"  # the one that carries less
        foot, support = self.foot_reference[swing], self.foot_reference[OTHER[swing]]
        place = self._planner.foothold(swing, self._planner.stance_beside(OTHER[swing], support))
        astray = math.dist(foot[:2].tolist(), place[:2].tolist()) > _ASTRAY
        if astray or abs(wrap(foot.item(2) - place.item(2))) > _TURNED:
            self._start_step(swing, None, self.zmp_reference, self._numbers.first_shift, begins=self.dcm_reference)

    def _follow_ground(
        self, soles: Mapping[Side, Array], footings: Mapping[Side, Array], foot_force: Mapping[Side, float]
    ) -> None:
        """Let references of standing feet follow the measured feet: a jump in contact would be an impact."""
        least, contact, found = self._numbers.touchdown_force, self.contact, self._found
        loaded_left, loaded_right = foot_force["left"] > least, foot_force["right"] > least
        found["left"] = found["left"] or (contact["left"] and loaded_left)
        found["right"] = found["right"] or (contact["right"] and loaded_right)
        poses, footing, rolled, self.stance = self.foot_reference, self.foot_footing, self._rolled, np.empty(3)
        self.ground = _follow_ground(
            self.stance, poses["left"], footing["left"], rolled["left"], soles["left"], footings["left"],
            contact["left"], loaded_left, found["left"], poses["right"], footing["right"], rolled["right"],
            soles["right"], footings["right"], contact["right"], loaded_right, found["right"], self.ground, self._dt,
        )  # fmt: skip


@inlined
def _follow(
    pose: Array,
    footing: Array,
    rolled: Array,
    sole: Array,
    measured: Array,
    loaded: bool,
    found: bool,
    dt: float,
) -> None:
    """Let the references of a foot on the ground follow the foot: see :func:`_follow_ground`."""
    follow, flatten, level = min(1.0, dt / _FOLLOW_TIME), min(1.0, dt / _ROLL_TIME), dt / _LEVEL_TIME
    pose[0] += follow * (sole[0] - pose[0])
    pose[1] += follow * (sole[1] - pose[1])
    pose[2] += follow * ((sole[2] - pose[2] + math.pi) % (2 * math.pi) - math.pi)
    for i in range(3):
        flatter = flatten * rolled[i]
        rolled[i] -= flatter
        footing[i] -= flatter
    if loaded:
        footing[0] += follow * (measured[0] - footing[0])
        for i in range(1, 3):
            footing[i] = min(max(footing[i] + level * (measured[i] - footing[i]), -_STEEPEST), _STEEPEST)
    elif not found:
        footing[0] -= _SINK_SPEED * dt


@compiled(
    "f8(f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], b1, b1, b1, f8[::1], f8[::1], f8[::1], f8[::1], f8[::1],"
    " b1, b1, b1, f8, f8)"
)
def _follow_ground(
    stance: Array,
    left: Array,
    left_footing: Array,
    left_rolled: Array,
    left_sole: Array,
    left_measured: Array,
    left_stands: bool,
    left_loaded: bool,
    left_found: bool,
    right: Array,
    right_footing: Array,
    right_rolled: Array,
    right_sole: Array,
    right_measured: Array,
    right_stands: bool,
    right_loaded: bool,
    right_found: bool,
    ground: float,
    dt: float,
) -> float:
    """Let the references of the feet on the ground follow the feet; return the height of the ground after it [m].

    Args:
        stance: is written: the pose of the middle between the references, shape (3,).
        left, left_footing, right, right_footing: the references, shape (3,); are moved.
        left_rolled, right_rolled: what is left of the roll in the footings, shape (3,); becomes less.
        left_sole, left_measured, right_sole, right_measured: poses and footings of the feet, shape (3,).
        left_stands, right_stands: whether each foot is on the ground; one at least is.
        left_loaded, right_loaded: whether it carries something.
        left_found, right_found: whether it has since it landed; one that bounces has: sunk and lifted by turns it would
            shake the robot.
        ground: its height before [m].
        dt: [s].
    """
    if left_stands:
        _follow(left, left_footing, left_rolled, left_sole, left_measured, left_loaded, left_found, dt)
    if right_stands:
        _follow(right, right_footing, right_rolled, right_sole, right_measured, right_loaded, right_found, dt)
    put_between(stance, left, right)
    height: float = left_footing[0] if left_stands else right_footing[0]
    if left_stands and right_stands:
        height = (left_footing[0] + right_footing[0]) / 2
    return ground + min(1.0, dt / _GROUND_TIME) * (height - ground)


def _flat() -> dict[Side, Array]:
    """Return the roll of feet that lie flat: shape (3,) each, as in ``Swing.rolled``."""
    return {side: np.zeros(3) for side in SIDES}
