"""A run in realtime mode that is struck: its processes, its terminals, and what it must show afterwards."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from humanoid_bt.core.messages import Mode
from humanoid_bt.link.run_folder import live_runs, lockstep_root
from humanoid_bt.realtime.status import status_of
from tests.realtime import helpers
from tests.realtime.helpers import Live, environment, until
from tests.safety.processes import MARK, Process, marked

REPOSITORY = Path(__file__).parents[2]
HOLD = 1.0
"""How long control balances the robot when decision is dead [s]."""


class OverError(Exception):
    """The run has ended by itself while it was being struck."""


class Victim(Live):
    """A run with a folder of its own for links, one for temporary files, and a mark on all its processes.

    Args:
        home: of the trial; must not be there yet.
        links: the folder for links; this process has kept itself apart with it.
        tree: what runs.
        options: further arguments.

    Attributes:
        gone: parts that were ended on purpose, so far.
        lossy: whether the recording may lack something.
        cut: whether it ends before the run.
    """

    def __init__(self, home: Path, links: Path, tree: str, *options: str) -> None:
        self.mark = f"{os.getpid()}:{home}"
        self.program = [sys.executable, "-m", "tests.safety.apart", str(links)]
        self.home, self._links = home, links
        self.temporary = home.with_name(f"{home.name}-tmp")
        self.temporary.mkdir()
        self.gone: set[str] = set()
        self.lossy = self.cut = False
        self._variables = {"TMPDIR": str(self.temporary), "PYTHONPATH": str(REPOSITORY)}
        variables = self._variables | {MARK: self.mark}
        options = ("--hold", f"{HOLD:g}", "--no-view", *options)
        super().__init__(home.parent, home, tree, *options, program=self.program, variables=variables)

    def ready(self) -> None:
        """Wait until the tree is ticked."""
        super().ready()
        self.sees("the first tick", lambda: status_of(self.folder, self.folder.info).tick_rate is not None)

    @property
    def log(self) -> list[dict[str, Any]]:
        """What control noted; nothing if there was nothing to note."""
        return super().log if self.control_log.exists() else []

    # ---- what is done to it -----------------------------------------------------------------------------------------

    def processes(self) -> list[Process]:
        """Return those of its processes that live."""
        return [process for process in marked(self.mark) if process.role]

    def pid(self, role: str) -> int:
        """Return the id of one of its processes."""
        found = [process.pid for process in self.processes() if process.role == role]
        assert found, f"there is no {role} process"
        return found[0]

    def kill(self, role: str, number: signal.Signals = signal.SIGKILL) -> None:
        """Send a signal to one of its processes."""
        os.kill(self.pid(role), number)

    @contextlib.contextmanager
    def held(self, role: str) -> Iterator[None]:
        """Stop one of its processes meanwhile."""
        pid = self.pid(role)
        os.kill(pid, signal.SIGSTOP)
        try:
            yield
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGCONT)

    def terminal(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Run a command as in another terminal."""
        line = [*self.program, *arguments]
        variables = environment() | self._variables
        return subprocess.run(
            line, capture_output=True, text=True, env=variables, timeout=helpers.PATIENCE, check=False
        )

    def over(self) -> int:
        """Wait until its program has ended; return the exit code."""
        until("its end", lambda: self.process.poll() is not None)
        return int(self.process.returncode)

    # ---- what it shows ----------------------------------------------------------------------------------------------

    def passes(self, duration: float) -> None:
        """Let time pass on the wall clock [s].

        Raises:
            OverError: the run has ended.
        """
        end = time.monotonic() + duration
        while time.monotonic() < end:
            if self.process.poll() is not None:
                raise OverError("the run has ended")
            time.sleep(min(0.05, duration))

    def sees(self, what: str, condition: Callable[[], bool]) -> None:
        """Wait for something to become true.

        Raises:
            OverError: the run has ended instead.
        """

        def holds() -> bool:
            if self.process.poll() is not None:
                raise OverError(f"the run has ended, and not: {what}")
            return condition()

        until(what, holds)

    def shows(self, mode: str) -> None:
        """Wait for a mode of the supervisor."""
        self.sees(f"the mode {mode}", lambda: self.state.mode.value == mode)

    def tells(self, text: str) -> None:
        """Wait for what the run prints."""
        self.sees(f"it says {text!r}", lambda: text in self.output)

    @property
    def succeeded(self) -> bool:
        """Whether the tree has come to its end."""
        return "the tree ended: success" in self.output

    @property
    def stopped(self) -> bool:
        """Whether the supervisor does not let it run."""
        return self.state.mode is not Mode.RUN

    def leftovers(self) -> list[str]:
        """Return what is left of it: processes, folders of links, temporary files."""
        roots = [self._links, lockstep_root()]
        known = {".lock", *(folder.folder.name for folder, _ in live_runs())}
        folders = [path for root in roots if root.exists() for path in root.iterdir() if path.name not in known]
        return [
            *(f"the process {process.pid} ({process.role})" for process in self.processes()),
            *map(str, folders),
            *map(str, self.temporary.rglob("*")),
        ]

    def destroy(self) -> None:
        """End whatever is left of it; only what carries its mark."""
        for process in self.processes():
            os.kill(process.pid, signal.SIGKILL)
        self.process.wait()
        if self.pids:
            self.folder.close()
