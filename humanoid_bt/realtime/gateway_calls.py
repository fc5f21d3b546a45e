"""Calls of the tree, on their way to the gateway and back; see :mod:`humanoid_bt.decision.calls`."""

from __future__ import annotations

import dataclasses
import json
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from humanoid_bt.core.errors import Place
from humanoid_bt.decision.calls import Answer, Call
from humanoid_bt.link.ring import RingWriter
from humanoid_bt.link.segment import LinkError

CheckCall = Callable[[Call, Mapping[str, Place]], None]
"""As :meth:`~humanoid_bt.decision.calls.Calls.check`."""


class GatewayCalls:
    """Carries calls to a gateway that may come and go.

    Args:
        check: refuses calls that nobody could answer.
    """

    def __init__(self, check: CheckCall) -> None:
        self._check = check
        self._ring: RingWriter | None = None
        self._count = 0
        self._answers: dict[int, Answer] = {}  # of every call that is not dropped yet
        self._calls: dict[int, Call] = {}
        self._news: deque[tuple[int, Answer]] = deque()

    def connect(self, ring: RingWriter) -> None:
        """Take the ring to the gateway."""
        self._ring = ring

    def close(self) -> None:
        """Let go of the ring."""
        ring, self._ring = self._ring, None
        if ring is not None:
            ring.close()

    def check(self, call: Call, places: Mapping[str, Place]) -> None:
        """Refuse what nobody could answer; raises UserError."""
        self._check(call, places)

    def ask(self, call: Call) -> int:
        """Ask; return the call's number."""
        self._count += 1
        number = self._count
        self._calls[number] = call
        self._answers[number] = Answer("pending", f"waiting for the gateway to take {call.name}")
        try:
            self._write({"order": "ask", "number": number, "call": dataclasses.asdict(call)})
        except LinkError as error:
            self._hear(number, Answer("failure", f"{call.name} cannot be asked: {error}"))
        return number

    def answer(self, number: int) -> Answer:
        """Return what is known of a call."""
        return self._answers[number]

    def drop(self, number: int) -> None:
        """Be done with a call."""
        call, answer = self._calls.pop(number), self._answers.pop(number)
        if not answer.final:
            self._cancel(number, call)

    def hear(self, told: Mapping[str, Any]) -> None:
        """Take what the gateway says about a call, or that it missed some.

        Of one that was dropped nobody wants to know.
        """
        if (lost := told.get("lost")) is not None:
            self.lose(f"the gateway was busy, and {lost} of the things it was told are lost")
            return
        number = told["number"]
        if number in self._answers:
            self._hear(number, Answer(told["state"], told["text"], told["values"]))

    def lose(self, why: str) -> None:
        """Take note that nobody will hear how calls end that are not over.

        Args:
            why: for people.
        """
        for number, answer in list(self._answers.items()):
            if not answer.final:
                name = self._calls[number].name
                self._hear(number, Answer("failure", f"nobody heard what became of {name}: {why}"))
                self._cancel(number, self._calls[number])

    def take_news(self) -> Iterator[tuple[int, Answer]]:
        """Yield what was heard since the last time."""
        while self._news:
            yield self._news.popleft()

    def _hear(self, number: int, answer: Answer) -> None:
        self._answers[number] = answer
        self._news.append((number, answer))

    def _cancel(self, number: int, call: Call) -> None:
        self._write({"order": "drop", "number": number, "call": {"kind": call.kind, "name": call.name}})

    def _write(self, values: Mapping[str, Any]) -> None:
        if self._ring is not None:
            self._ring.write(json.dumps(values).encode())
