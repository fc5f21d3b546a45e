"""Processes that the bench starts beside control, so that they can be killed, stopped or spoilt while it lives.

Run as ``python -m humanoid_bt.bench.stand_ins ROLE ARGUMENT``, by the bench only.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import sys
import time
from types import FrameType

import numpy as np

from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.messages import BaseTarget, Command
from humanoid_bt.link.run_folder import RunFolder
from humanoid_bt.link.wire import decode_state, encode_command
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.schedule import Schedule

HANG, SPOIL = signal.SIGUSR1, signal.SIGUSR2
"""Signals to decision: hang for ever; send NaN, and with the next one good commands again."""

_DIE_WITH_PARENT = 1  # PR_SET_PDEATHSIG
_STEP = 0.3  # m that the robot walks to and fro
_STEP_TIME = 4.0  # s for each way
_SOURCE = "bench/walk"
_BLOCK = 1 << 22  # bytes that the load copies, more than a core's own cache


class _Decision:
    """Sends a command per tick, as decision does, and fails when it is told to."""

    def __init__(self, folder: RunFolder) -> None:
        self._states, self._commands = channels.reader(folder, "state"), channels.writer(folder, "command")
        self._quit = channels.quit_flag(folder)
        self._parent = os.getppid()
        self._spoilt = False
        signal.signal(HANG, self._hang)
        signal.signal(SPOIL, self._spoil)

    def run(self) -> None:
        """Let the robot walk to and fro until the run ends."""
        schedule = Schedule(DECISION_PERIOD, spin=False)
        while not self._quit.count and os.getppid() == self._parent:
            schedule.wait()
            latest = self._states.latest()
            if latest is not None:
                self._commands.write(encode_command(self._command(decode_state(latest[1]).time)))

    def _command(self, now: float) -> Command:
        forward = np.nan if self._spoilt else _STEP * (int(now / _STEP_TIME) % 2)
        target = BaseTarget(np.array([forward, 0.0]), 0.0)
        return Command(self._commands.sequence + 1, now, {"base": target}, {"base": _SOURCE})

    def _hang(self, _number: int, _frame: FrameType | None) -> None:
        while os.getppid() == self._parent:
            pass

    def _spoil(self, _number: int, _frame: FrameType | None) -> None:
        self._spoilt = not self._spoilt


def _raise_estops(folder: RunFolder) -> None:
    """Raise the e-stop for every line that comes in; answer with the monotonic time before [ns]."""
    estop = channels.estop(folder)
    for number, _ in enumerate(sys.stdin):
        began = time.monotonic_ns()
        estop.raise_("bench", f"measurement {number}")
        sys.stdout.write(f"{began}\n")
        sys.stdout.flush()


def _burn(core: int) -> None:
    """Keep a core and the memory busy."""
    with contextlib.suppress(AttributeError, OSError):
        os.sched_setaffinity(0, {core})
    parent, block = os.getppid(), bytearray(_BLOCK)
    while os.getppid() == parent:
        block = bytearray(block)
        sum(range(20_000))


def main() -> int:
    """Play the role that the first argument names."""
    role, argument = sys.argv[1:]
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the terminal's Ctrl-C is for the bench
    if sys.platform.startswith("linux"):  # also while it is stopped, when it could not notice itself
        ctypes.CDLL(None).prctl(_DIE_WITH_PARENT, signal.SIGKILL, 0, 0, 0)
    match role:
        case "decision":
            _Decision(channels.open_folder(argument)).run()
        case "estop":
            _raise_estops(channels.open_folder(argument))
        case "load":
            _burn(int(argument))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
