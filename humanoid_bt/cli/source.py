"""Who raises an e-stop or asks for a reset from a terminal, as the recording names it."""

from __future__ import annotations

import contextlib
import getpass
import os
import sys


def source(command: str) -> str:
    """Return which command of which user in which terminal this is."""
    try:
        who = getpass.getuser()
    except (OSError, KeyError):  # a user id without a name
        who = str(os.geteuid())
    with contextlib.suppress(OSError, ValueError, AttributeError):  # not from a terminal
        who += "@" + os.ttyname(sys.stdin.fileno()).removeprefix("/dev/")
    return f"humanoid-bt {command} ({who}, pid {os.getpid()})"
