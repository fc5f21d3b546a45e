"""Why a tree failed, or came to no result: a time-out, a percept lost or doubtful, a hand that got no nearer."""

from __future__ import annotations

import itertools
import re
from dataclasses import replace

from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.units import readable
from humanoid_bt.record.reading import AT
from humanoid_bt.review import instead
from humanoid_bt.review.body import Motion
from humanoid_bt.review.cause import Cause, Row
from humanoid_bt.review.history import Change, History
from humanoid_bt.review.staged import PREFIX
from humanoid_bt.review.words import cut, doing, last, line_of, reported, when

_FLAPS = 4  # changes of a condition that are more than a change of mind
_FLAPPING = 5.0  # s in which they count
_LOOPS = ("for_each", "keep_running_until_failure", "repeat", "retry")  # ask a condition anew in each round
_STRUGGLE = 1.0  # s before a failure in which a joint at its torque limit explains it
_STRUGGLED = 0.2  # s that it must have been there
_WARNINGS = 3  # that are told
_SCENE = 1.0  # s around the last sight in which perception or the scene's script explains that nothing followed
_NEVER = "was never seen"  # is said of a percept that never came
_BLIND = ("the perception process ended", "the percept source")  # what is told when perception fails
_TIME_UP = "the tree still ran after "  # is why a run ends whose time is up
_STILL_RAN = re.compile(_TIME_UP + r".* s at '(?P<path>.*?)' \((?!running\))(?P<said>.*)\); ", re.DOTALL)
"""How a run's end tells what a node said that still ran; "running" is that of one that said nothing."""


def failed(history: History, time: float) -> Cause:
    """Return why a tree failed at a time [s]."""
    decided = history.decided
    if decided is None or decided.status != "FAILURE" or abs(decided.time - time) > AT:
        return Cause("failed", f"the tree failed at {when(time)}: {cut(history.end['reason'])}", time)
    if flap := flapping(history, time, decided.path):
        return flap
    kind = str(history.kind(decided.path, time).get("type", ""))
    if kind == "watchdog" or _NEVER in decided.said:
        return _lost(history, decided)
    return {"timeout": _timed_out, "confident": _doubted}.get(kind, _skill_failed)(history, decided)


def _doubted(history: History, change: Change) -> Cause:
    """A percept was not sure enough."""
    scene = scene_rows(history, change.time, change.time)
    why = f" ({scene[-1][1]})" if scene else ""
    text = f"'{last(change.path)}' failed at {when(change.time)}: the percept was doubtful, {cut(change.said)}{why}"
    return Cause("percept_doubtful", text, change.time, change.path, scene)


def _skill_failed(history: History, change: Change) -> Cause:
    """A skill failed: perhaps a joint had no more to give, or a hand came no nearer."""
    motion = Motion(history.log, change.time - _STRUGGLE, change.time)
    struggling = [joint for joint in motion.limited() if joint.what == "torque" and joint.duration >= _STRUGGLED]
    reported = [result for _, found in history.results(change.path, change.time, change.time) for result in found]
    results = {name: (value, unit) for name, value, unit in reported}
    said = cut(change.said.split(";")[0])
    text = f"'{last(change.path)}' failed at {when(change.time)}" + f": {said}" * bool(said)
    rows: list[Row] = [(name.replace("_", " "), readable(*of)) for name, of in results.items()]
    if struggling:
        moved, before = _moved(history, change), _at_limit_before(history, change)
        most = max(struggling, key=lambda of: (of.joint in moved, of.joint not in before, of.duration))
        rows.insert(0, ("shown by", f"{most}, in the {_STRUGGLE:g} s before"))
        return Cause(
            "torque_limit",
            f"{text}; {most.joint} was at its torque limit, {most.limit:g} Nm",
            change.time,
            change.path,
            rows,
        )
    if "hand_error" in results:
        errors = [
            value
            for _, found in history.results(change.path, change.time - 1.0, change.time)
            for name, value, _ in found
            if name == "hand_error"
        ]
        if errors:
            nearest, farthest = readable(min(errors), "m"), readable(max(errors), "m")
            rows.append(("shown by", f"the hand was {nearest} to {farthest} away in the last second"))
        return Cause("out_of_reach", text, change.time, change.path, rows)
    return Cause("failed", text, change.time, change.path, rows)


def _moved(history: History, change: Change) -> set[str]:
    """Return the joints of the arms that a node commanded when it failed."""
    tick = history.tick(change.time - DECISION_PERIOD)
    sources = tick.command.sources if tick and tick.command else {}
    arms: dict[str, list[str]] = history.setup["robot"]["arms"]
    return {joint for resource, path in sources.items() if path == change.path for joint in arms.get(resource, [])}


