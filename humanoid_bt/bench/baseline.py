"""The machine's own baseline: the servo's schedule in C, compiled on the spot if there is a compiler."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np

from humanoid_bt.bench.punctuality import Punctuality, punctuality
from humanoid_bt.core.clock import SERVO_PERIOD, cycles
from humanoid_bt.realtime.schedule import SPIN

SLEEP_ALONE, SAME_LOOP = "C, sleep alone", "C, same loop"

_SOURCE = Path(__file__).with_name("baseline.c")
_COMPILERS = ("cc", "gcc", "clang")
_COMPILE_TIMEOUT = 60.0  # s
_GRACE = 30.0  # s that a run may take longer than it should


class Baseline:
    """The compiled program.

    Args:
        program: where it is.
    """

    def __init__(self, program: Path) -> None:
        self._program = program

    @classmethod
    def compile(cls, folder: Path) -> Baseline | None:
        """Compile it into a folder; return None if there is no compiler, or it cannot."""
        compiler = next(filter(None, map(shutil.which, _COMPILERS)), None)
        if compiler is None:
            return None
        program = folder / "baseline"
        command = [compiler, "-O2", "-o", str(program), str(_SOURCE)]
        try:
            done = subprocess.run(command, capture_output=True, timeout=_COMPILE_TIMEOUT, check=False)
        except (OSError, subprocess.TimeoutExpired):
            return None
        return cls(program) if done.returncode == 0 else None

    def run(self, duration: float, core: int | None, loaded: bool) -> tuple[Punctuality, Punctuality] | None:
        """Run the loop and return how punctual it was, and how punctual its sleep alone; None if it failed.

        Args:
            duration: [s].
            core: processor to pin it to, None for any.
            loaded: whether every core is busy, for the record.
        """
        file = self._program.with_name("wakes")
        count = cycles(duration)
        period = round(SERVO_PERIOD * 1e9)
        command = [str(self._program), str(period), str(count), str(SPIN), str(-1 if core is None else core), str(file)]
        # A new session: Ctrl-C reaches this process alone, which then ends the program.
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True)
        try:
            out, _ = process.communicate(timeout=duration + _GRACE)
        except subprocess.TimeoutExpired:
            return None
        finally:
            if process.poll() is None:
                process.kill()
                process.wait()
        if process.returncode:
            return None
        woke, late, slept_late, skipped = np.fromfile(file, dtype=np.int64).reshape(-1, 4).T
        fifo = out.strip() == "1"
        return (
            punctuality(SAME_LOOP, loaded=loaded, fifo=fifo, woke=woke, late=late, skipped=skipped),
            punctuality(
                SLEEP_ALONE, loaded=loaded, fifo=fifo, woke=woke - late + slept_late, late=slept_late, skipped=skipped
            ),
        )
