"""``estop``, ``reset``, ``status``: reaching a robot that runs from another terminal.

Nothing heavy is imported here: these commands are wanted at once.
"""

from __future__ import annotations

import argparse
import contextlib
import getpass
import json
import os
import sys
import time
from typing import TYPE_CHECKING

from humanoid_bt.cli.output import hanging
from humanoid_bt.cli.runs import FoundRun, found_runs, one_run, titled
from humanoid_bt.link.estop import EStop, ResetAnswer
from humanoid_bt.link.run_folder import all_runs, clean_stale, in_lockstep
from humanoid_bt.link.segment import LinkError
from humanoid_bt.realtime import channels
from humanoid_bt.session.report import ExitCode

if TYPE_CHECKING:
    from humanoid_bt.realtime.status import RunStatus

_STOP_TIMEOUT = 1.0  # s that the robot gets to show that it is stopped
_ANSWER_TIMEOUT = 2.0  # s that control gets to answer a reset
_POLL = 0.0005  # s
_UNDECODED = 0.05  # s in which states are only collected: what decodes them takes longer to import
_STOPPED = ("emergency_stop", "damp")


def estop(arguments: argparse.Namespace) -> int:
    """Stop every running robot, or the one that is named; return the exit code."""
    runs = found_runs(arguments.run)
    source = _source("estop")
    pending: list[_Watch] = []
    missed = False
    for run in runs:  # all of them first, then see what became of it
        try:
            watch = _Watch(run)
            watch.raise_estop(source, arguments.reason)
        except LinkError as error:
            if run[0].folder.exists():  # else it has just ended
                missed = True
                print(f"{titled(run)} ({run[1].run_id}): not stopped: {error}", file=sys.stderr)
            continue
        pending.append(watch)
    if len(runs) > 1:
        print(f"{len(runs)} robots are running: all of them are stopped (--run ID stops one)")
    stopped = [watch.report() for watch in pending]
    return ExitCode.SUCCESS if all(stopped) and not missed else ExitCode.ERROR


class _Watch:
    """Raises the e-stop of one run and sees when it takes effect."""

    def __init__(self, run: FoundRun) -> None:
        folder = run[0]
        self._run = run
        self._estop = channels.estop(folder)
        self._states = channels.reader(folder, "state")
        latest = self._states.latest()
        self._seen = [(time.monotonic(), latest[1])] if latest else []
        self._sequence = latest[0] if latest else 0

    def raise_estop(self, source: str, reason: str) -> None:
        """Raise it."""
        self._raised_at = time.monotonic()
        self._estop.raise_(source, reason)

    def report(self) -> bool:
        """Wait until the robot is stopped; print how long it took, or that it is not."""
        name = f"{titled(self._run)} ({self._run[1].run_id})"
        while time.monotonic() - self._raised_at < _UNDECODED:
            self._collect()
            time.sleep(_POLL)
        from humanoid_bt.link.wire import decode_state

        while True:
            for at, payload in self._seen:
                state = decode_state(payload)
                if state.mode.value in _STOPPED:
                    what = state.mode.value.replace("_", " ")
                    if at < self._raised_at:
                        print(f"{name}: {what} since before: {state.stop_reason} ({state.stop_source})")
                    else:
                        print(f"{name}: {what} after {(at - self._raised_at) * 1000:.1f} ms")
                    return True
            self._seen.clear()
            if time.monotonic() - self._raised_at > _STOP_TIMEOUT:
                break
            time.sleep(_POLL)
            self._collect()
        if not self._run[0].folder.exists():
            print(f"{name}: the run has ended")
            return True
        text = f"{name}: the e-stop is raised, but the robot did not show within {_STOP_TIMEOUT:g} s that it stopped"
        if in_lockstep(self._run[0]):
            text += "; in lockstep time stands still while a skill hangs or a program pauses: its next step stops it"
        print(text, file=sys.stderr)
        return False

    def _collect(self) -> None:
        entries, _ = self._states.since(self._sequence)
        now = time.monotonic()
        for self._sequence, payload in entries:
            self._seen.append((now, payload))