def _at_limit_before(history: History, change: Change) -> set[str]:
    """Return the joints that were at their torque limits when the node began that changed: not for its sake."""
    began = history.running(change.time - DECISION_PERIOD).get(change.path)
    if began is None:
        return set()
    motion = Motion(history.log, began.time - _STRUGGLE, began.time)
    return {joint.joint for joint in motion.limited() if joint.what == "torque"}


def _timed_out(history: History, change: Change) -> Cause:
    acting = history.acting(change.time - DECISION_PERIOD)
    before = [one for one in acting if one.path.startswith(change.path + "/")]
    still = ""
    if before:
        still = f" while {doing(before)} still ran{_said_last(history, before[-1], change.time)}"
    said = cut(change.said.replace("timed out", "ran out of time"))
    text = f"'{last(change.path)}' {said} at {when(change.time)}{still}"
    rows: list[Row] = stale_rows(history, change.time - DECISION_PERIOD)
    return Cause("timeout", text, change.time, before[-1].path if before else change.path, rows)


def _said_last(history: History, acting: Change, time: float) -> str:
    """Return what a node said last that ran until a time [s], as it follows its name; "" if it said nothing.

    That is what it reported, or what the run's end says of it; if neither, what it said as it began to run.
    """
    results = [found for _, found in history.results(acting.path, time - 0.1, time)]
    if results and results[-1]:
        said = reported(results[-1][:2])
    elif (told := _STILL_RAN.match(history.end["reason"])) and told["path"] == acting.path:
        said = told["said"]
    else:
        said = f"at first: {acting.said}" if acting.said else ""
    return f" ({cut(said)})" if said else ""


def _lost(history: History, change: Change) -> Cause:
    """A percept that was needed was lost, or never seen."""
    time = change.time
    name = str(change.said.split("'")[1]) if change.said.count("'") >= 2 else "a percept"
    if _NEVER in change.said:
        text = f"{cut(change.said)}: '{last(change.path)}' failed at {when(time)}"
        return Cause("percept_lost", text, time, change.path, scene_rows(history, 0.0, time))
    since = _last_seen(history, name, time)
    seen = f"was last seen at {since:.2f} s" if since is not None else "was lost"
    why, rows = _unseen(history, time if since is None else since, time)
    text = f"'{name}' {seen}{why}: '{last(change.path)}' failed at {when(time)}"
    untold = [row for row in rows if row[1] not in why]
    return Cause("percept_lost", text, time, change.path, [("shown by", cut(change.said)), *untold], since)


def _unseen(history: History, begin: float, end: float) -> tuple[str, list[Row]]:
    """Return why nothing was seen between two times [s], as it follows a text, and what shows it.

    Perception that failed explains it; if it did not, the scene's script may.
    """
    rows = [
        ("perception", f"{cut(event.text)} at {event.time:.2f} s")
        for event in history.events
        if begin - _SCENE <= event.time <= end + AT and event.text.startswith(_BLIND)
    ]
    scene = scene_rows(history, begin, end)
    why = rows[0] if rows else scene[-1] if scene else None
    return f", {why[1]}" if why else "", [*rows, *scene]


def _last_seen(history: History, name: str, time: float) -> float | None:
    return next((percept.stamp for percept in history.log.seen_before(time) if percept.name == name), None)


def without_result(history: History, time: float, outcome: str, reason: str) -> Cause:
    """Return why a run ended without a result at a time [s]: its time was up, or somebody ended it."""
    acting = history.acting_last()
    actor = acting[-1].path if acting else ""
    stale = stale_rows(history, time - DECISION_PERIOD)
    if flap := flapping(history, time):
        return flap
    if stale:
        began, text = _stale_since(history, time - DECISION_PERIOD)
        return Cause("percept_lost", f"{text}; the run ended at {when(time)}", began, actor, stale, began)
    if change := instead.failed_for_a_percept(history):
        doubted = history.kind(change.path).get("type") == "confident" and _NEVER not in change.said
        cause = (_doubted if doubted else _lost)(history, change)
        ran = f"{doing(acting)} ran to the end, {when(time)}" if acting else f"the run ended at {when(time)}"
        return replace(cause, headline=f"{cause.headline}; {ran}")
    during = f" while {doing(acting)} ran" if acting else ""
    rows = warned(history)
    if not reason.startswith(_TIME_UP):
        kind = "interrupted" if outcome == "interrupted" else "unfinished"
        return Cause(kind, f"the run was ended at {when(time)}{during}: {cut(reason)}", time, actor, rows)
    limit = history.setup["duration"]
    said = _said_last(history, acting[-1], time) if acting else ""
    up = f"its {limit:g} s were up" if limit else "its time was up"
    return Cause("unfinished", f"the run was ended at {when(time)}, {up}{during}{said}", time, actor, rows)


