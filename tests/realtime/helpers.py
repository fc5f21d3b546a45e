"""Runs in realtime mode as processes of their own, watched from outside."""

from __future__ import annotations

import contextlib
import io
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from humanoid_bt.cli import main
from humanoid_bt.core.messages import Gait, State
from humanoid_bt.link.run_folder import RunFolder, live_runs
from humanoid_bt.link.wire import decode_state
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.status import status_of

PROGRAM = [sys.executable, "-m", "humanoid_bt"]
PATIENCE = 60.0  # s that anything may take on a busy machine


def environment() -> dict[str, str]:
    """Return an environment without a display."""
    kept = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    return kept | {"PYTHONIOENCODING": "utf-8", "PYTHONUNBUFFERED": "1"}


def until(what: str, condition: Callable[[], bool]) -> None:
    """Wait for something to become true."""
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline, f"in vain: {what}"
        time.sleep(0.01)


def command(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Run a command as in another terminal."""
    return subprocess.run(
        [*PROGRAM, *arguments], capture_output=True, text=True, env=environment(), timeout=PATIENCE, check=False
    )


def told(*arguments: str) -> str:
    """Return what a command prints, run here: this is another process than those of the run."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        assert main(arguments) == 0
    return printed.getvalue()


class Live:
    """A run in realtime mode.

    Args:
        project: where it runs.
        folder: where its recording, report and output go.
        tree: what runs.
        options: further arguments.
        record: whether it is recorded.
        program: what runs it.
        variables: further variables of its environment.
    """

    def __init__(
        self,
        project: Path,
        folder: Path,
        tree: str,
        *options: str,
        record: bool = True,
        program: Sequence[str] = PROGRAM,
        variables: Mapping[str, str] = {},
    ) -> None:
        folder.mkdir()
        self.recording, self._report = folder / "run.rrd", folder / "report.json"
        self.control_log = folder / "run.control.log"
        self._output = folder / "output.txt"
        recorded = ["--record", str(self.recording)] if record else ["--no-record"]
        files = [*recorded, "--report", str(self._report)]
        with self._output.open("w") as output:
            self.process = subprocess.Popen(
                [*program, "run", tree, "--mode", "realtime", *files, *options],
                cwd=project,
                env=environment() | dict(variables),
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
            )
        self.folder: RunFolder
        self.pids: dict[str, int] = {}

    def ready(self) -> None:
        """Wait until the tree is ticked."""
        until("the run's start", self._started)
        self._states = channels.reader(self.folder, "state")
        self.run_id = self.folder.info.run_id
        self.pids = dict(self.folder.info.processes)

    def _started(self) -> bool:
        assert self.process.poll() is None, self.output
        for folder, info in live_runs():
            if info.processes["owner"] == self.process.pid and "perception" in info.processes:
                self.folder = folder
                return True
        return False

    @property
    def output(self) -> str:
        """What it printed."""
        return self._output.read_text(encoding="utf-8")

    @property
    def state(self) -> State:
        """The latest state, also after the end."""
        latest = self._states.latest()
        assert latest is not None
        return decode_state(latest[1])

    @property
    def report(self) -> dict[str, Any]:
        """What was reported."""
        found: dict[str, Any] = json.loads(self._report.read_text(encoding="utf-8"))
        return found

    @property
    def has_report(self) -> bool:
        """Whether it has reported."""
        return self._report.exists()

    @property
    def log(self) -> list[dict[str, Any]]:
        """What control noted."""
        return [json.loads(line) for line in self.control_log.read_text(encoding="utf-8").splitlines()]

    def walks(self) -> None:
        """Wait until the robot walks."""
        until("the robot walks", lambda: self.state.gait is Gait.STEP)

    def shows(self, mode: str) -> None:
        """Wait for a mode."""
        until(mode, lambda: status_of(self.folder, self.folder.info).mode == mode)

    def kill(self, role: str, number: signal.Signals = signal.SIGKILL) -> None:
        """Send a signal to one of its processes."""
        os.kill(self.pids[role], number)

    def ends(self) -> int:
        """Wait for the end of all of it; return the exit code."""
        code = self.process.wait(PATIENCE)
        self.leaves_nothing()
        return code

    def leaves_nothing(self) -> None:
        """Wait until neither a process nor a folder is left."""
        until("nothing is left", lambda: not self.folder.folder.exists() and not self._alive(self.pids.values()))

    def _alive(self, pids: Sequence[int] | Any) -> list[int]:
        alive = []
        for pid in pids:
            if pid != self.process.pid:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, 0)
                    alive.append(pid)
        return alive

    def destroy(self) -> None:
        """End whatever is left."""
        for pid in self._alive(self.pids.values()):
            os.kill(pid, signal.SIGKILL)
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        if self.pids:
            self.folder.close()
