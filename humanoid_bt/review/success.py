"""What was near trouble in a run that succeeded."""

from __future__ import annotations

from collections.abc import Iterator

from humanoid_bt.review.body import clamped
from humanoid_bt.review.cause import Row
from humanoid_bt.review.failures import warned
from humanoid_bt.review.history import History
from humanoid_bt.review.stops import stop_rows
from humanoid_bt.review.words import last, several, when

_MOST = 3  # rows of a kind


def near_trouble(history: History) -> Iterator[Row]:
    """Yield stops that were recovered, slow ticks, lost percepts, warnings, and joints at limits."""
    yield from stop_rows(history)
    slow = history.end.get("slow_ticks") or {}
    if slow.get("count"):
        worst = slow["worst"]
        where = f" in '{last(worst['node'])}'" if worst["node"] else ""
        longest = f"the longest {worst['duration']:.3f} s at {worst['time']:.2f} s{where}"
        yield "slow", f"{several(slow['count'], 'tick')} took longer than 20 ms, {longest}"
    yield from _lost(history)
    stops = {f"{when(stop.time)} " for stop in history.stops}
    yield from (row for row in warned(history) if not row[1].startswith(tuple(stops)))
    joints = sorted(clamped(history.log), key=lambda joint: -joint.duration)
    if joints:
        told = ", ".join(f"{joint.joint} {joint.duration:.2f} s" for joint in joints[:_MOST])
        left = f" and {len(joints) - _MOST} more" if len(joints) > _MOST else ""
        first = when(min(joint.begin for joint in joints))
        yield "limits", f"setpoints were clamped: {told}{left}; the first at {first}"


def _lost(history: History) -> Iterator[Row]:
    """Yield how often conditions on percepts turned to failure after they had held, and watchdogs gave up."""
    found: dict[str, list[float]] = {}
    before: dict[str, str] = {}
    for change in history.changes:
        node, failed = history.kind(change.path, change.time), change.status == "FAILURE"
        kind = node.get("type")
        gave_up = kind == "watchdog" and failed and change.said
        doubtful = kind == "confident" and failed and before.get(change.path) == "SUCCESS"
        stale = node.get("branch") == "on_stale" and change.status == "RUNNING"
        if gave_up or doubtful or stale:
            found.setdefault(change.path, []).append(change.time)
        before[change.path] = change.status
    for path, times in list(found.items())[:_MOST]:
        often = "once" if len(times) == 1 else f"{len(times)} times"
        yield "percepts", f"'{last(path)}' found its percept lost or doubtful {often}, first at {when(times[0])}"
