"""What the processes beside decision and control have in common: how they begin, how long they work, how they end."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator

from humanoid_bt.core.errors import UserError
from humanoid_bt.link.run_folder import RunFolder
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.channels import RunSpec
from humanoid_bt.realtime.schedule import Schedule


def take_part(run: Callable[[RunFolder], None]) -> int:
    """Take part in the run whose folder is the first argument, and return the exit code.

    Args:
        run: the work; a ``UserError`` in it is left for decision, which tells it.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the terminal's Ctrl-C is for decision
    folder = channels.open_folder(sys.argv[1])
    try:
        run(folder)
    except UserError as error:
        channels.leave_mistakes(folder, error)
        return 2
    return 0


def turns(folder: RunFolder, spec: RunSpec, period: float) -> Iterator[None]:
    """Yield once in a period [s], until decision ends the run or dies."""
    quit_flag, schedule = channels.quit_flag(folder), Schedule(period, spin=False)
    while not quit_flag.count and os.getppid() == spec.parent:
        schedule.wait()
        yield
