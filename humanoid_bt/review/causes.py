"""Why a run ended as it did: what came first and explains the rest."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.units import readable
from humanoid_bt.record.folder import log_beside
from humanoid_bt.record.reading import AT
from humanoid_bt.review import failures
from humanoid_bt.review.body import Motion
from humanoid_bt.review.cause import Cause
from humanoid_bt.review.history import COMMANDED, Happened, History, Stopped
from humanoid_bt.review.pushed import hardest_push
from humanoid_bt.review.stops import recovered
from humanoid_bt.review.weak_joint import gave_way, labouring
from humanoid_bt.review.words import cut, doing, last, line_of, when

STOPS = (
    "state",
    "fall",
    "push",
    "estop",
    "estop_node",
    "slow_tick",
    "silent",
    "refused",
    "sensor",
    "plant",
    "ik",
    "stop",
)
"""Kinds of causes that are stops."""

_LATCHED = ("state", "fall", "push", "estop", "estop_node")
_LOOK_BACK = 4.0  # s before a fall in which its reason is looked for
_SENSOR, _PLANT = "a sensor failed: ", "the plant "
_IN_THE_WAY = "something is in the way of the "
_GONE = "the process of the run ended without closing the recording"
_LABOURED = 1.0  # s before a stop in which a joint at its torque limit shows that the robot bears much
_SILENT = 0.08  # s that a tick must take to explain that decision was silent for 0.1 s
_SLOW = re.compile(r"a tick took (\d+) ms.*: the node '(.*?)'(?:, at (.*))?$")
_REFUSED = re.compile(r"refused (?:a command|(?P<more>\d+) more): (?P<fault>.*)", re.DOTALL)
_LATE = re.compile(r"stamped [\d.]+ s at")
_AGAIN = 1.1  # s after which what is refused for the same reason is something new: a second is told at once
_PERSON = ("keyboard", "humanoid-bt estop", "program", "test")


def cause_of(history: History) -> Cause:
    """Return why a run ended as it did."""
    ending = _ending(history)
    if ending.kind == "killed":
        return ending
    if stop := first_stop(history, ending.time):
        stop, began = _and_raised(history, stop, _of_stop(history, stop), ending.time)
        began = _and_fell(history, stop, began)
        if not history.end:
            return replace(began, headline=f"{began.headline}; {ending.headline}")
        return began if began.kind in _LATCHED or began.time < ending.time - AT else ending
    if history.stops and ending.kind in ("unfinished", "interrupted"):  # each was recovered, and nothing else is told
        began = _of_stop(history, history.stops[0])
        went_on = history.went_on(history.stops[0])
        then = f"; the robot went on at {when(went_on)}" if went_on is not None else ""
        if len(history.stops) > 1:  # each is listed, with how long it lasted
            then = f", the first of {len(history.stops)} times"
        return replace(began, headline=f"{began.headline}{then}; {ending.headline}")
    return ending


def _and_raised(history: History, stop: Stopped, cause: Cause, until: float) -> tuple[Stopped, Cause]:
    """Return what keeps a robot stopped, and why: an e-stop that was raised in a protective stop outlasts that."""
    raised = (later for later in history.stops if later.mode == "emergency_stop" and stop.time < later.time <= until)
    estop = next(raised, None)
    if estop is None or stop.mode != "protective_stop":
        return stop, cause
    found = _estop(history, estop)
    return estop, replace(found, headline=f"{found.headline}, in the protective stop since {when(stop.time)}")


def _and_fell(history: History, stop: Stopped, cause: Cause) -> Cause:
    """Return why a stopped robot lies, if it fell in the stop: a push that came later is what explains it."""
    fall = next((later for later in history.stops if later.mode == "damp" and later.time > stop.time), None)
    if fall is None or stop.mode == "damp":
        return cause
    fell = _fall(history, fall)
    if fell.began is not None and fell.began > stop.time:
        mode = stop.mode.replace("_", " ")
        return replace(fell, headline=f"{fell.headline}, in the {mode} since {when(stop.time)}")
    return replace(cause, headline=f"{cause.headline}; the robot fell at {when(fall.time)}")


def first_stop(history: History, time: float) -> Stopped | None:
    """Return the stop that still held the robot at a time [s], None if none did; the first of its chain."""
    chain: Stopped | None = None
    until = time
    now = history.modes(time - 0.05, time)
    ended_by_it = history.end.get("outcome") == "stopped"  # perhaps in the very servo cycle that the last tick saw
    if now and now[-1].mode in COMMANDED and not ended_by_it:
        return None
    for stop in reversed(history.stops):
        if stop.time > time + AT:
            continue
        if any(span.mode in COMMANDED for span in history.modes(stop.time + 2e-3, until)):
            break
        chain, until = stop, stop.time
    return chain


# ---- how it ended ---------------------------------------------------------------------------------------------------


def _ending(history: History) -> Cause:
    end = history.end
    if not end:
        return _without_end(history)
    time = end.get("tree_ended")
    time = history.until if time is None else float(time)
    outcome = end["outcome"]
    if outcome == "error":
        return _error(history, time)
    if outcome == "failure":
        return failures.failed(history, time)
    if outcome == "success":
        after, text = recovered(history), f"the run succeeded at {when(time)}"
        text = f"{text}{after}" if after else f"nothing stopped it: {text}"
        return Cause("success", f"{text}: {cut(end['reason'])}", time)
    if refused := _refusals(history, time):
        return refused
    return failures.without_result(history, time, outcome, end["reason"])


def _without_end(history: History) -> Cause:
    """The recording does not say how the run ended."""
    ticked = history.last_tick.state.time if history.last_tick else 0.0
    acting = doing(history.acting(ticked))
    during = f" while {acting} ran" if acting else ""
    if any(event.text == _GONE for event in history.events):
        rows = [("shown by", f"the last tick is of {when(ticked)}, servo cycles go on until {when(history.until)}")]
        stop = next((span for span in history.modes(ticked, ticked + 1.0) if span.mode not in COMMANDED), None)
        then = f"; control stopped the robot at {when(stop.begin)}" if stop else ""
        text = f"the program that runs the tree was killed after its tick of {when(ticked)}{during}{then}"
        return Cause("killed", text, ticked, _actor(history, ticked), [*rows, *_noted(history)])
    kind = "cut"
    if history.log.cut:
        why = "in the midst of a message: its disk was full, it may not grow, or the recorder was killed"
    elif history.damage:
        kind, why = "damaged", "and does not say how the run ended: it is damaged"
    else:
        why = "and does not say how the run ended: it is still being written, or the recorder was killed"
    text = f"the recording ends at {when(history.until)}, {why}"
    return Cause(kind, text, history.until, _actor(history, ticked), [])


def _error(history: History, time: float) -> Cause:
    """A node raised an exception, two nodes commanded one resource, or a process was lost."""
    end = history.end
    reason, line = cut(end["reason"], 300), end.get("line", "")
    if path := end.get("node", ""):
        where = f", in {line_of(line)}" if line else ""
        kind = "not_finite" if "must be finite" in end["error"] else "exception"
        text = f"'{last(path)}' raised {cut(end['error'], 160)} at {when(time)}{where}"
        return Cause(kind, text, time, path, [("raised at", line)] if line else [])
    if "commanded by two nodes at once" in reason:
        paths = re.findall(r"'([^']*/[^']*)'", reason)
        short = re.sub(r"'([^']*/[^']*)'", lambda found: f"'{last(found[1])}'", reason)
        rows = [("nodes", "; ".join(f"{path}  {history.place(path)}" for path in paths))]
        return Cause("conflict", f"{short}, at {when(time)}", time, paths[-1] if paths else "", rows)
    if "process" in reason and ("ended" in reason or "silent" in reason):
        who = "control" if "control" in reason else "a process of the run"
        silent = "silent" in reason  # and came back later
        at = time if silent else history.until
        text = f"{who} {'stalled' if silent else 'was lost'} at {when(at)}: {reason}"
        rows = [*_notices(history, at), *_noted(history)]
        acting = history.acting_last()
        return Cause("control", text, at, acting[-1].path if acting else "", rows)
    return Cause("error", f"{reason}, at {when(time)}", time, _actor(history, time), [])


# ---- stops ----------------------------------------------------------------------------------------------------------


def _of_stop(history: History, stop: Stopped) -> Cause:
    if stop.mode == "damp":
        return _limp(history, stop)
    if stop.mode == "emergency_stop":
        return _estop(history, stop)
    if stop.reason.startswith("decision silent"):
        return _silence(history, stop)
    return _protective(history, stop)


def _protective(history: History, stop: Stopped) -> Cause:
    text, commander = f"the robot was stopped at {when(stop.time)}", _commander(stop)
    if stop.reason.startswith(_IN_THE_WAY):
        return Cause("way", f"{_felt(history, stop)}: {text}", stop.time, commander)
    if stop.reason.startswith(_SENSOR):
        return Cause("sensor", f"a sensor failed, {stop.reason.removeprefix(_SENSOR)}: {text}", stop.time, commander)
    if stop.source == "supervisor" and stop.reason.startswith(_PLANT):
        return Cause("plant", f"{cut(stop.reason)}: {text}", stop.time, commander)
    if stop.source != "supervisor":
        return Cause("stop", f"{text}: {stop.reason} ({stop.source})", stop.time)
    return Cause("ik", f"{text}: {stop.reason}", stop.time, commander, _refused_rows(history, stop.time))


def _felt(history: History, stop: Stopped) -> str:
    """Return what was felt at a body: a load that the model does not know feels like something in the way."""
    reason = cut(stop.reason)
    if not (joint := labouring(history.log, stop.time - _LABOURED, stop.time)):
        return reason
    return f"{reason}, or it carries more than its model says, for {joint} was at its torque limit"


def _limp(history: History, stop: Stopped) -> Cause:
    if "falling" in stop.reason:
        return _fall(history, stop)
    text = f"the drives were let go at {when(stop.time)}: {stop.reason}"
    return Cause("state", text, stop.time, _commander(stop))


def _estop(history: History, stop: Stopped) -> Cause:
    if stop.source == "supervisor":
        text = f"{_felt(history, stop)}: the emergency stop was raised at {when(stop.time)}"
        return Cause("way", text, stop.time, _commander(stop))
    during = doing(history.acting(stop.time - DECISION_PERIOD))
    during = f" while {during} ran" if during else ""
    if stop.source in history.nodes(stop.time):
        text = f"'{last(stop.source)}' raised the emergency stop at {when(stop.time)}: {cut(stop.reason)}"
        return Cause("estop_node", text, stop.time, stop.source)
    by = f"by {stop.source}" if stop.source.startswith(_PERSON) else f"by {stop.source!r}"
    text = f"the emergency stop was raised at {when(stop.time)} {cut(by)}: {cut(stop.reason)}"
    return Cause(
        "estop",
        text,
        stop.time,
        _commander(stop) or _actor(history, stop.time - DECISION_PERIOD),
        [("while", during[7:])] if during else [],
    )


def _silence(history: History, stop: Stopped) -> Cause:
    """Decision sent nothing that control took: its tick took too long, or what it sent was refused."""
    refused = [  # not those that follow from the silence, or show it: what decision sent was on its way for too long
        one for one in _refused(history) if _is_near(one, stop.time, AT) and not _LATE.match(one.fault)
    ]
    slow = [
        (event, found)
        for event in history.events
        if (found := _SLOW.match(event.text)) and event.time <= stop.time + AT
    ]
    stopped = f"the robot was stopped at {when(stop.time)}"
    ticks = [tick for tick in history.log.ticks(stop.time - 0.5, stop.time) if tick.took >= _SILENT]
    if ticks:
        tick = ticks[-1]
        path, line = _slow_node(history, tick.state.time, slow)
        name = f" in '{last(path)}'" if path else ""
        where = f", {line_of(line)}" if line else ""
        text = f"one tick took {tick.took:.2f} s at {when(tick.state.time)}{name}{where}: {stopped}"
        return Cause("slow_tick", text, stop.time, path, [("shown by", f"{stop.reason}; a tick has 20 ms")])
    if refused:
        first = refused[0]
        text = f"commands were refused from {when(first.begin)} on: {cut(first.fault)}; {stopped}"
        return Cause("refused", text, first.begin, _named(history, first.fault) or _commander(stop), [])
    ticked = history.tick(stop.time)
    since = f"; the last tick before it is of {when(ticked.state.time)}" if ticked else ""
    text = f"{stopped}: {stop.reason}{since}"
    rows = [*_refused_rows(history, stop.time), *_notices(history, stop.time)]
    return Cause("silent", text, stop.time, _commander(stop), rows)


def _slow_node(history: History, time: float, told: list[tuple[Happened, re.Match[str]]]) -> tuple[str, str]:
    """Return which node a slow tick was in and the line of its skill, as far as it was told."""
    for event, found in reversed(told):
        if abs(event.time - time) < 1.0 or len(told) == 1:
            return found[2], found[3] or ""
    worst = (history.end.get("slow_ticks") or {}).get("worst") or {}
    if worst and abs(worst["time"] - time) < DECISION_PERIOD:
        return worst["node"], ""
    acting = history.acting(time)
    return (acting[-1].path, "") if len(acting) == 1 else ("", "")


def _fall(history: History, stop: Stopped) -> Cause:
    """The robot fell: a push that is known or seen, a joint that gave all it had, or what the numbers say."""
    begin = stop.time - _LOOK_BACK
    motion = Motion(history.log, begin, stop.time)
    commander = stop.resources.get("base", "") or _commander(stop)
    during = f" while '{last(commander)}' commanded the base" if "base" in stop.resources else ""
    fell = f"the robot fell at {when(stop.time)}"
    if not len(motion.time):
        return Cause("fall", f"{stop.reason}, at {when(stop.time)}{during}", stop.time, commander)
    height = f"its base was {motion.height[-1]:.2f} m high, tilted by {readable(float(motion.tilt[-1]), 'rad')}"
    rows = [("shown by", height)]
    known = hardest_push(history, motion, begin, stop.time)
    if known and not known.late:
        rows.insert(0, ("pushed", str(known)))
        return Cause("push", f"{fell}: {known.what}{during}", stop.time, commander, rows, known.begin)
    if push := motion.push():
        rows.insert(0, ("shown by", str(push)))
        text = f"{fell}: something pushed it {push.direction} at {push.begin:.2f} s{during}"
        return Cause("push", text, stop.time, commander, rows, push.begin)
    way = gave_way(history.log, begin, motion.lost, stop.time)
    if way and not way.late:
        rows.insert(0, ("shown by", str(way)))
        return Cause("fall", f"{fell}: {way.what}{during}", stop.time, commander, rows, way.begin)
    lost = f"it lost its balance at {when(motion.lost)}" if motion.settled else "it lost its balance"
    text = f"{fell}{during}: {height}; no push and no joint that gave way is seen before {lost}"
    after = sorted((of for of in (known, way) if of), key=lambda of: of.begin)
    rows += [("then", str(of)) for of in after]
    return Cause("fall", "; then ".join([text, *(of.what for of in after[:1])]), stop.time, commander, rows)


# ---- what is told beside --------------------------------------------------------------------------------------------


class _Refused(NamedTuple):
    """Commands that were refused for the same reason, one after the other: from when to when [s], and why."""

    begin: float
    until: float
    fault: str


def _refused(history: History) -> list[_Refused]:
    found: list[_Refused] = []
    for event in history.events:
        if (told := _REFUSED.match(event.text)) is None:
            continue
        if told["more"] and found and event.time - found[-1].until < _AGAIN:
            found[-1] = found[-1]._replace(until=event.time)
        else:
            found.append(_Refused(event.time, event.time, told["fault"]))
    return found


def _is_near(refused: _Refused, time: float, after: float) -> bool:
    """Return whether commands were refused in the second before a time, or until a little after it [s]."""
    return refused.begin <= time + after and refused.until > time - 1.0


def _refusals(history: History, time: float) -> Cause | None:
    """Commands were refused until the end, and the robot never obeyed."""
    refused = _refused(history)
    tick = history.tick(time)
    if not refused or tick is None or tick.state.command_sequence >= 0:
        return None
    first = refused[0]
    text = f"every command was refused from {when(first.begin)} on, so that the robot did nothing: {cut(first.fault)}"
    return Cause("refused", text, first.begin, _named(history, first.fault), [])


def _refused_rows(history: History, time: float) -> list[tuple[str, str]]:
    near = [one for one in _refused(history) if _is_near(one, time, after=1.0)]
    return [("refused", cut(f"from {when(one.begin)} on: {one.fault}", 200)) for one in near[:2]]


def _notices(history: History, time: float) -> list[tuple[str, str]]:
    return [
        ("told", cut(event.text, 200))
        for event in history.events
        if "stalled" in event.text and abs(event.time - time) < 2.0
    ]


def control_log(history: History) -> Path:
    """Return the file in which control notes what happens, in realtime mode."""
    return log_beside(history.log.path)


def _noted(history: History) -> list[tuple[str, str]]:
    """Return what control noted last, if it noted anything."""
    try:
        lines = control_log(history).read_text(encoding="utf-8").splitlines()[-2:]
        notes = [json.loads(line) for line in lines]
        return [("noted", cut(f"{when(note['time'])} {note['text']}")) for note in notes]
    except (OSError, ValueError, KeyError, TypeError):
        return []


def _named(history: History, text: str) -> str:
    """Return the node whose path stands in a text, "" if none does."""
    return next((path for path in re.findall(r"'([^']*/[^']*)'", text) if history.kind(path)), "")


def _commander(stop: Stopped) -> str:
    return next(iter(stop.resources.values()), "")


def _actor(history: History, time: float) -> str:
    acting = history.acting(time)
    return acting[-1].path if acting else ""
