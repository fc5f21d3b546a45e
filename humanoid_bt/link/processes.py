"""Which process is meant: its id alone is given to another process sooner or later; and how one ended."""

from __future__ import annotations

import os
import subprocess
from dataclasses import dataclass
from pathlib import Path

_PROC = Path("/proc")
_STATE_FIELD, _START_FIELD = 0, 19  # of /proc/<pid>/stat after the command's closing parenthesis; see proc(5)
_DEAD_STATES = "ZX"


@dataclass(frozen=True, slots=True)
class ProcessIdentity:
    """A process, told apart from every later one with the same id.

    Attributes:
        pid: its id.
        started: its start time as the kernel counts it, "" where that cannot be known.
        namespace: in which its id counts (a container has its own), "" where there is only one.
    """

    pid: int
    started: str
    namespace: str

    @classmethod
    def of(cls, pid: int) -> ProcessIdentity:
        """Return the identity of a process; ``started`` is "" if there is none."""
        return cls(pid, _started(pid), _namespace())

    @property
    def alive(self) -> bool:
        """Whether it still runs; a zombie does not. True if that cannot be known from here."""
        if self.namespace != _namespace():
            return True
        if not _exists(self.pid):
            return False
        started = _started(self.pid)
        if started or _PROC_STAT:
            return bool(started) and started == (self.started or started)
        return True


def current() -> ProcessIdentity:
    """Return the identity of this process."""
    return ProcessIdentity.of(os.getpid())


def how_ended(process: subprocess.Popen[bytes]) -> str:
    """Return how a process that was started here ended, "" while it runs."""
    code = process.poll()
    if code is None:
        return ""
    return f"killed by signal {-code}" if code < 0 else f"exit code {code}"


_PROC_STAT = (_PROC / "self" / "stat").exists()


def _namespace() -> str:
    try:
        return str((_PROC / "self" / "ns" / "pid").readlink())
    except OSError:
        return ""


def _exists(pid: int) -> bool:
    if pid <= 0:
        return False
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    return True


def _started(pid: int) -> str:
    """Return when a living process started, "" if it does not live or nobody can tell."""
    if not _PROC_STAT:
        return _started_by_ps(pid)
    try:
        content = (_PROC / str(pid) / "stat").read_text(errors="replace")
    except OSError:
        return ""
    fields = content.rpartition(")")[2].split()
    return "" if fields[_STATE_FIELD] in _DEAD_STATES else fields[_START_FIELD]


def _started_by_ps(pid: int) -> str:
    environment = {**os.environ, "LC_ALL": "C", "TZ": "UTC"}
    command = ["ps", "-o", "state=,lstart=", "-p", str(pid)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=5, check=False)
    except (OSError, subprocess.SubprocessError):
        return ""
    state, _, started = done.stdout.strip().partition(" ")
    return "" if not state or state[0] in _DEAD_STATES else started.strip()
