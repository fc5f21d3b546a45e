"""The tree as an action of ROS 2: a goal starts it, with parameters of its own; a client hears how it goes."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

from humanoid_bt.core.errors import Place, UserError
from humanoid_bt.gateway.fields import FieldMistake, fill
from humanoid_bt.gateway.file import GatewayFile, TreeAction
from humanoid_bt.gateway.inbox import News
from humanoid_bt.gateway.node import Ears
from humanoid_bt.gateway.percepts import Malformed, value_at
from humanoid_bt.gateway.snapshot import Snapshot
from humanoid_bt.gateway.types import interface
from humanoid_bt.link.ring import RingWriter

_FEEDBACK_PERIOD = 0.2  # s
_NO_GOAL = bytes(16).hex()  # as long as the identity of one


class ActionServer:
    """Takes one goal at a time.

    Args:
        ears: where it listens.
        config: of the action.
        orders: where it writes to decision, as JSON: {"order": "start", "goal": ..., "parameters": {...}}, or "cancel".
        news: is told of goals that are refused.
    """

    def __init__(self, ears: Ears, config: TreeAction, orders: RingWriter, news: News) -> None:
        from rclpy import action  # noqa: PLC0415 (part of the extra)

        self._ears, self._config, self._orders, self._news = ears, config, orders, news
        self._replies = action
        self._type = interface(config.type, "action")
        self._goal = ""  # the identity of the one that is at work
        self._handle: Any = None
        self._done: Any = None
        self._next = 0.0
        self._orders.write(_cancels(""))  # what a gateway that died has left behind
        self._server = action.ActionServer(
            ears.node,
            self._type,
            config.name,
            self._execute,
            goal_callback=self._accept,
            cancel_callback=self._cancel,
        )

    def told(self, values: Mapping[str, Any]) -> None:
        """Take from decision that the tree of a goal has ended: how, and why."""
        if self._done is not None and values["goal"] == self._goal:
            self._done.set_result(values)

    def feed_back(self, now: Snapshot) -> None:
        """Tell the client how it goes, if it is time."""
        if (handle := self._handle) is not None and now.state.time >= self._next:
            self._next = now.state.time + _FEEDBACK_PERIOD
            said = {"node": now.told.get("node", ""), "feedback": now.told.get("feedback", ""), "time": now.state.time}
            handle.publish_feedback(_filled(self._type.Feedback(), self._config.feedback, said))

    def _accept(self, goal: Any) -> Any:
        try:
            length, room = len(self._starts(_NO_GOAL, goal)), self._orders.slot_size
            if length > room:
                raise Malformed(f"its parameters are too long: {length} bytes, and {room} have room")
        except Malformed as error:
            self._news("error", f"a goal of {self._config.name} is refused: {error}")
            return self._replies.GoalResponse.REJECT
        if self._goal:
            self._news("warning", f"a goal of {self._config.name} is refused: another one is at work")
            return self._replies.GoalResponse.REJECT
        self._goal = "accepted"
        return self._replies.GoalResponse.ACCEPT

    def _cancel(self, handle: Any) -> Any:
        self._orders.write(_cancels(_identity(handle)))
        return self._replies.CancelResponse.ACCEPT

    async def _execute(self, handle: Any) -> Any:
        self._goal = _identity(handle)
        self._done, self._handle = self._ears.future(), handle
        try:
            self._orders.write(self._starts(self._goal, handle.request))
            end: Mapping[str, Any] = await self._done
        finally:
            self._handle = self._done = None
            self._goal = ""
        if end["outcome"] == "success":
            handle.succeed()
        elif handle.is_cancel_requested:
            handle.canceled()
        else:
            handle.abort()
        return _filled(self._type.Result(), self._config.result, {**end, "success": end["outcome"] == "success"})

    def _starts(self, identity: str, goal: Any) -> bytes:
        parameters = {name: value_at(goal, path) for name, path in self._config.parameters.items()}
        return json.dumps({"order": "start", "goal": identity, "parameters": parameters}).encode()


def _cancels(identity: str) -> bytes:
    return json.dumps({"order": "cancel", "goal": identity}).encode()


def _identity(handle: Any) -> str:
    return bytes(handle.goal_id.uuid).hex()


def check_action(config: GatewayFile, place_of: Callable[..., Place]) -> None:
    """Refuse an action whose type is not installed, or does not have the fields that the file names.

    Args:
        config: the file.
        place_of: returns where a value of it is written, by its keys.

    Raises:
        UserError: with the first thing that is wrong.
    """
    if (action := config.action) is None:
        return
    kind = interface(action.type, "action", place_of("action", "type"))
    samples = {"node": "", "feedback": "", "time": 0.0, "outcome": "", "reason": "", "success": True}
    parts = (("feedback", kind.Feedback(), action.feedback), ("result", kind.Result(), action.result))
    for part, message, fields in parts:
        for field, what in fields.items():
            place = place_of("action", part, field)
            try:
                fill(message, {field: samples[what]})
            except FieldMistake as mistake:
                why = f"the {part} does not take the {what}: {mistake.message}"
                raise UserError(why, place, mistake.hint, mistake.code) from None


def _filled(message: Any, fields: Mapping[str, str], values: Mapping[str, Any]) -> Any:
    return fill(message, {field: values[what] for field, what in fields.items()})
