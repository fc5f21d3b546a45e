"""Processes that run trials: each loads what it needs once; one that dies or hangs is replaced."""

from __future__ import annotations

import contextlib
import os
import pickle
import signal
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, Pipe, wait
from pathlib import Path
from typing import Any

from humanoid_bt.campaign.result import CRASHED, HUNG, Cost, Explained, Result
from humanoid_bt.campaign.trial import Task
from humanoid_bt.campaign.work import Refused, Run
from humanoid_bt.core.errors import HumanoidBtError

ATTEMPTS = 3
"""How often a trial is begun whose process dies; after that it is the trial's fault."""

_TO_END = 30.0
"""How long a process may take to end that answers no more [s]: one that raised frees much, slowly on a busy machine."""

_LAST_WORDS = 400  # characters of what a process said before it died


@dataclass(frozen=True)
class Done:
    """A task that is done.

    Attributes:
        task: it.
        result: what came of it.
        cost: what it took.
        explained: what its recording shows, None if it has none.
    """

    task: Task
    result: Result
    cost: Cost
    explained: Explained | None = None


@dataclass
class _Worker:
    """A process, and what it does."""

    name: str
    process: subprocess.Popen[bytes]
    line: Connection
    task: Task | None = None
    attempts: int = 1
    began: float = 0.0
    log: Path = field(default_factory=Path)


