"""The script of a run on the stage: faults, each with its moment."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from humanoid_bt.core.errors import Place, Problem
from humanoid_bt.core.items import Item, item_of
from humanoid_bt.core.params import param
from humanoid_bt.core.reading import read
from humanoid_bt.testing.faults import (
    Delay,
    EStop,
    Fault,
    Lose,
    Noise,
    Push,
    Raise,
    Reset,
    See,
    Set,
    Silence,
    Weaken,
)
from humanoid_bt.tree.expressions.expression import Truth

_MOMENTS = ("at", "when")


@dataclass(frozen=True, kw_only=True)
class Event:
    """A fault and its moment: a time, or the first tick after an expression has become true."""

    at: float | None = param(None, minimum=0, unit="s", doc="When, on the engine's clock.")
    when: Truth | None = param(None, doc="When this has become true.")
    push: Push | None = param(None, doc="Push the robot.")
    estop: EStop | None = param(None, doc="Raise the emergency stop.")
    reset: Reset | None = param(None, doc="Ask for the reset of a latched stop.")
    lose: Lose | None = param(None, doc="Let perception of a thing end.")
    see: See | None = param(None, doc="Let the robot see a thing at a place.")
    noise: Noise | None = param(None, doc="Let a percept be seen worse than it is.")
    silence: Silence | None = param(None, doc="Let no command reach control.")
    delay: Delay | None = param(None, doc="Let every command reach control later.")
    weaken: Weaken | None = param(None, doc="Let drives give less torque than they are asked for.")
    raise_: Raise | None = param(None, doc="Let a node raise an exception.")
    set: Set | None = param(None, doc="Give keys of the blackboard, or parameters of nodes, a value.")

    @staticmethod
    def mistakes(item: Item, _values: Mapping[str, Any]) -> Iterator[Problem]:
        """Return what does not go together."""
        moments = [key for key in _MOMENTS if key in item.value]
        if len(moments) != 1:
            message = "an event happens at a time or when something becomes true" + (", not both" if moments else "")
            yield Problem(message, item.place, "write at: 2 s, or when: an expression", code="exclusive-keys")
        faults = [key for key in item.value if key in FAULTS]
        if len(faults) > 1:
            message = f"an event is one fault, not {' and '.join(faults)}"
            yield Problem(message, item.place, "make an event of each", code="exclusive-keys")
        elif not faults and not [key for key in item.value if key not in (*_MOMENTS, *FAULTS)]:
            yield Problem("this event does nothing", item.place, f"valid: {', '.join(FAULTS)}", code="exclusive-keys")

    @property
    def fault(self) -> Fault:
        """The fault."""
        faults: list[Fault] = [found for name in _FIELDS if (found := getattr(self, name)) is not None]
        return faults[0]


_FIELDS = tuple(name for name in Event.__dataclass_fields__ if name not in _MOMENTS)
FAULTS = tuple(name.rstrip("_") for name in _FIELDS)
"""What an event can be."""


def script_of(script: Iterable[Event | Mapping[str, Any]]) -> tuple[Event, ...]:
    """Return the events of a script, some of which may be written as in YAML.

    Raises:
        UserError: with everything that is wrong with them.
    """
    place = Place("script")
    return tuple(
        event if isinstance(event, Event) else read(Event, item_of(event, place), "the event") for event in script
    )
