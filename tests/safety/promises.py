"""What docs/safety.md promises for a run that was struck, looked at when it is over."""

from __future__ import annotations

import signal
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from humanoid_bt.control.cycle_log import MODES
from humanoid_bt.control.supervisor import DECISION_TIMEOUT
from humanoid_bt.core.clock import cycles
from humanoid_bt.core.messages import Gait, Mode
from humanoid_bt.record.reading import FlightLog, read_flight
from humanoid_bt.review.explain import explain
from tests.realtime.helpers import until
from tests.safety.processes import Life
from tests.safety.strikes import Ending
from tests.safety.victim import HOLD, Victim

GROWTH = 48 << 20
"""How much more memory a process may take than when it had started [bytes]."""

RECORDER = 350 << 20
"""How much more a recorder may take, as docs/recording.md says [bytes]."""

_SILENT = cycles(DECISION_TIMEOUT)
_ENDED = {"interrupted", "percept_lost", "percept_doubtful"}
"""What ``explain`` says of a run that nothing stopped and somebody ended."""


def nothing_left(victim: Victim) -> None:
    """No process, no folder of links, no temporary file; what killed processes leave ``status`` removes."""
    if {"decision", "control"} <= victim.gone:
        until("its processes are gone", lambda: not victim.processes())
        victim.terminal("status")
    until(f"nothing is left, not even {victim.leftovers()}", lambda: not victim.leftovers())


def ended_as_told(victim: Victim, code: int, codes: Sequence[int]) -> None:
    """The exit code, the report, and no traceback.

    A second Ctrl-C can come as Python ends, which has put back the system's handler by then: the program dies of it,
    after its report. A shell shows 130 then as well.
    """
    if code == -signal.SIGINT and victim.has_report:
        code = 130
    assert code in codes, f"exit code {code}, not one of {list(codes)}"
    assert "Traceback" not in victim.output, "a traceback"
    if code < 0:
        assert not victim.has_report, "a program that was killed has reported"
        return
    report = victim.report
    assert report["exit_code"] == code, f"the report says exit code {report['exit_code']}"
    assert not report["fell"], "the robot fell"
    assert victim.lossy or report["recording_missing"] == 0, f"{report['recording_missing']} s are not recorded"


def stands(victim: Victim) -> None:
    """Control has brought the robot to a stand before it ended."""
    state = victim.state
    assert state.mode is not Mode.DAMP, "the robot fell"
    assert state.gait is Gait.STAND and state.base_settled, f"it ended in {state.gait.value}, not at rest"


def held_without_decision(victim: Victim) -> None:
    """Control has stopped the robot when decision was killed, held it for as long as it was told, and noted why."""
    told = [line["text"] for line in victim.log]
    assert any(text.startswith("protective_stop: decision silent") for text in told), "no stop of a dead decision"
    assert f"decision died; control holds the robot for {HOLD:g} s and ends" in told, "control did not notice"
    assert told[-1] == "control ended: decision died before", f"control noted last: {told[-1]}"
    noticed = next(line["time"] for line in victim.log if line["text"].startswith("decision died"))
    assert victim.log[-1]["time"] - noticed >= HOLD, "control did not hold the robot"


def silence_in_time(victim: Victim, log: FlightLog) -> int:
    """Every protective stop came in the servo cycle in which decision had been silent for as long as it may be.

    Counted in servo cycles, which no load of the machine changes: from the last new command, or from a stall of control
    itself after it.

    Returns:
        how many there were.
    """
    cycle, mode, command = log.cycles().columns["servo"].T
    heard = np.flatnonzero(np.diff(command)) + 1
    stalls = [round(1000 * line["time"]) for line in victim.log if line["text"].startswith("control stalled")]
    silent = [line for line in victim.log if line["text"].startswith("protective_stop: decision silent")]
    count = 0
    for stop in silent:
        row = int(np.searchsorted(cycle, round(1000 * stop["time"])))
        if row >= len(cycle) or not (heard < row).any():
            continue  # not recorded
        assert MODES[int(mode[row])] is Mode.PROTECTIVE_STOP, f"no stop at {stop['time']} s"
        since = cycle[heard[heard < row][-1]]
        since = next((stall for stall in stalls if since <= stall <= cycle[row]), since)
        assert abs(cycle[row] - since - _SILENT) <= 1, f"a stop after {cycle[row] - since:.0f} ms, at {stop['time']} s"
        count += 1
    return count


def recorded(victim: Victim) -> FlightLog:
    """The recording can be read, and has every servo cycle."""
    log = read_flight(victim.recording)
    assert not log.damaged, f"{log.damaged} blocks of the recording are damaged"
    steps = np.diff(log.cycles().columns["servo"][:, 0])
    told = "servo cycles are missing" in victim.output
    assert victim.lossy or told or (steps == 1).all(), f"{int((steps - 1).sum())} servo cycles are not recorded"
    return log


def explained(victim: Victim, ending: Ending) -> str:
    """``explain`` names what ended the run, or the stop that it was in."""
    found = explain(victim.recording)
    right = _right(victim, ending)
    assert found.kind in right, f"explain says {found.kind}, not one of {sorted(right)}: {found.headline}"
    return found.kind


def _right(victim: Victim, ending: Ending) -> set[str]:
    """Return the causes of which one is right, by what was done to the run and what control noted."""
    if victim.succeeded:  # what came then came too late
        return {"success", "cut"}
    if victim.cut:
        return {"cut"}
    stops: list[Mapping[str, Any]] = [line for line in victim.log if line["kind"] == "stop"]
    if ending.kinds:  # control that dies in a stop: the stop came first
        return {*ending.kinds, *(_kinds(stops[-1]) if victim.stopped and "control" in ending.kinds else ())}
    if victim.has_report:
        stops = [{"text": f"{stop['mode']}: {stop['reason']}"} for stop in victim.report["stops"]]
    return {*_kinds(stops[0]), *_kinds(stops[-1])} if stops else _ENDED


def _kinds(stop: Mapping[str, Any]) -> set[str]:
    mode, _, reason = str(stop["text"]).partition(": ")
    if mode == "emergency_stop":
        return {"estop"}
    return {"silent", "slow_tick"} if reason.startswith("decision silent") else {"stop"}


def memory_bounded(lives: Mapping[int, Life]) -> None:
    """No process has taken much more memory than when it had started."""
    for pid, life in lives.items():
        grown, bound = life.most - life.started, RECORDER if life.role == "recorder" else GROWTH
        assert grown <= bound, f"{life.role} ({pid}) grew by {grown >> 20} MB in {life.seen:g} s"