class Workers:
    """Processes of this machine that run trials.

    Args:
        make: returns what runs tasks, in each of the processes; a function of a module.
        arguments: what it is given.
        count: how many processes.
        time_limit: longest time of a trial on the wall clock [s].
        memory: most bytes that a process may have; None for any number.
        logs: folder for what the processes say.
    """

    def __init__(
        self,
        make: Callable[..., Run],
        arguments: tuple[Any, ...],
        *,
        count: int,
        time_limit: float,
        memory: int | None,
        logs: Path,
    ) -> None:
        self._begin = pickle.dumps((sys.path, memory))
        self._make = pickle.dumps((make, arguments))
        self._count, self._time_limit, self._logs = count, time_limit, logs
        self._workers: list[_Worker] = []
        self._made = 0

    def run(self, tasks: Iterable[Task]) -> Generator[Done]:
        """Yield tasks as they are done; end the processes when all are, or when it is closed.

        Raises:
            HumanoidBtError: a process cannot be started.
            UserError: a trial cannot be run, for a mistake in a file or a value.
        """
        try:
            yield from self._run(deque((task, 1) for task in tasks))
        finally:
            self.close()

    def run_one(self, task: Task) -> Done:
        """Run one task, and leave a process for the next; raises as :meth:`run`."""
        return next(self._run(deque([(task, 1)])))

    def _run(self, waiting: deque[tuple[Task, int]]) -> Iterator[Done]:
        while waiting or any(worker.task for worker in self._workers):
            while waiting and (worker := self._idle()) is not None:
                self._give(worker, *waiting.popleft())
            busy = [worker for worker in self._workers if worker.task]
            ready = wait([worker.line for worker in busy], self._patience(busy))
            for worker in busy:
                if worker.line in ready:
                    yield from self._heard(worker, waiting)
                elif time.monotonic() - worker.began > self._time_limit:
                    yield self._hung(worker)

    def close(self) -> None:
        """End the processes, and what they do."""
        workers, self._workers = self._workers, []
        for worker in workers:
            worker.process.kill()
        for worker in workers:
            worker.process.wait()
            worker.line.close()

    def _idle(self) -> _Worker | None:
        """Return a worker that has nothing to do, a new one if there may be more of them; None if all are busy."""
        idle = next((worker for worker in self._workers if worker.task is None), None)
        if idle is None and len(self._workers) < self._count:
            idle = self._start()
            self._workers.append(idle)
        return idle

    def _start(self) -> _Worker:
        self._made += 1
        here, there = Pipe()
        log = self._logs / f"worker-{self._made}.log"
        quiet = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
        try:
            with log.open("wb") as said:
                process = subprocess.Popen(
                    [sys.executable, "-P", "-m", "humanoid_bt.campaign.worker_process", str(there.fileno())],
                    stdin=subprocess.DEVNULL,
                    stdout=said,
                    stderr=said,
                    env={**os.environ, **quiet},
                    pass_fds=(there.fileno(),),
                    start_new_session=True,  # Ctrl-C is the command's to answer
                )
        except OSError as error:
            raise HumanoidBtError(f"a process for trials cannot be started: {error.strerror}") from error
        there.close()
        with contextlib.suppress(BrokenPipeError):  # it is gone already, which is noticed when it is given something
            here.send_bytes(self._begin)
            here.send_bytes(self._make)
        return _Worker(f"worker-{self._made}", process, here, log=log)

    def _give(self, worker: _Worker, task: Task, attempts: int) -> None:
        worker.task, worker.attempts, worker.began = task, attempts, time.monotonic()
        with contextlib.suppress(BrokenPipeError):
            worker.line.send(task)

    def _patience(self, busy: list[_Worker]) -> float:
        """Return how long it takes until the first trial has had its time [s]."""
        first = min((worker.began for worker in busy), default=0.0)
        return max(0.0, first + self._time_limit - time.monotonic()) + 0.001

    def _heard(self, worker: _Worker, waiting: deque[tuple[Task, int]]) -> Iterator[Done]:
        """Take a worker's answer; its trial is run again if it died instead."""
        assert worker.task is not None
        try:
            answer = worker.line.recv()
        except (EOFError, OSError):
            task, attempts = worker.task, worker.attempts
            how = self._buried(worker, _TO_END)
            if attempts < ATTEMPTS:
                waiting.appendleft((task, attempts + 1))
            else:
                yield Done(task, Result(CRASHED, how), Cost(worker=worker.name, attempts=attempts))
            return
        if isinstance(answer, Refused):
            raise answer.error
        result, explained, simulating = answer
        cost = Cost(time.monotonic() - worker.began, simulating, worker.name, worker.attempts)
        task, worker.task = worker.task, None
        yield Done(task, result, cost, explained)

    def _hung(self, worker: _Worker) -> Done:
        assert worker.task is not None
        task, cost = worker.task, Cost(self._time_limit, 0.0, worker.name, worker.attempts)
        self._buried(worker, 0.0)
        reason = f"it took longer than {self._time_limit:g} s on the wall clock, and was ended"
        return Done(task, Result(HUNG, reason), cost)

    def _buried(self, worker: _Worker, patience: float) -> str:
        """End a worker that is dead or hangs, unless it ends by itself in time [s]; return how it died, in words."""
        self._workers.remove(worker)
        with contextlib.suppress(subprocess.TimeoutExpired):  # the line closes a while before the process is gone
            worker.process.wait(patience)
        lingers = worker.process.poll() is None
        worker.process.kill()
        code = worker.process.wait()
        worker.line.close()
        return _how(code, worker.log, lingers)


def _how(code: int, log: Path, lingers: bool) -> str:
    """Return how a process ended.

    Args:
        code: with which it did.
        log: what it said.
        lingers: whether it was ended from here, for it did not by itself.
    """
    said = log.read_text(encoding="utf-8", errors="replace").strip()[-_LAST_WORDS:]
    last = f": {said.splitlines()[-1]}" if said else ""
    if lingers:
        return f"its process answered no more and did not end each time{last}"
    if code == -signal.SIGKILL:
        return f"its process was killed from outside each time: most likely it was out of memory{last}"
    named = {number.value: number.name for number in signal.Signals}  # real-time signals have no names but two
    how = f"signal {named.get(-code, -code)}" if code < 0 else f"exit code {code}"
    return f"its process ended with {how} each time{last}"
