"""How a process that was started here ended."""

from __future__ import annotations

import subprocess


def how_ended(process: subprocess.Popen[bytes]) -> str:
    """Return how a process that was started here ended, "" while it runs."""
    code = process.poll()
    if code is None:
        return ""
    return f"killed by signal {-code}" if code < 0 else f"exit code {code}"
