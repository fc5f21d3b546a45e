"""A process beside those of a run that may come and go: started again when it is gone."""

from __future__ import annotations

import time
from collections.abc import Callable

from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.errors import ControlLost, HumanoidBtError, UserError
from humanoid_bt.link.run_folder import RunFolder
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.children import Children

_START_TIMEOUT = 30.0  # s until its first sign of life
_SILENT_TICKS = round(0.3 / DECISION_PERIOD)  # of decision without a sign of life, after which it counts as gone
_STUCK_TICKS = round(2.0 / DECISION_PERIOD)  # after which it is killed: until then it may only be slow
_AGAIN = 1.0  # s from one start to the next, at least


class Companion:
    """One such process, looked at once per tick.

    Args:
        folder: of the run.
        children: the processes of the run.
        role: what it is among them.
        module: what it runs.
        signs: returns how many signs of life it has given so far.

    Attributes:
        gone: why it is not there, "" while it is.
        starts: how often it has been started.
    """

    def __init__(
        self, folder: RunFolder, children: Children, *, role: str, module: str, signs: Callable[[], int]
    ) -> None:
        self._folder, self._children, self._role, self._module = folder, children, role, module
        self._signs, self._seen, self._silent = signs, 0, 0
        self._runs = False
        self._spoke = False  # since it was started
        self._started = 0.0
        self.gone = ""
        self.starts = 0

    def begin(self) -> None:
        """Start it."""
        self._children.start(self._role, self._module)
        self._started, self._runs, self._spoke = time.monotonic(), True, False
        self.starts += 1

    def wait(self) -> None:
        """Wait for its first sign of life.

        Raises:
            UserError: it says what keeps it from beginning.
            HumanoidBtError: it does not come up.
        """
        deadline = time.monotonic() + _START_TIMEOUT
        while not self._signs():
            if how := self._children.how_ended(self._role):
                if mistakes := channels.left_mistakes(self._folder):
                    raise UserError(mistakes)
                raise HumanoidBtError(f"the {self._role} process ended ({how})")
            if how := self._children.how_ended("control"):
                raise ControlLost(f"the control process ended ({how})")
            if time.monotonic() > deadline:
                raise HumanoidBtError(f"the {self._role} process did not start within {_START_TIMEOUT:g} s")
            time.sleep(DECISION_PERIOD)

    def look(self) -> None:
        """See whether it is there; start it again if not. Silence is counted in looks: who looks may stand still."""
        signs = self._signs()
        self._silent = 0 if signs != self._seen else self._silent + 1
        if signs != self._seen:
            self._seen, self._spoke, self.gone = signs, True, ""
        if self._runs and (how := self._children.how_ended(self._role)):
            self._runs, self.gone = False, self.gone or f"its process ended ({how})"
        lasts = time.monotonic() - self._started
        if self._runs and not self.gone and self._silent > _SILENT_TICKS:
            self.gone = "it does not answer"
        if self._runs and self._silent > _STUCK_TICKS and (self._spoke or lasts > _START_TIMEOUT):
            self._children.kill(self._role)
        if not self._runs and lasts > _AGAIN:
            self.begin()
