"""The processes that decision starts, and how each of them ends."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import time

from humanoid_bt.core.errors import HumanoidBtError
from humanoid_bt.link.processes import how_ended
from humanoid_bt.link.run_folder import RunFolder

GATEWAY_PARTING = 12.0
"""How long a gateway may stay when the run ends [s]: to find nodes whose goals are not wanted any more, and be heard.

It takes that long only if such a node is busy or gone.
"""
_END_TIMEOUT = 3.0  # s that the processes get to end by themselves


class Children:
    """The other processes of a run, by role.

    Args:
        folder: the run's folder, which each of them is given and registered in.
    """

    def __init__(self, folder: RunFolder) -> None:
        self._folder = folder
        self._processes: dict[str, subprocess.Popen[bytes]] = {}

    def start(self, role: str, module: str) -> None:
        """Start a process out of reach of the terminal's signals: they are decision's to answer.

        Raises:
            HumanoidBtError: the system has no room for it.
        """
        environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        try:
            with self._folder.life(role) as life:
                process = subprocess.Popen(
                    [sys.executable, "-P", "-m", module, str(self._folder.folder)],
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    env=environment,
                    pass_fds=(life,),
                    start_new_session=True,
                )
        except OSError as error:
            raise HumanoidBtError(f"the {role} process cannot be started: {error.strerror}") from error
        self._processes[role] = process
        self._folder.register(role, process.pid)

    def how_ended(self, role: str) -> str:
        """Return how a process ended, "" while it runs."""
        return how_ended(self._processes[role])

    def kill(self, role: str) -> None:
        """End a process that does not answer."""
        self._processes[role].kill()

    def end(self) -> None:
        """Wait until all have ended, kill those that do not; leave no zombie. Who interrupts this leaves them alone."""
        began = time.monotonic()
        for role, process in self._processes.items():
            deadline = began + _END_TIMEOUT + (GATEWAY_PARTING if role == "gateway" else 0.0)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(max(0.0, deadline - time.monotonic()))
        for process in self._processes.values():
            if process.poll() is None:
                process.kill()
        for process in self._processes.values():
            process.wait()
