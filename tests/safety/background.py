"""Load beside a run: processes that only compute, and one that goes through memory again and again.

They end by themselves when whoever started them is gone.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from collections.abc import Iterator

_BUSY = "while os.getppid() == parent: sum(range(100000))"
_CHURN = """
while os.getppid() == parent:
    memory = bytearray({size})
    for at in range(0, len(memory), 4096): memory[at] = 1
"""
_SIZE = 256 << 20  # bytes
CORES = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1

LOADS: dict[str, tuple[int, int]] = {"no": (0, 0), "cpu": (CORES, 0), "memory": (0, 1), "cpu and memory": (CORES, 1)}
"""Name of a load -> how many processes compute, and how many go through memory."""


@contextlib.contextmanager
def load(name: str) -> Iterator[None]:
    """Have the machine busy meanwhile."""
    busy, churning = LOADS[name]
    codes = [_BUSY] * busy + [_CHURN.format(size=_SIZE)] * churning
    begin = f"import os; parent = {os.getpid()}\n"
    started = [subprocess.Popen([sys.executable, "-c", begin + code]) for code in codes]
    try:
        yield
    finally:
        for process in started:
            process.kill()
        for process in started:
            process.wait()
