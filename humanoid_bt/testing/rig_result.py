"""What a skill did on the rig."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from py_trees.common import Status

from humanoid_bt.control.supervisor import Stop
from humanoid_bt.core.messages import Command, Mode, State
from humanoid_bt.decision.result import ResultValue
from humanoid_bt.tree.ticking.executor import NodeChange


@dataclass(frozen=True)
class RigResult:
    """What a skill did on the rig.

    Attributes:
        status: how it ended; RUNNING when the time was up.
        feedback: the last thing it said.
        time: how long it ran [s].
        results: what it reported by then: name -> value, in SI units.
        states: the state at every tick.
        commands: the command of every tick.
        changes: every change of the skill's status.
        stops: every stop the supervisor ordered meanwhile.
    """

    status: Status
    feedback: str
    time: float
    results: Mapping[str, ResultValue]
    states: list[State] = field(repr=False)
    commands: list[Command] = field(repr=False)
    changes: list[NodeChange] = field(repr=False)
    stops: list[Stop]

    @property
    def succeeded(self) -> bool:
        """Whether the skill ended with SUCCESS."""
        return self.status is Status.SUCCESS

    @property
    def failed(self) -> bool:
        """Whether the skill ended with FAILURE."""
        return self.status is Status.FAILURE

    @property
    def fell(self) -> bool:
        """Whether the robot fell."""
        return any(stop.mode is Mode.DAMP for stop in self.stops)
