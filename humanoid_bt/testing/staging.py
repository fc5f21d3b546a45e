"""What a test does to a run, and how that is told."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from humanoid_bt.testing.conditions import Conditions
from humanoid_bt.testing.events import Event
from humanoid_bt.testing.substitution import Replacement


@dataclass(frozen=True)
class Staging:
    """What a test does to a run.

    Attributes:
        dry: whether no body is simulated.
        conditions: what is different from the beginning.
        replace: what stands in nodes' places, by path or type.
        script: faults, each with its moment.
    """

    dry: bool
    conditions: Conditions
    replace: Mapping[str, Replacement]
    script: tuple[Event, ...]

    @property
    def lines(self) -> list[str]:
        """What holds from the beginning, for people."""
        lines = ["dry: without physics, the robot is at once where it is told to be"] if self.dry else []
        if self.conditions.changed:
            lines.append(str(self.conditions))
        return [*lines, *(f"{name} is replaced: {of}" for name, of in self.replace.items())]

    def told(self, missed: Collection[str] = ()) -> dict[str, Any] | None:
        """Return the same and the script as data for the report and the recording; None if nothing is done to the run.

        Args:
            missed: the events of the script that never happened.
        """
        events = [f"{event}, which never happened" if event in missed else event for event in map(str, self.script)]
        lines = [*self.lines, *events]
        if not lines:
            return None
        return {
            "dry": self.dry,
            "told": lines,
            "conditions": self.conditions.changed,
            "replace": {name: str(of) for name, of in self.replace.items()},
            "script": [event.plain for event in self.script],
            "missed": list(missed),
        }
