"""The base class of a leaf that commands the robot.

A skill is one file in a workspace's ``skills/`` folder:

    class Wave(Skill):
        \"\"\"Raise a hand and wave.\"\"\"

        resources = ("right_hand",)
        times: int = param(3, minimum=1, doc="How often.")
        waved: int = result(doc="How often it waved.")

        def initialise(self) -> None: ...
        def update(self) -> Status: ...

Its name in trees is the class name in snake_case.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, ClassVar

import py_trees
from py_trees.common import Status

from humanoid_bt.core.params import PerceptName
from humanoid_bt.core.texts import shortened, snake_case
from humanoid_bt.decision.assign import assign
from humanoid_bt.decision.result import ResultValue, declared_results
from humanoid_bt.decision.robot import Robot
from humanoid_bt.decision.robot_handle import RobotHandle

__all__ = ["PerceptName", "Skill", "Status", "node_type_name", "of_gaze", "of_hand"]

_RUNNING = Status.RUNNING  # reading a member from its class costs more than returning it
_REST_TIME = 30.0  # s in which a base that can come to rest does so, also after a walk or a push


def node_type_name(cls: type) -> str:
    """Return the name of a class in tree files: snake_case, or its ``type_name`` if it has one."""
    named = vars(cls).get("type_name")
    return named if isinstance(named, str) else snake_case(cls.__name__)


def of_hand(resources: Iterable[str], hand: str) -> tuple[str, ...]:
    """Return resources without the other hand, if it is ``left`` or ``right``; else all of them."""
    others = {"left": "right_hand", "right": "left_hand"}
    return tuple(resource for resource in resources if resource != others.get(hand))


def of_gaze(resources: Iterable[str], look: bool) -> tuple[str, ...]:
    """Return resources without the gaze, unless it is to look."""
    return tuple(resource for resource in resources if look or resource != "gaze")


class Skill(py_trees.behaviour.Behaviour):
    """A leaf that commands the robot.

    Subclasses declare parameters with :func:`~humanoid_bt.core.params.param`; instances have their values as
    attributes. What they reach or find out they declare with :func:`~humanoid_bt.decision.result.result`, and set.
    ``self.robot`` is there from ``setup`` on. Nothing in a skill blocks or sleeps.

    Args:
        name: the node's name.
        values: parameter values, already of their declared types.

    Attributes:
        resources: what the skill may command (of :data:`~humanoid_bt.core.messages.RESOURCES`).
        ends: whether it can succeed or fail; False if it only runs until it is halted.
        runs: whether it can be RUNNING; False if it answers in the tick in which it starts, as conditions do.
        bounded: whether it ends by itself in bounded time, whatever happens. Checks want a time limit above a skill
            that commands the robot and does not say so.
        either_hand: whether one hand will do where it may command both, on a robot that has one.
        remembered: parameters that name percepts for which a look into the past will do, such as obstacles: checks want
            no watchdog on them.
        robot: how it reads the robot's state and percepts and sets targets.
        path: the node's path in its tree, set before ``setup``.
        halt_reason: why it is being halted, set before ``terminate(INVALID)``: preempted, timed out, ...
    """

    resources: ClassVar[tuple[str, ...]] = ()
    ends: ClassVar[bool] = True
    runs: ClassVar[bool] = True
    bounded: ClassVar[bool] = False
    either_hand: ClassVar[bool] = False
    remembered: ClassVar[tuple[str, ...]] = ()
    robot: RobotHandle

    def __init__(self, name: str = "", **values: Any) -> None:
        super().__init__(name or node_type_name(type(self)))
        assign(self, values)
        self.path = self.name
        self.halt_reason = ""
        self._results: dict[str, ResultValue] = {}
        self._rests_by = math.inf  # s on the tree's clock, while that is awaited
        if declared_results(type(self)):
            self.initialise = functools.partial(_start_anew, self, self.initialise)  # type: ignore[method-assign]  # the skill's own, with this before it

    @property
    def results(self) -> Mapping[str, ResultValue]:
        """The results that it has set since it started, by name."""
        return self._results

    @classmethod
    def resources_for(cls, values: Mapping[str, Any]) -> Iterable[str]:
        """Return which of its resources the skill may command when it has these parameter values.

        Checks ask it before the run. They take all of ``resources`` if a parameter is read from the blackboard.

        Args:
            values: every parameter by name, defaults put in.
        """
        return cls.resources

    def setup(self, **kwargs: Any) -> None:
        """Take ``robot``, a :class:`~humanoid_bt.decision.robot.Robot`; called once, before the first tick."""
        robot: Robot = kwargs["robot"]
        self.robot = RobotHandle(robot, self.path, self.resources)

    def stop(self, new_status: Status) -> None:
        """End or halt the skill: ``terminate``, then give back what it commanded in this tick."""
        try:
            super().stop(new_status)
        finally:
            self._rests_by = math.inf
            self.robot.release()

    def running(self, feedback: object) -> Status:
        """Return RUNNING with a word on what is happening; what is no text becomes one."""
        self._rests_by = math.inf
        self.feedback_message = shortened(feedback)
        return _RUNNING

    def await_rest(self, feedback: object) -> Status:
        """Return RUNNING with a word while the base comes to rest, and FAILURE after half a minute of that in a row.

        It may never do so, as where something pushes it again and again, or another node walks on and on.
        """
        now = self.robot.clock.now()
        rests_by = min(self._rests_by, now + _REST_TIME)
        if now >= rests_by:
            return self.fail(f"the base does not come to rest within {_REST_TIME:g} s")
        status = self.running(feedback)
        self._rests_by = rests_by
        return status

    def succeed(self, feedback: object) -> Status:
        """Return SUCCESS with a word on what was reached; what is no text becomes one."""
        self.feedback_message = shortened(feedback)
        return Status.SUCCESS

    def fail(self, feedback: object) -> Status:
        """Return FAILURE with the reason; what is no text, such as an exception, becomes one."""
        self.feedback_message = shortened(feedback)
        return Status.FAILURE


def _start_anew(skill: Skill, initialise: Callable[[], None]) -> None:
    """Start a skill that has results: those of the last time are forgotten."""
    skill._results = {}
    initialise()
