"""The script of a run on the stage: faults, each with its moment."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from humanoid_bt.core.errors import Place, Problem, UserError
from humanoid_bt.core.items import Item
from humanoid_bt.core.params import param, written
from humanoid_bt.core.reading import read
from humanoid_bt.testing.claim import Claim, RunNames
from humanoid_bt.testing.course import Course
from humanoid_bt.testing.fault import Fault, Known
from humanoid_bt.testing.faults import (
    Break,
    Delay,
    EStop,
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
from humanoid_bt.tree.source.given import plain_item

_MOMENTS = ("at", "when")
_WITH = (*_MOMENTS, "optional")  # what an event says beside its fault


@dataclass(frozen=True, kw_only=True)
class Event:
    """A fault and its moment: a time, or the first tick after one in which an expression was true.

    Attributes:
        place: where it is written.
        item: it as it is written, None if it was made in Python.
    """

    at: float | None = param(None, minimum=0, unit="s", doc="When, on the engine's clock.")
    when: Claim | None = param(None, doc="When this has become true.")
    push: Push | None = param(None, doc="Push the robot.")
    estop: EStop | None = param(None, doc="Raise the emergency stop.")
    reset: Reset | None = param(None, doc="Ask for the reset of a latched stop.")
    lose: Lose | None = param(None, doc="Let perception of a thing end.")
    see: See | None = param(None, doc="Let the robot see a thing at a place.")
    noise: Noise | None = param(None, doc="Let a percept be seen worse than it is.")
    silence: Silence | None = param(None, doc="Let no command reach control.")
    delay: Delay | None = param(None, doc="Let every command reach control later.")
    weaken: Weaken | None = param(None, doc="Let drives give less torque than they are asked for.")
    break_: Break | None = param(None, doc="Let a sensor fail.")
    raise_: Raise | None = param(None, doc="Let a node raise an exception.")
    set: Set | None = param(None, doc="Give keys of the blackboard, or parameters of nodes, a value.")
    optional: bool = param(False, doc="Whether the run may as well end before it happens.")
    place: Place | None = field(default=None, compare=False)
    item: Item | None = field(default=None, compare=False, repr=False)

    @classmethod
    def from_item(cls, item: Item, _name: str = "") -> Event:
        """Read an event from a YAML mapping; raises UserError with everything that is wrong with it."""
        event: Event = read(cls, _filled(item), "the event")
        return replace(event, place=item.place, item=item)

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
        elif not faults and not [key for key in item.value if key not in (*_WITH, *FAULTS)]:
            yield Problem("this event does nothing", item.place, f"valid: {', '.join(FAULTS)}", code="exclusive-keys")

    @property
    def moment(self) -> str:
        """When, in words."""
        return f"when {self.when}" if self.when is not None else f"at {self.at:g} s"

    @property
    def plain(self) -> dict[str, Any]:
        """The event as data for JSON, as a file would say it."""
        given = {name: getattr(self, name) for name in (*_MOMENTS, *_FIELDS, "optional")}
        return {
            written(name): _said(value) for name, value in given.items() if value is not None and value is not False
        }

    def __str__(self) -> str:
        return f"{self.moment} {self.fault}"

    def place_of(self, *keys: str | int, key: bool = False) -> Place:
        """Return where a value of it is written, or its key, as near as that is known."""
        return self.item.place_of(*keys, key=key) if self.item is not None else self.place or Place("")

    @property
    def name(self) -> str:
        """The fault's name."""
        return next(written(name) for name in _FIELDS if getattr(self, name) is not None)

    @property
    def fault(self) -> Fault:
        """The fault."""
        faults: list[Fault] = [found for name in _FIELDS if (found := getattr(self, name)) is not None]
        return faults[0]


def _said(value: Any) -> Any:
    """Return a moment or a fault as data for JSON, as a file would say it."""
    return value.text if isinstance(value, Claim) else value.plain if isinstance(value, Fault) else value


def _filled(item: Item) -> Item:
    """Return an event's mapping with ``estop:`` for ``estop: {}``, and without a moment that is none."""
    if not isinstance(item.value, dict):
        return item
    given = {key: part for key, part in item.value.items() if part.value is not None or key not in _MOMENTS}
    empty = {key: Item({}, part.place) for key, part in given.items() if part.value is None and key in FAULTS}
    return Item({**given, **empty}, item.place, item.key_places)


_FIELDS = tuple(name for name in Event.__dataclass_fields__ if name not in (*_WITH, "place", "item"))
FAULTS = tuple(map(written, _FIELDS))
"""What an event can be."""


def script_of(script: Iterable[Event | Mapping[str, Any]]) -> tuple[Event, ...]:
    """Return the events of a script, which may be made in Python or written as in YAML; both are read alike.

    Raises:
        UserError: with everything that is wrong with them.
    """
    if isinstance(script, (str, Mapping)) or not isinstance(script, Iterable):
        raise UserError(f"a script is a list of events, not {script!r}", hint='like [{"at": "1 s", "lose": "target"}]')
    events: list[Event] = []
    problems: list[Problem] = []
    for number, event in enumerate(script, 1):
        place = getattr(event, "place", None) or Place(f"event {number} of the script")
        try:
            events.append(_event(event, place))
        except UserError as error:
            problems += [replace(problem, place=problem.place or place) for problem in error.problems]
    if problems:
        raise UserError(problems)
    return tuple(events)


def _event(given: Event | Mapping[str, Any], place: Place) -> Event:
    """Return an event of a script; raises UserError with everything that is wrong with it."""
    if isinstance(given, Event):
        return given if given.item is not None else Event.from_item(plain_item("event", given.plain, place))
    return Event.from_item(plain_item("event", given, place))


def mistakes(events: Sequence[Event], known: Known) -> Iterator[Problem]:
    """Yield what a script asks for and a run does not have, each with its place."""
    for event in events:
        if event.fault.physical and known.dry:
            what, hint = event.name, "run it without dry, or leave the event out"
            yield Problem(f"{what!r} needs a body, and a dry run simulates none", event.place, hint)
            continue
        for problem, keys, key in event.fault.misnamed(known):
            yield replace(problem, place=event.place_of(event.name, *keys, key=key))
        if event.when is not None:
            try:
                event.when.link(RunNames(Course(known.tree), known.percepts))
            except UserError as error:
                yield from error.problems if event.place is None else _placed(error, event.place)


def too_late(events: Iterable[Event], duration: float) -> Iterator[Problem]:
    """Yield the events that cannot happen in a run of at most this long [s]."""
    for event in events:
        if event.at is not None and event.at > duration:
            message = f"the event at {event.at:g} s never happens: a run ends after {duration:g} s"
            yield Problem(message, event.place_of("at"), "an earlier moment, or a longer duration", "out-of-range")


def _placed(error: UserError, place: Place) -> Iterator[Problem]:
    """Yield the problems of a moment, where they are in its file, or with the event."""
    for problem in error.problems:
        known = problem.place is not None and problem.place.file == place.file
        yield problem if known else replace(problem, place=place)
