"""A body that nobody vouches for: what it raises or answers wrongly is its own failure, and control goes on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from humanoid_bt.control.body import answers
from humanoid_bt.control.body.body import Body, Footstep, Setpoint
from humanoid_bt.control.dynamics import RobotDynamics
from humanoid_bt.core.errors import HumanoidBtError, UserError
from humanoid_bt.core.messages import SIDES, Array, Estimate, Gait, Side, Target
from humanoid_bt.files.class_files import class_file, class_place, place_in_file, why_raised

FAULTS = (Exception, SystemExit)
"""What code of a user may raise that nobody has asked for."""


@dataclass
class _Arms:
    sides: frozenset[Side] = frozenset()
    homeward: frozenset[Side] = frozenset()


class GuardedBody:
    """Answers as a body does. Nothing but :meth:`update` and :meth:`reset` ever raises.

    What the body raises, or answers that nobody can use, is its failure for the rest of the run: it is not asked any
    more, and what it said last stays.

    Args:
        body: it.
        joints: names of the robot's joints.
        dynamics: the robot as it is estimated, always up to date.

    Attributes:
        guarded: the body.
        period: its period [s].
        dynamics: as given.
        arms: which arms yield.
        com_error: what the body said of it last, shape (3,) [m].
    """

    def __init__(self, body: Body, joints: Sequence[str], dynamics: RobotDynamics) -> None:
        self.guarded, self.period, self.dynamics = body, body.period, dynamics
        self.arms = _Arms()
        self.com_error: Array = np.zeros(3)
        self._joints = joints
        self._failure = ""
        self._said: dict[str, Any] = {}

    # ---- what it says of itself -----------------------------------------------------------------------------------

    @property
    def gait(self) -> Gait:
        """What the legs do."""
        gait: Gait = self._ask("gait")
        return gait

    @property
    def still_for(self) -> float:
        """How long it stands already [s]."""
        return float(self._ask("still_for"))

    @property
    def stance(self) -> Array:
        """Middle between the feet on the ground and its heading, shape (3,): x, y [m], yaw [rad], world frame."""
        stance: Array = self._ask("stance")
        return stance

    @property
    def footsteps(self) -> Sequence[Footstep]:
        """Planned footholds ahead."""
        return tuple(self._ask("footsteps"))

    @property
    def com_speed(self) -> float:
        """Horizontal speed of the centre of mass [m/s]."""
        return float(self._ask("com_speed"))

    def hand_error(self, side: Side) -> float | None:
        """How far a planned palm is from where it is to go [m]; None if nothing commands it."""
        error: float | None = self._ask(_hand_error(side))
        return error

    @property
    def hand_obstacles(self) -> Mapping[Side, str]:
        """The own link that keeps a commanded palm from its target."""
        obstacles: Mapping[Side, str] = self._ask("hand_obstacles")
        return obstacles

    @property
    def fault(self) -> str:
        """Why the last setpoint is not what it should be."""
        return str(self._ask("fault"))

    @property
    def failure(self) -> str:
        """Why it cannot go on: what it says itself, or what went wrong with it."""
        said = str(self._ask("failure"))
        return self._failure or said

    # ---- what it does ---------------------------------------------------------------------------------------------

    def reset(self, estimate: Estimate) -> None:
        """Begin a run.

        Raises:
            UserError: the body does not, or what it then says of itself cannot be used.
        """
        self._failure = ""
        self.arms.sides = self.arms.homeward = frozenset()
        try:
            self.guarded.reset(estimate)
            self._said = {name: self._read(name) for name in (*answers.SAID, *map(_hand_error, SIDES))}
            self._hear()
        except FAULTS as error:
            self._fail(error)
            raise refusal(error, type(self.guarded), "cannot begin a run") from error

    def restart(self, estimate: Estimate) -> None:
        """Go on from where the robot is, unless it has failed."""
        if self._failure:
            return
        try:
            self.guarded.restart(estimate)
            self._hear()
        except FAULTS as error:
            self._fail(error)

    def update(self, estimate: Estimate, targets: Mapping[str, Target], hold: bool) -> Setpoint:
        """Return the setpoints of this control period.

        Raises:
            HumanoidBtError: it has failed; the text is its failure.
        """
        if not self._failure:
            try:
                self.guarded.arms.sides = self.arms.sides
                setpoint = answers.setpoint(self.guarded.update(estimate, targets, hold), self._joints)
                self._hear()
            except FAULTS as error:
                self._fail(error)
            else:
                return setpoint
        raise HumanoidBtError(self._failure)

    def _hear(self) -> None:
        """Take what is asked of it once per update."""
        self.arms.homeward = frozenset(self.guarded.arms.homeward)
        self.com_error[:] = answers.com_error(self.guarded.com_error)

    def _ask(self, name: str) -> Any:
        if not self._failure:
            try:
                self._said[name] = self._read(name)
            except FAULTS as error:
                self._fail(error)
        return self._said[name]

    def _read(self, name: str) -> Any:
        what, _, side = name.partition(" ")
        answer = getattr(self.guarded, what)
        return answers.distance(what, answer(side)) if side else answers.SAID[what](what, answer)

    def _fail(self, error: BaseException) -> None:
        self._failure = _why(error, type(self.guarded))


def refusal(error: BaseException, cls: type, cannot: str) -> UserError:
    """Return what is told of a body that cannot even begin, at its own line if it raised there."""
    if isinstance(error, UserError):
        return error
    file = class_file(cls)
    place = (place_in_file(error, file) if file else None) or class_place(cls)
    why = str(error) if isinstance(error, answers.Unusable) else f"{type(error).__name__}: {error}"
    return UserError(f"the body {cls.__name__} {cannot}: {why}", place, code="broken-body")


def _why(error: BaseException, cls: type) -> str:
    if isinstance(error, answers.Unusable):
        return f"the body {cls.__name__}: {error}"
    return why_raised(error, cls)


def _hand_error(side: Side) -> str:
    return f"hand_error {side}"
