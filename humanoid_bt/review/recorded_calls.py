"""Calls of a tree that decides again: they are answered as they were when it ran."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from humanoid_bt.core.errors import Place
from humanoid_bt.decision.calls import Answer, Call


class RecordedCalls:
    """Asks nobody; knows the answers that were recorded up to a tick."""

    def __init__(self) -> None:
        self._count = 0
        self._answers: dict[int, Answer] = {}

    def hear(self, told: list[Any]) -> None:
        """Take an answer: the number of its call, and what was heard."""
        number, answer = told
        self._answers[number] = Answer(**answer)

    def check(self, _call: Call, _places: Mapping[str, Place]) -> None:
        """Refuse nothing: it was asked."""

    def ask(self, _call: Call) -> int:
        """Return the call's number; they are counted as when it ran."""
        self._count += 1
        return self._count

    def answer(self, number: int) -> Answer:
        """Return what was known of a call by now."""
        return self._answers.get(number, Answer("running"))

    def drop(self, _number: int) -> None:
        """Nothing: nobody was asked."""
