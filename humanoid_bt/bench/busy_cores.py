"""Load on all cores."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

_SETTLE = 1.0  # s until every process burns


@contextmanager
def load() -> Iterator[None]:
    """Keep every core busy with a process each while the context is open."""
    processes: list[subprocess.Popen[bytes]] = []
    try:
        for core in _cores():
            command = [sys.executable, "-P", "-m", "humanoid_bt.bench.stand_ins", "load", str(core)]
            processes.append(subprocess.Popen(command, stdin=subprocess.DEVNULL, start_new_session=True))
        time.sleep(_SETTLE)
        yield
    finally:
        for process in processes:
            process.kill()
        for process in processes:
            process.wait()


def _cores() -> list[int]:
    if hasattr(os, "sched_getaffinity"):
        return sorted(os.sched_getaffinity(0))
    return list(range(os.cpu_count() or 1))
