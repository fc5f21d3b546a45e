"""What a tree asks of other nodes: services are called, goals are sent to actions, and answers go back to it.

All of it happens in the thread that hears, and none of it waits.
"""

from __future__ import annotations

import json
import uuid
from collections.abc import Callable, Mapping
from typing import Any

from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.errors import Place, UserError
from humanoid_bt.core.texts import shortened
from humanoid_bt.decision.calls import Call
from humanoid_bt.gateway.asked import Asked, AskedAction, AskedService
from humanoid_bt.gateway.cancels import Cancels
from humanoid_bt.gateway.fields import FieldMistake, fill, type_at
from humanoid_bt.gateway.inbox import News
from humanoid_bt.gateway.node import Ears
from humanoid_bt.gateway.types import interface
from humanoid_bt.link.ring import RingReader, RingWriter

_LONGEST = 500  # characters of what is said about a call


class Caller:
    """Does what the tree of a run asks for.

    Args:
        ears: whose node asks.
        orders: where decision says what is asked, and what is not wanted any more.
        answers: where decision hears what became of it.
        run: what tells the run apart from others.
        news: is told of goals that cannot be canceled.
    """

    def __init__(self, ears: Ears, orders: RingReader, answers: RingWriter, run: str, news: News) -> None:
        self._node, self._orders, self._answers, self._run = ears.node, orders, answers, run
        self._read = orders.sequence  # what was asked of the gateway before this one has been given up
        self._asked: dict[int, Asked] = {}
        self._dropped: list[Asked] = []  # of which it is not known yet whether a goal is at work
        self._clients: dict[tuple[str, str, str], Any] = {}
        self._cancels = Cancels(ears.node, news)
        self._over = self._ended = False
        ears.every(DECISION_PERIOD, self._turn)

    def end(self) -> None:
        """Ask for nothing more; goals that are at work are canceled. From any thread."""
        self._over = True

    @property
    def idle(self) -> bool:
        """Whether nothing is at work any more, and all that decision wrote before the end was read."""
        return self._ended and not self._asked and not self._dropped and not self._cancels.waiting

    def _turn(self) -> None:
        over = self._over  # before it reads: decision writes nothing after the end
        entries, lost = self._orders.since(self._read)
        if lost:
            self._forget(lost)
        for sequence, payload in entries:
            self._read = sequence
            self._order(json.loads(payload))
        for number in list(self._asked) if over else ():
            self._drop(number)
        for number, asked in list(self._asked.items()):
            asked.look()
            if asked.over and asked.orphan is False:  # a run may ask for hours
                self._drop(number)
        dropped, self._dropped = self._dropped, []
        for asked in dropped:
            self._leave(asked)
        self._cancels.look()
        self._ended = over

    def _forget(self, lost: int) -> None:
        """Let go of all calls after so many orders were lost: any of them may have been dropped, others never begun."""
        for number in list(self._asked):
            self._drop(number)
        self._answers.write(json.dumps({"lost": lost}).encode())

    def _order(self, order: Mapping[str, Any]) -> None:
        number = order["number"]
        if order["order"] == "drop" and number in self._asked:
            self._drop(number)
        elif order["order"] == "drop" and order["call"]["kind"] == "action":  # asked by a gateway before this one
            self._cancels.add(order["call"]["name"], self._identity(number))
        elif order["order"] == "ask":
            self._ask(number, Call(**order["call"]))

    def _ask(self, number: int, call: Call) -> None:
        tell = self._teller(number)
        try:
            new = AskedService if call.kind == "service" else AskedAction
            kind = interface(call.type, "srv" if call.kind == "service" else "action")
            request = fill((kind.Request if call.kind == "service" else kind.Goal)(), call.request)
            client = self._client(call, kind)
        except (FieldMistake, UserError, ValueError) as error:  # the last: ROS 2 takes no such name
            tell("failure", f"{call.name} cannot be asked: {error}", {})
            return
        self._asked[number] = new(self._node, call, client, request=request, tell=tell, goal=self._identity(number))

    def _drop(self, number: int) -> None:
        asked = self._asked.pop(number)
        asked.drop()
        self._leave(asked)

    def _leave(self, asked: Asked) -> None:
        """Cancel the goal that a call leaves behind, as soon as it is known whether it does."""
        if asked.orphan is None:
            self._dropped.append(asked)
        elif asked.orphan:
            self._cancels.add(asked.call.name, asked.goal)

    def _client(self, call: Call, kind: Any) -> Any:
        key = call.kind, call.name, call.type
        if key not in self._clients:
            from rclpy.action import ActionClient  # noqa: PLC0415 (part of the extra)

            new: Callable[..., Any] = self._node.create_client
            self._clients[key] = (
                ActionClient(self._node, kind, call.name) if call.kind == "action" else new(kind, call.name)
            )
        return self._clients[key]

    def _teller(self, number: int) -> Callable[[str, str, Mapping[str, Any]], None]:
        def tell(state: str, text: str, values: Mapping[str, Any]) -> None:
            said = {"number": number, "state": state, "text": shortened(text, _LONGEST)}
            data = json.dumps({**said, "values": values}).encode()
            if len(data) > self._answers.slot_size:
                what = f"the answer is too long: {len(data)} bytes, and {self._answers.slot_size} have room"
                data = json.dumps({**said, "state": "failure", "text": what, "values": {}}).encode()
            self._answers.write(data)

        return tell

    def _identity(self, number: int) -> bytes:
        """Return the identity of a goal, the same for every gateway of the run."""
        return uuid.uuid5(uuid.NAMESPACE_URL, f"{self._run}/{number}").bytes


def check_call(call: Call, places: Mapping[str, Place]) -> None:
    """Refuse a call whose type is not installed, or does not have what is written, or read, in these fields.

    Args:
        call: it.
        places: path of a field of the request -> where it is written.

    Raises:
        UserError: with the first thing that is wrong.
    """
    service = call.kind == "service"
    kind = interface(call.type, "srv" if service else "action")
    request, answer = (kind.Request, kind.Response) if service else (kind.Goal, kind.Result)
    what = f"the {'request' if service else 'goal'} of {call.type}"
    try:
        fill(request(), call.request)
    except FieldMistake as mistake:
        place = places.get(mistake.path)
        raise UserError(f"{what}: {mistake.message}", place, mistake.hint, mistake.code) from None
    what = f"the {'response' if service else 'result'} of {call.type}"
    try:
        for path in call.reads:
            type_at(answer, path)
        if call.success and (found := type_at(answer, call.success)) != "boolean":
            raise FieldMistake(call.success, f"{call.success!r} is not true or false: it is of type {found}")
        if call.feedback:
            what = f"the feedback of {call.type}"
            type_at(kind.Feedback, call.feedback)
    except FieldMistake as mistake:
        raise UserError(f"{what}: {mistake.message}", None, mistake.hint, mistake.code) from None
