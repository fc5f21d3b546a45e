"""What runs trials at the seam of workers, at once and without a robot: the seed says what happens."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

from humanoid_bt.campaign.result import Explained, Result
from humanoid_bt.campaign.trial import Task
from humanoid_bt.campaign.work import Answer, Run
from humanoid_bt.core.errors import Place, UserError

HANGS, DIES, DIES_ONCE, REFUSES, RAISES, HOGS = 1001, 1002, 1003, 1004, 1005, 1006


def make(folder: Path) -> Run:
    """Return what runs trials; the folder remembers which were begun."""

    def run(task: Task) -> Answer:
        seed = task.trial.seed
        with (folder / f"begun-{seed}").open("a") as begun:
            begun.write(f"{os.getpid()}\n")
        if seed == HANGS:
            time.sleep(3600)
        if seed == DIES or (seed == DIES_ONCE and len((folder / f"begun-{seed}").read_text().splitlines()) == 1):
            os.kill(os.getpid(), signal.SIGKILL)
        if seed == REFUSES:
            raise UserError("no such thing", Place("mine.yaml", 3, 4), "valid: others")
        if seed == RAISES:
            raise ValueError("a bug")
        if seed == HOGS:
            bytearray(8 << 30)
        good = seed % 10 != 3
        reason = "done" if good else f"the hand is {seed} cm away"
        result = Result(
            "success" if good else "failure",
            reason,
            "" if good else "fetch/reach",
            time=1.0 + seed / 100,
            values={"hand_error": seed / 1000},
            units={"hand_error": "m"},
            trace=f"{seed:064x}",
        )
        explained = Explained("failure", f"reach failed: {reason}", "fetch/reach", task.recording)
        return result, explained if task.recording else None, 0.001

    return run