def reset(arguments: argparse.Namespace) -> int:
    """Ask for a reset of a latched stop; print the answer; return the exit code."""
    folder, info = one_run(arguments.run, "reset")
    from humanoid_bt.realtime.status import status_of

    before = status_of(folder, info)
    if before.mode == "protective_stop" and before.estop is None:
        why = f"{before.stop_reason} ({before.stop_source})"
        print(f"refused: a protective stop ends when its cause does: {why}", file=sys.stderr)
        return ExitCode.STOPPED
    if before.mode not in _STOPPED and before.estop is None:
        print("nothing to reset: the robot is not stopped")
        return ExitCode.SUCCESS
    channel = channels.estop(folder)
    ticket = channel.request_reset(_source("reset"))
    answer = _answer(channel, ticket)
    if answer is None:
        why = f"control did not answer within {_ANSWER_TIMEOUT:g} s" if folder.folder.exists() else "the run has ended"
        print(f"error: {why}", file=sys.stderr)
        return ExitCode.ERROR
    if not answer.accepted:
        print(f"refused: {answer.reason}", file=sys.stderr)
        return ExitCode.STOPPED
    print(f"reset: {before.stop_reason} ({before.stop_source})")
    if channel.raised is not None:
        print(f"but stopped again: {channel.raised.reason} ({channel.raised.source})", file=sys.stderr)
        return ExitCode.STOPPED
    return ExitCode.SUCCESS


def _answer(channel: EStop, ticket: int) -> ResetAnswer | None:
    """Wait for control's answer to a reset; return None if there is none in time."""
    deadline = time.monotonic() + _ANSWER_TIMEOUT
    while (answer := channel.answer_to(ticket)) is None and time.monotonic() < deadline:
        channel.poll()
        time.sleep(_POLL)
    return answer


def status(arguments: argparse.Namespace) -> int:
    """Print how every running robot is doing, or the one that is named; return the exit code."""
    clean_stale()
    runs = all_runs() if arguments.json and arguments.run is None else found_runs(arguments.run)
    from humanoid_bt.realtime.status import status_of

    found = [status_of(*run) for run in runs]
    if arguments.json:
        print(json.dumps([one.to_dict() for one in found], indent=2))
        return ExitCode.SUCCESS
    print("\n\n".join(_described(one) for one in found))
    return ExitCode.SUCCESS


def _described(found: RunStatus) -> str:
    """Return how a robot is doing, for people."""
    stopped = f": {found.stop_reason} ({found.stop_source})" if found.stop_reason else ""
    rows = [
        ("run", found.run_id),
        ("tree", f"{found.tree} on {found.robot}, {'realtime' if found.timing else 'lockstep'}"),
        ("up", f"{found.uptime:.1f} s"),
        ("mode", found.mode.replace("_", " ") + stopped),
        ("node", found.node or "none"),
        ("", found.feedback),
        ("tree rate", f"{found.tick_rate:.1f} Hz" if found.tick_rate is not None else "no tick yet"),
    ]
    if timing := found.timing:
        late = f"late p50 {timing['late_p50']:.0f} us, p99 {timing['late_p99']:.0f} us, max {timing['late_max']:.0f} us"
        rows += [("servo", f"{timing['cycles']} cycles, {timing['missed']} deadlines missed"), ("", late)]
    if found.estop is not None and found.mode not in _STOPPED:
        rows.insert(4, ("e-stop", f"raised: {found.estop['reason']} ({found.estop['source']})"))
    rows += _table("leases", [f"{resource}: {node}" for resource, node in found.leases.items()])
    percepts = [f"{name}: {age:.2f} s old" for name, age in found.percepts.items()]
    rows += _table("percepts", percepts + [f"{name}: never seen, {why}" for name, why in found.unseen.items()])
    lines = [f"{role}: {p['pid']}{'' if p['alive'] else ' (dead)'}" for role, p in found.processes.items()]
    rows += _table("processes", lines)
    return "\n".join(_row(name, text) for name, text in rows if text)


def _row(name: str, text: str) -> str:
    return "\n".join(hanging(f"{name:<11}", text))


def _table(name: str, lines: list[str]) -> list[tuple[str, str]]:
    return [(name if number == 0 else "", line) for number, line in enumerate(lines or ["none"])]


def _source(command: str) -> str:
    """Return who this is, as the recording names it."""
    try:
        who = getpass.getuser()
    except (OSError, KeyError):  # a user id without a name
        who = str(os.geteuid())
    with contextlib.suppress(OSError, ValueError, AttributeError):  # not from a terminal
        who += "@" + os.ttyname(sys.stdin.fileno()).removeprefix("/dev/")
    return f"humanoid-bt {command} ({who}, pid {os.getpid()})"