def warned(history: History) -> list[Row]:
    """Return the first warnings of a run that tell of more than how it ended."""
    told = ("the tree ended", PREFIX)
    found = [event for event in history.events if event.level != "info" and not event.text.startswith(told)]
    return [("warned", f"{when(event.time)} {cut(event.text)}") for event in found[:_WARNINGS]]


def stale_rows(history: History, time: float) -> list[Row]:
    """Return which watchdogs waited for their percept at a time [s]."""
    rows: list[Row] = []
    for path in _stale(history, time):
        began = history.running(time)[path]
        rows.append(("lost", f"'{last(path)}' of {line_of(history.place(path, time))} ran from {when(began.time)} on"))
        rows += _unseen(history, began.time, began.time)[1]
    return rows


def _stale_since(history: History, time: float) -> tuple[float, str]:
    path = _stale(history, time)[0]
    began = history.running(time)[path]
    nodes = list(history.nodes(time).values())
    watchdog = nodes[history.kind(path, time)["parent"]]
    name = str(history.value(watchdog["values"].get("percept", "the percept"), time))
    since = _last_seen(history, name, began.time)
    seen = f"was last seen at {since:.2f} s" if since is not None else "was not seen"
    why, _ = _unseen(history, began.time if since is None else since, began.time)
    return began.time, f"'{name}' {seen}{why}: '{last(path)}' ran instead from {when(began.time)} on"


def _stale(history: History, time: float) -> list[str]:
    """Return the nodes that ran at a time [s] because a percept was lost."""
    nodes = history.nodes(time)
    return [path for path in history.running(time) if nodes.get(path, {}).get("branch") == "on_stale"]


def flapping(history: History, time: float, decided: str = "") -> Cause | None:
    """Return the condition that changed its mind again and again before a time [s], None if none did.

    Args:
        history: of the run.
        time: when.
        decided: the node that decided how the tree ended; then only it counts, and what the node above asks beside it.
    """
    found: dict[str, list[int]] = {}
    for number, change in enumerate(history.changes):
        recent = time - _FLAPPING <= change.time <= time + AT and change.status in ("SUCCESS", "FAILURE")
        beside = not decided or decided == change.path or decided.startswith(_above(change.path) + "/")
        if recent and beside and history.kind(change.path, change.time).get("kind") == "condition":
            found.setdefault(change.path, []).append(number)
    flips = {path: _flips(history, numbers) for path, numbers in found.items()}
    path, changes = max(flips.items(), key=lambda item: len(item[1]), default=("", []))
    if len(changes) < _FLAPS:
        return None
    first, end = changes[0][0], changes[-1][1]
    told = ", then ".join(cut(change.said, 40) for change in changes[-1])
    text = f"'{last(path)}' changed its mind {len(changes)} times from {first.time:.2f} to {end.time:.2f} s: {told}"
    return Cause("percept_doubtful", text, end.time, path, [], first.time)


def _flips(history: History, numbers: list[int]) -> list[tuple[Change, Change]]:
    """Return the changes of a condition's mind among its changes; a loop that asks it anew in a round is none."""
    return [
        (history.changes[before], history.changes[after])
        for before, after in itertools.pairwise(numbers)
        if history.changes[before].status != history.changes[after].status and not _in_rounds(history, before, after)
    ]


def _in_rounds(history: History, before: int, after: int) -> bool:
    """Return whether a loop is the deepest node that ran on between two changes of a node below it."""
    change = history.changes[after]
    ended = {one.path for one in history.changes[before + 1 : after] if one.status != "RUNNING"}
    above = _above(change.path)
    while above in ended:
        above = _above(above)
    return history.kind(above, change.time).get("type") in _LOOPS


def _above(path: str) -> str:
    """Return the path of the node above a node."""
    return path.rpartition("/")[0]


def scene_rows(history: History, begin: float, end: float) -> list[Row]:
    """Return what the scene's script did around these times [s]."""
    inside = (event for event in history.events if begin - _SCENE <= event.time <= end + AT)
    return [
        ("scene", f"{event.text.removeprefix('scene: ')} at {event.time:.2f} s (the scene's script)")
        for event in inside
        if event.text.startswith("scene: ")
    ]
