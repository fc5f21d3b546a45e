"""What came of a trial."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

SUCCESS = "success"
HUNG, CRASHED = "hung", "crashed"
"""Outcomes that no run has: its time on the wall clock was up; its process died, and again when it was tried anew."""

Value = float | int | bool | str


@dataclass(frozen=True)
class Result:
    """What came of a trial; the same whenever, wherever and beside whatever it runs.

    Attributes:
        outcome: as that of a run, or :data:`HUNG`, :data:`CRASHED`.
        reason: why, in words.
        node: path of the node that the reason is about, "" if it is about none.
        time: simulated time until the tree ended [s].
        fell: whether the robot fell.
        bumped: what it bumped into: the things of the scene that it touched, no hand having been sent there.
        stops: how often the supervisor stopped it.
        missed: what was to happen and did not before it ended: "push 1", "event 2 of the script", joined by ", ".
        values: what skills reported last, by name: in SI units.
        units: of those values that have one.
        trace: of the run, as its report has it: the same only if everything was, bit for bit.
    """

    outcome: str
    reason: str
    node: str = ""
    time: float = 0.0
    fell: bool = False
    bumped: str = ""
    stops: int = 0
    missed: str = ""
    values: Mapping[str, Value] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    trace: str = ""

    @property
    def succeeded(self) -> bool:
        """Whether the tree succeeded."""
        return self.outcome == SUCCESS

    def has_missed(self, what: str) -> bool:
        """Return whether something was to happen, such as a push, and did not."""
        return what in self.missed.split(", ")

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain data for JSON."""
        return asdict(self)


@dataclass(frozen=True)
class Cost:
    """What a trial took on the wall clock, which is never the same twice.

    Attributes:
        wall: from when it was begun to its result [s].
        simulating: of it, the time in which the robot was simulated and the tree ticked [s].
        worker: who ran it.
        attempts: how often it was begun.
    """

    wall: float = 0.0
    simulating: float = 0.0
    worker: str = ""
    attempts: int = 1


@dataclass(frozen=True)
class Explained:
    """What a recording of a trial shows, as ``explain`` says it.

    Attributes:
        kind: what sort of cause.
        headline: it in one sentence.
        node: path of the node behind it, "" if there is none.
        recording: name of the file, "" if there is none.
        same: whether the trial went, bit for bit, as it had gone before.
    """

    kind: str
    headline: str
    node: str = ""
    recording: str = ""
    same: bool = True
