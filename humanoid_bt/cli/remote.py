"""``reset``, ``status``: reaching a robot that runs from another terminal.

Nothing heavy is imported here: these commands are wanted at once.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from humanoid_bt.cli.estop import STOPPED
from humanoid_bt.cli.output import hanging
from humanoid_bt.cli.runs import found_runs, one_run
from humanoid_bt.cli.source import source
from humanoid_bt.core.errors import relative
from humanoid_bt.core.texts import one_line
from humanoid_bt.link.estop import EStop, ResetAnswer
from humanoid_bt.link.run_folder import all_runs, clean_stale
from humanoid_bt.realtime import channels
from humanoid_bt.session.report import ExitCode

if TYPE_CHECKING:
    from humanoid_bt.realtime.status import RunStatus

_ANSWER_TIMEOUT = 2.0  # s that control gets to answer a reset
_POLL = 0.0005  # s


def reset(arguments: argparse.Namespace) -> int:
    """Ask for a reset of a latched stop; print the answer; return the exit code."""
    folder, info = one_run(arguments.run, "reset")
    from humanoid_bt.realtime.status import status_of

    before = status_of(folder, info)
    if before.mode == "protective_stop" and before.estop is None:
        why = one_line(f"{before.stop_reason} ({before.stop_source})")
        print(f"refused: a protective stop ends when its cause does: {why}", file=sys.stderr)
        return ExitCode.STOPPED
    if before.mode not in STOPPED and before.estop is None:
        print("nothing to reset: the robot is not stopped")
        return ExitCode.SUCCESS
    channel = channels.estop(folder)
    ticket = channel.request_reset(source("reset"))
    answer = _answer(channel, ticket)
    if answer is None:
        why = f"control did not answer within {_ANSWER_TIMEOUT:g} s" if folder.folder.exists() else "the run has ended"
        print(f"error: {why}", file=sys.stderr)
        return ExitCode.ERROR
    if not answer.accepted:
        print(f"refused: {one_line(answer.reason)}", file=sys.stderr)
        return ExitCode.STOPPED
    print(f"reset: {one_line(f'{before.stop_reason} ({before.stop_source})')}")
    if channel.raised is not None:
        why = one_line(f"{channel.raised.reason} ({channel.raised.source})")
        print(f"but stopped again: {why}", file=sys.stderr)
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
        ("tree", f"{found.tree} on {found.robot} in {found.scene}, {'realtime' if found.timing else 'lockstep'}"),
        ("file", relative(Path(found.file)) if found.file else ""),
        ("recording", relative(Path(found.recording)) if found.recording else ""),
        ("up", f"{found.uptime:.1f} s"),
        ("mode", found.mode.replace("_", " ") + stopped),
        ("node", found.node or "none"),
        ("", found.feedback),
        ("tree rate", _rate(found)),
    ]
    if timing := found.timing:
        late = f"late p50 {timing['late_p50']:.0f} us, p99 {timing['late_p99']:.0f} us, max {timing['late_max']:.0f} us"
        rows += [("servo", f"{timing['cycles']} cycles, {timing['missed']} deadlines missed"), ("", late)]
        rows += [("cable", timing["cable"])]
    if found.estop is not None and found.mode not in STOPPED:
        rows.insert(6, ("e-stop", f"raised: {found.estop['reason']} ({found.estop['source']})"))
    rows += _table("leases", [f"{resource}: {node}" for resource, node in found.leases.items()])
    percepts = [f"{name}: {age:.2f} s old" for name, age in found.percepts.items()]
    rows += _table("percepts", percepts + [f"{name}: never seen, {why}" for name, why in found.unseen.items()])
    lines = [f"{role}: {p['pid']}{'' if p['alive'] else ' (dead)'}" for role, p in found.processes.items()]
    rows += _table("processes", lines)
    return "\n".join(_row(name, text) for name, text in rows if text)


def _rate(found: RunStatus) -> str:
    if found.silent is not None:
        return f"no tick for {found.silent:.1f} s: decision hangs or waits"
    return f"{found.tick_rate:.1f} Hz" if found.tick_rate is not None else "no tick yet"


def _row(name: str, text: str) -> str:
    return "\n".join(hanging(f"{name:<11}", text))


def _table(name: str, lines: list[str]) -> list[tuple[str, str]]:
    return [(name if number == 0 else "", line) for number, line in enumerate(lines or ["none"])]
