"""``explain --node``: the life of a node, from its beginning to its end, again and again."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

from humanoid_bt.core.errors import relative
from humanoid_bt.core.units import readable, shown_quantity
from humanoid_bt.record.reading import AT
from humanoid_bt.review.cause import Row
from humanoid_bt.review.explanation import Explanation, Moment
from humanoid_bt.review.history import HALTED, Change, History
from humanoid_bt.review.words import SIGNS, cut, last, target, when

_MOST = 12  # lives that are told
_ENDED = {"SUCCESS": "succeeded", "FAILURE": "failed", "INVALID": "was halted"}


class Life(NamedTuple):
    """A node ran: from when [s], the change that ended it or None, what it said last, and what it reported."""

    path: str
    begin: float
    end: Change | None
    said: str
    results: list[Any]


def life_explained(history: History, name: str) -> Explanation:
    """Return the life of the nodes that a name means.

    Raises:
        UserError: no node is named so.
    """
    paths = history.matching(name)
    lives = sorted((life for path in paths for life in _lives(history, path)), key=lambda life: life.begin)
    title = f"'{last(paths[0])}'" if len(paths) == 1 else f"'{name}' ({len(paths)} nodes)"
    final = lives[-1] if lives else None
    return Explanation(
        recording=relative(history.log.path),
        kind="node",
        headline=f"{title} {_summary(history, lives)}",
        time=(final.end.time if final.end else history.until) if final else None,
        node=paths[0],
        place=history.place(paths[0], _last_of(lives, paths[0])),
        rows=list(_rows(history, paths, lives)),
        title="its life" if len(lives) <= _MOST else f"its life, the last {_MOST} times of {len(lives)}",
        moments=[moment for life in lives[-_MOST:] for moment in _told(life, len(paths) > 1)],
        data={"lives": [_plain(life) for life in lives]},
    )


def _lives(history: History, path: str) -> Iterator[Life]:
    reported = list(history.results(path))
    begin: Change | None = None
    for change in history.changes:
        if change.path != path:
            continue
        if change.status == "RUNNING":
            begin = begin or change
            continue
        if begin is None and change.status == "INVALID" and not change.said:
            continue  # what it had answered is forgotten: its branch was left
        since = begin.time if begin else change.time
        found = [results for time, results in reported if since - AT <= time <= change.time + AT]
        yield Life(path, since, change, change.said, found[-1] if found else [])
        begin = None
    if begin is not None:
        found = [results for time, results in reported if time >= begin.time - AT]
        yield Life(path, begin.time, None, begin.said, found[-1] if found else [])


def _summary(history: History, lives: list[Life]) -> str:
    if not lives:
        return "never had its turn"
    life = lives[-1]
    often = "once" if len(lives) == 1 else f"{len(lives)} times, the last time"
    if life.end is None:
        silent = history.silent_since(history.until)
        when_last = "when the recording ended" if silent is None else f"in decision's last tick, at {when(silent)}"
        return f"ran {often}, from {when(life.begin)} on, and still ran {when_last}"
    if life.end.time - life.begin < AT:
        return f"was asked {often} at {when(life.begin)}: {_ended(life.end)}"
    return f"ran {often} from {when(life.begin)} to {when(life.end.time)}: {_ended(life.end)}"


def _ended(change: Change) -> str:
    """Return how a node ended, and what it said."""
    if change.said.startswith("raised "):
        return cut(change.said)
    return cut(f"{_ENDED[change.status]}: {change.said.removeprefix(HALTED)}")


def _rows(history: History, paths: list[str], lives: list[Life]) -> Iterator[Row]:
    for number, path in enumerate(paths[:3]):
        yield "node" if number == 0 else "", f"{path}  {history.place(path, _last_of(lives, path))}"
    time = _last_of(lives, paths[0])
    kind = history.kind(paths[0], time)
    values = {name: shown_quantity(history.value(value, time)) for name, value in kind.get("values", {}).items()}
    yield "type", ", ".join([kind.get("type", "?"), *(f"{name}: {value}" for name, value in values.items())])
    if lives:
        yield from _commanded(history, lives[-1])
        for number, (name, value, unit) in enumerate(lives[-1].results[:4]):
            yield "results" if number == 0 else "", f"{name.replace('_', ' ')} {readable(value, unit)}"


def _last_of(lives: list[Life], path: str) -> float:
    """Return when the last life of a node began [s], infinity if it had none: the tree of that time has it."""
    return max((life.begin for life in lives if life.path == path), default=math.inf)


def _commanded(history: History, life: Life) -> Iterator[Row]:
    """Yield what a node commanded at the begin and at the end of its life."""
    end = life.end.time if life.end else history.until
    for name, begin, until in (("first", life.begin, life.begin + 0.2), ("at last", end - 0.2, end)):
        found = [
            (tick.command.stamp, resource, tick.command.targets[resource])
            for tick in history.log.ticks(max(begin, life.begin), min(until, end) + AT)
            if tick.command is not None
            for resource, source in tick.command.sources.items()
            if source == life.path
        ]
        if found:
            stamp = found[0][0] if name == "first" else found[-1][0]
            yield (
                name,
                f"{when(stamp)}: " + ", ".join(target(resource, of) for at, resource, of in found if at == stamp),
            )


def _told(life: Life, named: bool) -> Iterator[Moment]:
    name = f"{life.path}  " if named else ""
    if life.end is None or life.end.time - life.begin > AT:
        yield Moment(life.begin, f"{SIGNS['RUNNING']} {name}began")
    if life.end is not None:
        took = f" (after {life.end.time - life.begin:.2f} s)" if life.end.time - life.begin > AT else ""
        yield Moment(life.end.time, f"{SIGNS[life.end.status]} {name}{_ended(life.end)}{took}")


def _plain(life: Life) -> dict[str, Any]:
    return {
        "path": life.path,
        "begin": life.begin,
        "end": life.end.time if life.end else None,
        "status": life.end.status if life.end else "RUNNING",
        "said": life.said,
        "results": life.results,
    }
