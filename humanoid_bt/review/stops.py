"""The stops of a run: when, for how long, why, and by whom; and those from which it recovered."""

from __future__ import annotations

from collections.abc import Iterator

from humanoid_bt.review.cause import Row
from humanoid_bt.review.history import History, Stopped
from humanoid_bt.review.words import cut, when

_MOST = 4  # that are listed
_SHORT = 60  # characters of why the robot was stopped


def stop_rows(history: History) -> Iterator[Row]:
    """Yield the stops of a run, each with how long it lasted if the robot went on, as far as they are few."""
    before = ""
    for number, stop in enumerate(history.stops[:_MOST]):
        mode, by = stop.mode.replace("_", " "), "" if stop.source == "supervisor" else f" ({cut(stop.source, 40)})"
        why = f"{_in_short(stop.reason)}{by}"
        name, told = ("the same", "") if f"{mode}: {why}" == before else (mode, f": {why}")
        yield "stops" if number == 0 else "", f"{when(stop.time)} {name}{_lasting(history, stop)}{told}"
        before = f"{mode}: {why}"
    if len(history.stops) > _MOST:
        yield "", f"and {len(history.stops) - _MOST} more"


def recovered(history: History) -> str:
    """Return from which stops a run recovered, as the end of a sentence that says how it ended; "" if from none."""
    found = [stop for stop in history.stops if history.went_on(stop) is not None]
    if not found:
        return ""
    stop = found[0]
    mode = stop.mode.replace("_", " ")
    article = "an" if mode[0] in "aeiou" else "a"
    first = f"{article} {mode} at {when(stop.time)}{_lasting(history, stop)}"
    return f", after {first}" if len(found) == 1 else f", after {len(found)} stops, first {first}"


def _lasting(history: History, stop: Stopped) -> str:
    """Return for how long a stop lasted until the robot went on, or another one took its place."""
    went_on = history.went_on(stop)
    if went_on is None:
        return ""
    until = min([went_on, *(later.time for later in history.stops if later.time > stop.time)])
    return f" for {until - stop.time:.2f} s"


def _in_short(reason: str) -> str:
    """Return why the robot was stopped, without what follows the first colon if that is long."""
    return reason if len(reason) <= _SHORT else cut(reason.split(": ", maxsplit=1)[0], _SHORT)
