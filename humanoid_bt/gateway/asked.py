"""One call of a service or an action: from waiting for somebody who offers it to its answer."""

from __future__ import annotations

import abc
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from humanoid_bt.core.units import readable
from humanoid_bt.decision.calls import Call
from humanoid_bt.gateway.fields import FieldMistake, type_at, value_of
from humanoid_bt.gateway.types import interface

Tell = Callable[[str, str, Mapping[str, Any]], None]
"""Tells decision the state of a call, what there is to say about it, and the values of its answer."""

_SUCCESS, _REASON = "success", "message"  # fields that by custom say whether it went well, and why not


class Asked(abc.ABC):
    """A call that is at work.

    Args:
        node: of rclpy.
        call: it.
        client: of rclpy, for the service or the action.
        request: what is sent.
        tell: tells decision of it.
        goal: the identity of the goal, if it is one.

    Attributes:
        over: whether nothing more is told of it.
    """

    def __init__(self, node: Any, call: Call, client: Any, *, request: Any, tell: Tell, goal: bytes) -> None:
        self.call, self.goal = call, goal
        self._node, self._client, self._request = node, client, request
        self._tell, self._told = tell, ("", "")
        self._sent = self.over = False

    def look(self) -> None:
        """Send it as soon as somebody offers what it asks; notice when nobody does any more."""
        if self.over:
            return
        name, there = self.call.name, self._ready()
        if there and not self._sent:
            self._sent = True
            self.say("running", f"{name} was asked")
            self._send()
        elif self._sent and not there:
            self.end("failure", f"nobody offers {name} any more")
        elif not self._sent:
            others = [kind for kind in self._types() if kind != self._type]
            known = f" as {self._type}, but it is known as {', '.join(others)}" if others else ""
            self.say("pending", f"nobody offers the {self.call.kind} {name}{known}")

    def drop(self) -> None:
        """Be done with it: nobody wants to hear of it any more."""
        self.over = True

    @property
    def orphan(self) -> bool | None:
        """Whether it leaves a goal behind that is to be canceled; None while that is not known."""
        return False

    def say(self, state: str, text: str) -> None:
        """Tell something of it that is new."""
        if not self.over and self._told != (state, text):
            self._told = state, text
            self._tell(state, text, {})

    def end(self, state: str, text: str, values: Mapping[str, Any] | None = None) -> None:
        """Tell how it ended."""
        if not self.over:
            self.over = True
            self._tell(state, text, values or {})

    def answered(self, answer: Any) -> None:
        """Take the response, or the result of a goal that was reached, and judge it."""
        call, kind = self.call, type(answer)
        try:
            values = {path: value_of(answer, path) for path in call.reads}
            judges = call.success or (_SUCCESS if _held(kind, _SUCCESS) == "boolean" else "")
            well = not judges or value_of(answer, judges)
        except FieldMistake as mistake:
            self.end("failure", f"the answer of {call.name}: {mistake}")
            return
        reason = value_of(answer, _REASON) if _held(kind, _REASON) == "string" else ""
        if not well:
            why = f": {reason}" if reason else ""
            self.end("failure", f"{call.name} answered that {judges} is false{why}")
            return
        said = ", ".join(f"{path} {readable(value)}" for path, value in values.items()) or reason
        self.end("success", f"{call.name} answered" + (f": {said}" if said else ""), values)

    @property
    def _type(self) -> str:
        """The type as ROS 2 writes it."""
        package, _, rest = self.call.type.partition("/")
        return f"{package}/{'srv' if self.call.kind == 'service' else 'action'}/{rest.rpartition('/')[2]}"

    def _types(self) -> list[str]:
        """Return the types under which somebody knows something of this name: who asks for it, too."""
        name = self._node.resolve_service_name(self.call.name)
        return [kind for known, kinds in self._offered() if known == name for kind in kinds]

    @abc.abstractmethod
    def _ready(self) -> bool:
        """Return whether somebody offers it."""

    @abc.abstractmethod
    def _offered(self) -> list[tuple[str, list[str]]]:
        """Return what others offer: names, and their types."""

    @abc.abstractmethod
    def _send(self) -> None:
        """Send it."""


class AskedService(Asked):
    """A call of a service."""

    def _ready(self) -> bool:
        return bool(self._client.service_is_ready())

    def _offered(self) -> list[tuple[str, list[str]]]:
        found: list[tuple[str, list[str]]] = self._node.get_service_names_and_types()
        return found

    def _send(self) -> None:
        self._future = self._client.call_async(self._request)
        self._future.add_done_callback(self._hear_response)

    def _hear_response(self, future: Any) -> None:
        if not future.cancelled():
            self.answered(future.result())

    def drop(self) -> None:
        """Be done with it: an answer is heard no more."""
        if self._sent:
            self._client.remove_pending_request(self._future)
        super().drop()


class AskedAction(Asked):
    """A goal of an action."""

    _ENDS: ClassVar = {5: "was canceled by somebody else", 6: "was aborted"}  # action_msgs/GoalStatus
    _REACHED = 4
    _accepted: bool | None = None  # None before its node says so
    _ended = False
    _heard = ""

    @property
    def orphan(self) -> bool | None:
        """Whether the goal is at work; None while its node has not said whether it accepts it."""
        if not self._sent:
            return False
        return None if self._accepted is None else self._accepted and not self._ended

    def look(self) -> None:
        """Send it, then tell the latest of its feedback."""
        super().look()
        if self._heard:
            self.say("running", self._heard)

    def _ready(self) -> bool:
        return bool(self._client.server_is_ready())

    def _offered(self) -> list[tuple[str, list[str]]]:
        from rclpy.action import get_action_names_and_types  # noqa: PLC0415 (part of the extra)

        found: list[tuple[str, list[str]]] = get_action_names_and_types(self._node)
        return found

    def _send(self) -> None:
        goal = interface("unique_identifier_msgs/UUID")(uuid=list(self.goal))
        sent = self._client.send_goal_async(self._request, feedback_callback=self._hear, goal_uuid=goal)
        sent.add_done_callback(self._taken)

    def _taken(self, future: Any) -> None:
        handle = future.result()
        self._accepted = handle.accepted
        if not handle.accepted:
            self.end("failure", f"{self.call.name} refused the goal")
            return
        self.say("running", f"{self.call.name} is at work")
        handle.get_result_async().add_done_callback(lambda result: self._done(result.result()))

    def _hear(self, message: Any) -> None:
        if self.call.feedback:
            try:
                self._heard = f"{self.call.feedback} {readable(value_of(message.feedback, self.call.feedback))}"
            except FieldMistake as mistake:
                self._heard = str(mistake)

    def _done(self, response: Any) -> None:
        self._ended = True
        if response.status == self._REACHED:
            self.answered(response.result)
        else:
            self.end("failure", f"the goal of {self.call.name} {self._ENDS.get(response.status, 'was lost')}")


def _held(kind: Any, field: str) -> str:
    """Return the type of a field, "" if there is none."""
    try:
        return type_at(kind, field)
    except FieldMistake:
        return ""
