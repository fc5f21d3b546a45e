"""Explaining a run from its recording: the cause first, then what shows it, what led to it, and what would help."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from dataclasses import replace
from os import PathLike
from typing import Any

from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.record.reading import read_flight
from humanoid_bt.review.before import before, chosen
from humanoid_bt.review.cause import Cause, Row, unrepeated
from humanoid_bt.review.causes import STOPS, cause_of, control_log
from humanoid_bt.review.explanation import Explanation
from humanoid_bt.review.hints import CONTROL_LOG, EXPLAIN_JOINT, EXPLAIN_NODE, PAGE, hints
from humanoid_bt.review.history import History, Span
from humanoid_bt.review.joint import joint_explained
from humanoid_bt.review.life import life_explained
from humanoid_bt.review.moment import moment_explained
from humanoid_bt.review.scene import body_row, command_in_force, hand_row, joint_loads, joint_text, sight_rows
from humanoid_bt.review.staged import staged_before, staged_rows
from humanoid_bt.review.stops import stop_rows
from humanoid_bt.review.success import near_trouble
from humanoid_bt.review.words import cut, last, line_of, mentions, several, when

_BEFORE = 2.0  # s before the moment that are told
_AFTER = 10.0  # s after it in which control is followed
_SPANS = 4  # modes of control that are told
_SCREEN = 30  # lines
_MOST, _LEAST = 7, 2  # lines about what led up to it
_LOADED = 0.5  # share of a limit from which on a joint is worth a line


def explain(
    path: str | PathLike[str], *, at: float | None = None, node: str | None = None, joint: str | None = None
) -> Explanation:
    """Return why a run ended as it did; or with one of the further arguments what they ask for.

    Args:
        path: the run's recording.
        at: a time [s]: what was going on then.
        node: a node's name, or the end of its path: its life.
        joint: a joint's name: its extremes, and when it was limited.

    Raises:
        UserError: the file is no recording of a run, a name is in none of it, or several things are asked for.
    """
    if sum(asked is not None for asked in (at, node, joint)) > 1:
        raise UserError("only one of 'at', 'node' and 'joint' can be explained at a time")
    log = read_flight(path)
    history = History(log)
    if at is not None:
        return moment_explained(history, at)
    if node is not None:
        return life_explained(history, node)
    if joint is not None:
        return joint_explained(history, joint)
    return _explained(history, cause_of(history))


def _explained(history: History, cause: Cause) -> Explanation:
    """Return a cause with what shows it, what led to it, and what would help."""
    cause = replace(cause, headline=cause.headline + staged_before(history, cause))
    if cause.kind == "success":
        return Explanation(
            relative(history.log.path),
            cause.kind,
            cause.headline,
            cause.time,
            rows=list(unrepeated([*_damaged(history), *staged_rows(history), *near_trouble(history)])),
            data=_data(history, cause),
        )
    begin = (cause.time if cause.began is None else min(cause.began, cause.time)) - _BEFORE
    moments = before(history, max(begin, cause.time - 2 * _BEFORE), cause.time)
    found = Explanation(
        recording=relative(history.log.path),
        kind=cause.kind,
        headline=cause.headline,
        time=cause.time,
        node=cause.node,
        place=history.place(cause.node, cause.time),
        rows=list(_rows(history, cause)),
        title="before it",
        after=list(_after(history, cause)),
        data=_data(history, cause),
    )
    for most in range(_MOST, _LEAST - 1, -1):  # what matters least is left out until it fits
        found = replace(found, moments=chosen(moments, most))
        if len(found.text().splitlines()) <= _SCREEN:
            break
    return found


def _rows(history: History, cause: Cause) -> Iterator[Row]:
    yield "run", _run(history)
    yield from unrepeated([*_damaged(history), *staged_rows(history)])
    if cause.node:
        yield "node", f"{cause.node}  {line_of(history.place(cause.node, cause.time))}"
    yield from unrepeated(cause.rows)
    if told := command_in_force(history, cause.time):
        yield "command", cut(told, 240)
    hands = hand_row(history, cause.time)
    if hands and not any(name == "hand error" for name, _ in cause.rows):
        yield hands
    loads = joint_loads(history, cause.time)
    if loads and loads[0]["load"] >= _LOADED:
        yield "joint", joint_text(loads[0])
    yield from sight_rows(history, cause.time, cause.headline)
    yield body_row(history, cause.time)


def _run(history: History) -> str:
    setup, end = history.setup, history.end
    names = [part["name"] or "?" for part in (history.tree(), setup["robot"], setup["scene"])]
    what = f"{names[0]} on {names[1]} in {names[2]}, {setup['mode'] or '?'}"
    outcome = f": {end['outcome']} after {_lasted(history):.2f} s" if end else ": its end is not recorded"
    return f"{what}, seed {setup['seed']}{outcome}"


def _damaged(history: History) -> Iterator[Row]:
    yield from (("damaged", text) for text in history.damage)


def _lasted(history: History) -> float:
    ended = history.end.get("tree_ended")
    lasted = (history.until if ended is None else float(ended)) - history.ticked_from
    return max(lasted, 0.0)  # where control was lost, its last servo cycles may be, too


def _after(history: History, cause: Cause) -> Iterator[Row]:
    yield "control", modes_told(history, cause.time)
    if len(history.stops) > 1 or (history.stops and cause.kind not in STOPS):
        yield from stop_rows(history)
    file = shlex.quote(relative(history.log.path))
    yield "look", f"rerun {file}"
    yield "", f"and put the cursor of sim_time at {when(cause.time)}"
    for number, hint in enumerate(hints(cause.kind, _named(history, cause, file))):
        yield "helps" if number == 0 else "", hint
    yield "more", f"humanoid-bt explain --at {cause.time:.3f} {file}"
    yield "", PAGE


def _named(history: History, cause: Cause, file: str) -> dict[str, str]:
    """Return what hints speak of, as this run has it; "" where it has none."""
    log, node = control_log(history), shlex.quote(last(cause.node))
    joint = next((joint for joint in history.setup["robot"]["joints"] if mentions(cause.headline, joint)), "")
    return {
        CONTROL_LOG: relative(log) if log.is_file() else "",
        EXPLAIN_NODE: f"humanoid-bt explain --node {node} {file}" if cause.node else "",
        EXPLAIN_JOINT: f"humanoid-bt explain --joint {joint} {file}" if joint else "",
    }


def modes_told(history: History, time: float) -> str:
    """Return what the supervisor did around a time [s], to the millisecond."""
    spans = history.modes(time - _BEFORE, min(time + _AFTER, history.until))
    if not spans:
        return "no servo cycle of that time is recorded"
    ends = time + _AFTER >= history.until
    told = ", ".join(_span(span, number == 0, span is spans[-1], ends) for number, span in enumerate(spans[:_SPANS]))
    return told + (f", and {several(len(spans) - _SPANS, 'more change')}" if len(spans) > _SPANS else "")


def _span(span: Span, first: bool, final: bool, ends: bool) -> str:
    """Return a span of those that are told in words; the final one may go on after the time that was looked at."""
    mode = span.mode.replace("_", " ")
    until = f"to the end, {when(span.until)}" if ends else f"until {when(span.until)} and on"
    if first and final:
        return f"{mode} all the time, {until}"
    if first:
        return f"{mode} until {when(span.until)}"
    return f"{mode} from {when(span.begin)}" + (f" {until}" if final else "")


def _data(history: History, cause: Cause) -> dict[str, Any]:
    return {
        "outcome": history.end.get("outcome", ""),
        "reason": history.end.get("reason", ""),
        "recorded": [history.begin, history.until],
        "cut": history.log.cut,
        "damaged": history.log.damaged,
        "stops": [stop._asdict() for stop in history.stops],
        "modes": [span._asdict() for span in history.modes(cause.time - _BEFORE, cause.time + _AFTER)],
        "joints": joint_loads(history, cause.time)[:5],
        "percepts": [seen._asdict() for seen in history.sights(cause.time)],
    }
