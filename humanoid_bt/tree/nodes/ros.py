"""Leaves that ask other programs, through the gateway of the run: services and actions of ROS 2."""

from __future__ import annotations

import abc
from collections.abc import Mapping
from typing import Any, ClassVar

from py_trees.common import Status

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.params import param
from humanoid_bt.core.units import readable
from humanoid_bt.decision.blackboard import Key
from humanoid_bt.decision.calls import UNKNOWN, Call, Calls
from humanoid_bt.tree.expressions.fields import Fields
from humanoid_bt.tree.expressions.linking import Unseen
from humanoid_bt.tree.nodes.decorators import TIME_TOLERANCE
from humanoid_bt.tree.nodes.leaf import Leaf
from humanoid_bt.tree.ticking.tick import FAILURE, RUNNING, SUCCESS

_HINT = "run it with --mode realtime --gateway FILE; a test puts a stand-in in its place: replace: {%s: success}"


class RosCall(Leaf):
    """Base of the leaves that ask, and wait for the answer without holding up the tick.

    Attributes:
        given: the parameter with the fields of the request.
        taken: the parameter with the keys that fields of the answer are written to.
    """

    given: ClassVar[str]
    taken: ClassVar[str]
    success: str = param("", doc="Field of the answer that must be true; `success`, if it has one, if not given.")

    def __init__(self, name: str, **values: Any) -> None:
        super().__init__(name, **values)
        self._number: int | None = None
        self._started = 0.0
        setattr(self, self.given, Fields.of(getattr(self, self.given)))
        keys = getattr(self, self.taken).items()
        setattr(self, self.taken, {path: Key(key) if isinstance(key, str) else key for path, key in keys})

    @abc.abstractmethod
    def call(self, request: Mapping[str, Any]) -> Call:
        """Return what is asked with these values of the fields."""

    @property
    @abc.abstractmethod
    def limit(self) -> float:
        """How long the answer may take [s]."""

    @property
    def keys(self) -> Mapping[str, Key]:
        """The keys that fields of the answer are written to."""
        found: Mapping[str, Key] = getattr(self, self.taken)
        return found

    def setup(self, **kwargs: Any) -> None:
        """Take the robot, and have checked what will be asked.

        Raises:
            UserError: no gateway joins the run with other programs, or these could not answer.
        """
        super().setup(**kwargs)
        request: Fields = getattr(self, self.given)
        call = self.call(request.sample)
        if UNKNOWN not in (call.name, call.type):  # else a key of the blackboard will say them
            self._calls.check(call, request.places)

    def initialise(self) -> None:
        """Start to measure."""
        super().initialise()
        self._started = self.robot.clock.now()

    def update(self) -> Status:
        """Ask in the first tick, then look for the answer."""
        if self._number is None:
            try:
                request = getattr(self, self.given).evaluate(self.robot)
            except Unseen as unseen:
                self.feedback_message = str(unseen)
                return FAILURE
            self._number = self._calls.ask(self.call(request))
        answer = self._calls.answer(self._number)
        self.feedback_message = answer.text
        if answer.state == "success":
            return self._keep(answer.values)
        if answer.state == "failure":
            return FAILURE
        if self.robot.clock.now() - self._started >= self.limit - TIME_TOLERANCE:
            self.feedback_message = f"not answered within {readable(self.limit, 's')}: {answer.text}"
            return FAILURE
        return RUNNING

    def terminate(self, new_status: Status) -> None:
        """Be done with the call, however it ended; a goal that is still at work is canceled."""
        if self._number is not None:
            self._calls.drop(self._number)
            self._number = None

    def _keep(self, values: Mapping[str, Any]) -> Status:
        try:
            taken = [(key, key.checked(values[path])) for path, key in self.keys.items()]
        except ValueError as error:
            self.feedback_message = f"answered, but {error}"
            return FAILURE
        for key, value in taken:
            key.put(value)
        return SUCCESS

    @property
    def _calls(self) -> Calls:
        if (calls := self.robot.calls) is None:
            what = f"{type(self).type_name!r} asks a program of ROS 2, and nothing joins this run with any"
            raise UserError(what, hint=_HINT % type(self).type_name, code="no-gateway")
        return calls

    type_name: ClassVar[str]


class RosService(RosCall):
    """Call a service of ROS 2, through the gateway; succeed with its answer.

    A field of the request is a value, or an expression: `"{distance(target)}"` alone, or `$name`, gives its value in
    SI units, and in other text it becomes part of the text. What is not given keeps its default.

    Fails when the answer says so, when nothing offers the service or answers in time, when a percept that it asks
    about was never seen, and when the gateway is gone while it waits.
    """

    type_name = "ros_service"
    given, taken = "request", "response"

    service: str = param(doc="Its name.")
    type: str = param(doc="Its type, such as std_srvs/SetBool.")
    request: Fields = param({}, doc="Fields of the request, as in {data: true}.")
    response: dict[str, Key] = param({}, doc="Fields of the response, by their paths: keys that get their values.")
    timeout: float = param(5.0, unit="s", above=0, doc="How long it may take, until the service is found included.")

    def call(self, request: Mapping[str, Any]) -> Call:
        """Return the call of the service."""
        return Call("service", self.service, self.type, request, tuple(self.response), self.success)

    @property
    def limit(self) -> float:
        """How long the answer may take [s]."""
        return self.timeout


class RosAction(RosCall):
    """Send a goal to an action of ROS 2, through the gateway; run until it is reached.

    Fields are written as those of `ros_service`. When the node is halted, or the time is over, the goal is canceled;
    so it is when the run ends or decision dies.

    Fails when the goal is refused, aborted or canceled by others, when the result says so, and as `ros_service` does.
    """

    type_name = "ros_action"
    given, taken = "goal", "result"

    action: str = param(doc="Its name.")
    type: str = param(doc="Its type, such as my_interfaces/action/Dock.")
    goal: Fields = param({}, doc="Fields of the goal, as in {speed: 0.3}.")
    result: dict[str, Key] = param({}, doc="Fields of the result, by their paths: keys that get their values.")
    feedback: str = param("", doc="Field of the feedback that the node tells while it runs.")
    timeout: float = param(unit="s", above=0, doc="How long it may take, until the action is found included.")

    def call(self, request: Mapping[str, Any]) -> Call:
        """Return the goal."""
        return Call("action", self.action, self.type, request, tuple(self.result), self.success, self.feedback)

    @property
    def limit(self) -> float:
        """How long the result may take [s]."""
        return self.timeout
