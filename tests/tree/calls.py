"""Calls that are answered as their names say, in simulated time, for trees without a gateway."""

from __future__ import annotations

from collections.abc import Mapping

from humanoid_bt.core.clock import Clock
from humanoid_bt.core.errors import Place
from humanoid_bt.decision.calls import Answer, Call


class NamedCalls:
    """``/success_40`` is answered well after 40 ms, ``/failure_0`` badly and at once, ``/never`` not.

    Attributes:
        asked: every call so far.
        open: the calls that nobody is done with, by their numbers.
        checked: what was checked, and where its fields are written.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self.asked: list[Call] = []
        self.open: dict[int, tuple[Call, float]] = {}
        self.checked: list[tuple[Call, Mapping[str, Place]]] = []

    def check(self, call: Call, places: Mapping[str, Place]) -> None:
        self.checked.append((call, places))

    def ask(self, call: Call) -> int:
        self.asked.append(call)
        self.open[len(self.asked)] = call, self._clock.now()
        return len(self.asked)

    def answer(self, number: int) -> Answer:
        call, since = self.open[number]
        how, _, after = call.name.removeprefix("/").partition("_")
        if how == "never" or self._clock.now() - since < int(after) / 1000 - 1e-9:
            return Answer("running", "asked")
        return Answer("success" if how == "success" else "failure", f"answered: {how}", dict.fromkeys(call.reads, 5))

    def drop(self, number: int) -> None:
        del self.open[number]
