"""Children that a skill forks: they are not the robot's program, and must not run on as if they were.

A child that comes back from the skill, whatever way, would halt the tree, end control and close the recording of a
robot that is its parent's.
"""

from __future__ import annotations

import os
import signal
import traceback
from typing import NoReturn

astray = False
"""Whether this process was forked and has begun no tick of its own: it still is in the skill that forked it."""

if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=lambda: globals().update(astray=True))


def leave(error: BaseException) -> NoReturn:
    """End this process, a child, without anything that its parent does at its end.

    Args:
        error: what the child raised. The code of an exit is kept; all else is shown as Python does.
    """
    code = error.code if isinstance(error, SystemExit) else 1
    if not isinstance(error, SystemExit):
        traceback.print_exception(error)
    os._exit(code if isinstance(code, int) else int(code is not None))


def die_of(number: int) -> None:
    """Let a signal do to this process what it does to programs that do not handle it."""
    signal.signal(number, signal.SIG_DFL)
    os.kill(os.getpid(), number)
