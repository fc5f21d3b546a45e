"""What a robot's body, its balance and its walking, withstands: many random trials of every row."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from functools import cached_property
from pathlib import Path
from typing import Any, get_args

from humanoid_bt.bench.body_rows import ROWS, Row
from humanoid_bt.bench.body_trial import make
from humanoid_bt.bench.gait import GaitFigure, gait_figures
from humanoid_bt.bench.promises import Verdict
from humanoid_bt.campaign.result import CRASHED, HUNG
from humanoid_bt.campaign.statistics import Rate
from humanoid_bt.campaign.trial import Task
from humanoid_bt.campaign.workers import Done, Workers
from humanoid_bt.core.errors import UserError, nearest
from humanoid_bt.robot.config import RobotConfig, Walk

_TIME_LIMIT = 300.0  # s on the wall clock


@dataclass(frozen=True)
class Withstood:
    """What came of a row's trials.

    Attributes:
        row: the row.
        trials: those that are done, in the order of their seeds.
        body: what walked and balanced; None for what ``robot.yaml`` says.
    """

    row: Row
    trials: Sequence[Done]
    body: Walk | None = None

    @property
    def good(self) -> Rate:
        """How many reached the goal, or stayed on their feet where there is none: what is promised."""
        return self._rate(lambda done: done.result.succeeded)

    @property
    def on_feet(self) -> Rate:
        """How many stayed on their feet."""
        return self._rate(lambda done: not (done.result.fell or done.result.outcome in (HUNG, CRASHED)))

    @property
    def verdict(self) -> Verdict:
        """Whether the row keeps its promise."""
        return self.row.promise.verdict(100 * self.good.share)

    @property
    def gait(self) -> list[GaitFigure]:
        """What it tells of the gait."""
        return gait_figures(self.row.name, [done.result.values for done in self.trials if done.result.succeeded])

    @cached_property
    def failed(self) -> list[Done]:
        """The trials that it did not withstand, the worst first: those that fell, the earlier the worse."""
        failed = [done for done in self.trials if not done.result.succeeded]
        return sorted(failed, key=lambda done: (not done.result.fell, done.result.time, done.task.trial.seed))

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data for JSON."""
        promise = self.row.promise
        return {
            "row": self.row.name,
            "what": self.row.what,
            "body": self.body,
            "reached" if self.row.walks else "withstood": self.good.count,
            "on_feet": self.on_feet.count,
            "of": self.good.of,
            "interval": list(self.good.interval),
            "promised": promise.bound / 100,
            "verdict": self.verdict,
            "gait": {
                figure.name: {"mean": figure.value, "median": figure.median, "verdict": figure.verdict}
                for figure in self.gait
            },
            "trials": [
                {"seed": done.task.trial.seed, "given": dict(done.task.trial.given), **done.result.to_dict()}
                for done in self.trials
            ],
        }

    def _rate(self, holds: Callable[[Done], bool]) -> Rate:
        return Rate(sum(map(holds, self.trials)), len(self.trials))


def chosen(patterns: Sequence[str]) -> list[Row]:
    """Return the rows whose names match any of some patterns, all of them if there are none.

    Raises:
        UserError: a pattern matches none.
    """
    names = [row.name for row in ROWS]
    for pattern in patterns:
        if not any(fnmatchcase(name, pattern) for name in names):
            raise UserError(f"no row {pattern!r}", hint=nearest(pattern, names))
    return [row for row in ROWS if not patterns or any(fnmatchcase(row.name, pattern) for pattern in patterns)]


def bodies_of(config: RobotConfig) -> list[Walk]:
    """Return the bodies that a robot can have, the one that ``robot.yaml`` names first."""
    brought = {"dcm": True, "policy": config.body.policy is not None, "own": config.body.own is not None}
    bodies: list[Walk] = [body for body in get_args(Walk) if brought[body]]
    return sorted(bodies, key=lambda body: body != config.body.walk)


def measure_body(
    robot: Path,
    rows: Sequence[Row],
    seeds: Sequence[int],
    *,
    workers: int,
    progress: Callable[[Withstood], None],
    recordings: Callable[[Row, int, Walk | None], Path] | None = None,
    bodies: Sequence[Walk | None] = (None,),
) -> Generator[Withstood]:
    """Try bodies, and yield every row, of each body, as soon as it and those before it are done.

    What comes of it is the same for any number of workers.

    Closing the generator ends every process.

    Args:
        robot: its ``robot.yaml``, an absolute path.
        rows: what it is tried with.
        seeds: of every row's trials.
        workers: trials at a time.
        progress: told after every trial what is known of its row.
        recordings: says where a trial of a row, a seed and a body is recorded; none is if None.
        bodies: what walks and balances; None is what ``robot.yaml`` says.

    Raises:
        UserError: the robot has mistakes, or lacks something that a row needs.
        HumanoidBtError: no process can be started.
    """
    waiting = [(row, body) for row in rows for body in bodies]
    wanted = [(row, body, seed) for row, body in waiting for seed in seeds]
    tasks = [
        Task(row.trial(number, str(robot), seed, body), str(recordings(row, seed, body)) if recordings else "")
        for number, (row, body, seed) in enumerate(wanted)
    ]
    done: dict[tuple[str, Walk | None], list[Done]] = {(row.name, body): [] for row, body in waiting}
    with tempfile.TemporaryDirectory() as logs:
        running = Workers(make, (), count=workers, time_limit=_TIME_LIMIT, memory=None, logs=Path(logs))
        with closing(running), closing(running.run(tasks)) as found:
            for one in found:
                row, body, _ = wanted[one.task.trial.number]
                done[row.name, body].append(replace(one, result=row.judged(one.result)))
                progress(_withstood(row, body, done))
                while waiting and len(done[waiting[0][0].name, waiting[0][1]]) == len(seeds):
                    yield _withstood(*waiting.pop(0), done)


def _withstood(row: Row, body: Walk | None, done: Mapping[tuple[str, Walk | None], list[Done]]) -> Withstood:
    return Withstood(row, sorted(done[row.name, body], key=lambda one: one.task.trial.number), body)
