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
import textwrap
import time

from humanoid_bt.cli.runs import one_robot, robots
from humanoid_bt.link.run_folder import RunFolder, RunInfo
from humanoid_bt.link.segment import LinkError
from humanoid_bt.realtime import channels
from humanoid_bt.session.report import ExitCode

_STOP_TIMEOUT = 1.0  # s that the robot gets to show that it is stopped
_ANSWER_TIMEOUT = 2.0  # s that control gets to answer a reset
_POLL = 0.0005  # s
_UNDECODED = 0.05  # s in which states are only collected: what decodes them takes longer to import
_STOPPED = ("emergency_stop", "damp")
_WIDTH = 60


def estop(arguments: argparse.Namespace) -> int:
    """Stop every running robot, or the one that is named; return the exit code."""
    runs = robots(arguments.run)
    source = _source("estop")
    pending = []
    for folder, info in runs:  # all of them first, then see what became of it
        try:
            watch = _Watch(folder, info)
            watch.raise_estop(source, arguments.reason)
        except LinkError as error:
            print(f"{info.run_id}: not stopped: {error}", file=sys.stderr)
            continue
        pending.append(watch)
    if len(runs) > 1:
        print(f"{len(runs)} robots are running: all of them are stopped (--run ID stops one)")
    stopped = [watch.report() for watch in pending]
    return ExitCode.SUCCESS if len(stopped) == len(runs) and all(stopped) else ExitCode.ERROR


class _Watch:
    """Raises the e-stop of one run and sees when it takes effect."""

    def __init__(self, folder: RunFolder, info: RunInfo) -> None:
        self._info = info
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
        name = f"{self._info.tree} on {self._info.robot} ({self._info.run_id})"
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
        text = f"{name}: the e-stop is raised, but the robot did not show within {_STOP_TIMEOUT:g} s that it stopped"
        print(text, file=sys.stderr)
        return False

    def _collect(self) -> None:
        entries, _ = self._states.since(self._sequence)
        now = time.monotonic()
        for self._sequence, payload in entries:
            self._seen.append((now, payload))


def reset(arguments: argparse.Namespace) -> int:
    """Ask for a reset of a latched stop; print the answer; return the exit code."""
    folder, info = one_robot(arguments.run, "reset")
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
    deadline = time.monotonic() + _ANSWER_TIMEOUT
    while (answer := channel.answer_to(ticket)) is None:
        if time.monotonic() > deadline:
            print(f"error: control did not answer within {_ANSWER_TIMEOUT:g} s", file=sys.stderr)
            return ExitCode.ERROR
        channel.poll()
        time.sleep(_POLL)
    if not answer.accepted:
        print(f"refused: {answer.reason}", file=sys.stderr)
        return ExitCode.STOPPED
    print(f"reset: {before.stop_reason} ({before.stop_source})")
    if channel.raised is not None:
        print(f"but stopped again: {channel.raised.reason} ({channel.raised.source})", file=sys.stderr)
        return ExitCode.STOPPED
    return ExitCode.SUCCESS


def status(arguments: argparse.Namespace) -> int:
    """Print how a running robot is doing; return the exit code."""
    folder, info = one_robot(arguments.run, "status")
    from humanoid_bt.realtime.status import status_of

    found = status_of(folder, info)
    if arguments.json:
        print(json.dumps(found.to_dict(), indent=2))
        return ExitCode.SUCCESS
    stopped = f": {found.stop_reason} ({found.stop_source})" if found.stop_reason else ""
    timing = found.timing
    rows = [
        ("run", found.run_id),
        ("tree", f"{found.tree} on {found.robot}"),
        ("up", f"{found.uptime:.1f} s"),
        ("mode", found.mode.replace("_", " ") + stopped),
        ("node", found.node or "none"),
        ("", found.feedback),
        ("tree rate", f"{found.tick_rate:.1f} Hz" if found.tick_rate is not None else "no tick yet"),
        ("servo", f"{timing['cycles']} cycles, {timing['missed']} deadlines missed"),
        ("", f"late p50 {timing['late_p50']:.0f} us, p99 {timing['late_p99']:.0f} us, max {timing['late_max']:.0f} us"),
    ]
    if found.estop is not None and found.mode not in _STOPPED:
        rows.insert(4, ("e-stop", f"raised: {found.estop['reason']} ({found.estop['source']})"))
    rows += _table("leases", [f"{resource}: {node}" for resource, node in found.leases.items()])
    percepts = [f"{name}: {age:.2f} s old" for name, age in found.percepts.items()]
    rows += _table("percepts", percepts + [f"{name}: never seen, {why}" for name, why in found.unseen.items()])
    lines = [f"{role}: {p['pid']}{'' if p['alive'] else ' (dead)'}" for role, p in found.processes.items()]
    rows += _table("processes", lines)
    for name, text in rows:
        if text:
            print("\n".join(textwrap.wrap(text, _WIDTH, initial_indent=f"{name:<11}", subsequent_indent=" " * 11)))
    return ExitCode.SUCCESS


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
