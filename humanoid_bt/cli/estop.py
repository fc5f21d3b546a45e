"""``estop``: stopping every robot, by whatever is left of its run.

Raising needs nothing but the log of the e-stop. Telling what came of it needs the run's other files: where one is
missing or damaged the robot is stopped all the same, and it is told that nobody can see it from here.
Nothing heavy is imported here: it is wanted at once.
"""

from __future__ import annotations

import argparse
import contextlib
import sys
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

from humanoid_bt.cli.runs import chosen, identity, no_robot
from humanoid_bt.cli.source import source
from humanoid_bt.core.texts import one_line
from humanoid_bt.link.ring import RingReader
from humanoid_bt.link.run_folder import RunFolder, all_folders, in_lockstep
from humanoid_bt.link.segment import LinkError
from humanoid_bt.realtime import channels
from humanoid_bt.session.report import ExitCode

if TYPE_CHECKING:
    from humanoid_bt.core.messages import State

STOPPED = ("emergency_stop", "damp")
"""Modes in which an emergency stop is in force."""

_TIMEOUT = 1.0  # s that the robots get to show that they are stopped
_POLL = 0.0005  # s
_UNDECODED = 0.05  # s in which states are only collected: what decodes them takes longer to import


def estop(arguments: argparse.Namespace) -> int:
    """Stop every running robot, or the one that is named; return the exit code."""
    who = source("estop")
    problems: list[str] = []
    watches = [_Watch(folder) for folder in chosen(all_folders(problems), arguments.run, _run_id)]
    for watch in watches:  # all of them first, then see what became of it
        watch.raise_estop(who, arguments.reason)
    watches = [watch for watch in watches if watch.matters]
    for problem in problems:
        print(f"error: robots that run may not be stopped: {problem}", file=sys.stderr)
    if not watches and not problems:
        raise no_robot()
    if len(watches) > 1:
        print(f"{len(watches)} robots are running: all of them are stopped (--run ID stops one)")
    _observe(watches)
    stopped = [watch.report() for watch in watches]
    return ExitCode.SUCCESS if all(stopped) and not problems else ExitCode.ERROR


def _run_id(folder: RunFolder) -> str:
    return folder.folder.name


class _Watch:
    """Raises the e-stop of one run and sees when it takes effect.

    Args:
        folder: of the run; anything in it may be missing or damaged.
    """

    def __init__(self, folder: RunFolder) -> None:
        self._folder = folder
        self._name = identity(folder)  # before it is stopped, as the rest: a run that ends by it takes its folder along
        try:
            self._says, self._lived = True, folder.info.alive
        except LinkError:
            self._says, self._lived = False, self._may_move()
        self._stood = False  # it was raised before
        self._problem = ""  # why the e-stop is not raised
        self._unseen = ""  # why nobody can see what comes of it
        self._states: RingReader | None = None
        self._sequence = 0
        self._found: list[tuple[float, bytes]] = []  # what is not decoded yet
        self._stopped: tuple[float, State] | None = None
        self._first = True  # the state after which it was raised

    def raise_estop(self, who: str, reason: str) -> None:
        """Raise it; whatever prevents that is kept for the report."""
        self._who = who
        try:
            with contextlib.closing(channels.estop(self._folder, shared=True)) as channel:
                channel.poll()
                self._stood = channel.raised is not None
                self._raised_at = time.monotonic()
                channel.raise_(who, reason)
        except LinkError as error:
            self._raised_at = time.monotonic()
            self._problem = str(error)

    @property
    def matters(self) -> bool:
        """Whether a robot may walk there: neither a run that has ended, nor the folder of a dead one."""
        return self._lived and not (self._problem and (self._ended or not self._says))

    def _may_move(self) -> bool:
        try:
            with contextlib.closing(channels.reader(self._folder, "state")) as states:
                return states.has_writer
        except LinkError:
            return True

    @property
    def decided(self) -> bool:
        """Whether nothing more will be known."""
        return bool(self._stopped or self._problem or self._unseen) or self._ended

    @property
    def _ended(self) -> bool:
        return not self._folder.folder.exists()

    def collect(self) -> None:
        """Note which states came."""
        if self._states is None and not self._unseen:
            try:
                self._states = channels.reader(self._folder, "state")
                self._sequence = max(self._states.sequence - 1, 0)
            except LinkError as error:
                self._unseen = str(error)
        if self._states is not None:
            entries, _ = self._states.since(self._sequence)
            now = time.monotonic()
            for self._sequence, payload in entries:
                self._found.append((now, payload))

    def look(self) -> None:
        """See whether one of the states says that the robot is stopped."""
        from humanoid_bt.link.wire import WireError, decode_state

        found, self._found = self._found, []
        for at, payload in found:
            try:
                state = decode_state(payload)
            except WireError as error:
                self._unseen = str(error)
                continue
            if state.mode.value in STOPPED and self._stopped is None:
                before = self._first and (self._stood or state.stop_source != self._who)
                self._stopped = 0.0 if before else at, state
            self._first = False

    def report(self) -> bool:
        """Print how long it took, or that nobody knows; return whether the robot is stopped, or gone."""
        name, ended = self._name, self._ended
        if self._problem:
            print(f"{name}: not stopped: {self._problem}", file=sys.stderr)
            return False
        if self._stopped is not None:
            at, state = self._stopped
            what = state.mode.value.replace("_", " ")
            if at:
                what += f" after {(at - self._raised_at) * 1000:.1f} ms"
                print(f"{name}: {what}{', which ended the run' if ended else ''}")
            else:
                print(f"{name}: {what} since before: {one_line(f'{state.stop_reason} ({state.stop_source})')}")
            return True
        if ended:
            print(f"{name}: {'the run has ended' if self._stood else 'this stop ended the run'}")
            return True
        if self._unseen:
            why = f"whether the robot stopped cannot be seen: {self._unseen}"
        else:
            why = f"the robot did not show within {_TIMEOUT:g} s that it stopped"
            if in_lockstep(self._folder):
                why += "; in lockstep time stands still while a skill hangs or a program pauses: its next step stops it"
        print(f"{name}: the e-stop is raised, but {why}", file=sys.stderr)
        return False


def _observe(watches: Sequence[_Watch]) -> None:
    """See what becomes of all of them at the same time, so that each one's own time is told."""
    began = time.monotonic()
    while time.monotonic() - began < _UNDECODED:
        for watch in watches:
            watch.collect()
        time.sleep(_POLL)
    while True:
        for watch in watches:
            watch.collect()
            watch.look()
        if all(watch.decided for watch in watches) or time.monotonic() - began > _TIMEOUT:
            return
        time.sleep(_POLL)
