"""Scenarios, tried one after the other or in several processes; what came of each, in their order."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import active_children, get_context, parent_process
from pathlib import Path

from humanoid_bt.core.errors import HumanoidBtError, Problem, UserError, relative, resolved
from humanoid_bt.files.reading import is_folder
from humanoid_bt.files.workspace import Workspace, yaml_files
from humanoid_bt.testing.scenario import Scenario, load_scenario
from humanoid_bt.testing.scenario_check import checked_scenario
from humanoid_bt.testing.seeds import Seeds
from humanoid_bt.testing.trial import Trial, Trials

MOST_RECORDED = 3
"""Most failing seeds of one scenario that are recorded."""


@dataclass(frozen=True)
class Result:
    """What came of a scenario.

    Attributes:
        scenario: it.
        trials: its seeds, in their order.
        whole: whether all of them were tried.
    """

    scenario: Scenario
    trials: tuple[Trial, ...]
    whole: bool = True

    @property
    def failed(self) -> list[Trial]:
        """The seeds that failed."""
        return [trial for trial in self.trials if not trial.passed]


class Suite:
    """Scenarios to try.

    Args:
        names: names, files or folders of scenarios; all of the workspace if there are none.
        root: the workspace that was asked for; each file's own if None.
        seeds: instead of their own, if any.

    Attributes:
        scenarios: them, in the order in which they are named.

    Raises:
        UserError: there is no such scenario, or with every mistake in their files.
    """

    def __init__(self, names: Sequence[str] = (), root: Path | None = None, seeds: Seeds | None = None) -> None:
        self._root, self._seeds = root, seeds
        self._trials = Trials(root)
        scenarios: list[Scenario] = []
        problems: list[Problem] = []
        for path in _files(names, Workspace(root)):
            try:
                scenarios.append(checked_scenario(path, self._trials.workspace(path)))
            except UserError as error:
                problems += error.problems
        if problems:
            raise UserError(list(dict.fromkeys(problems)))
        self.scenarios = tuple(scenarios)

    def seeds(self, scenario: Scenario) -> Seeds:
        """Return the seeds of a scenario that are tried."""
        return self._seeds or scenario.seeds

    @property
    def total(self) -> int:
        """Number of runs."""
        return sum(len(self.seeds(scenario)) for scenario in self.scenarios)

    def results(
        self, jobs: int = 1, record: bool = True, progress: Callable[[Scenario, Trial], None] | None = None
    ) -> Iterator[Result]:
        """Try them; yield what came of each as soon as it and those before it are through.

        Args:
            jobs: number of processes.
            record: run what fails once more, recorded.
            progress: called after each run.

        Raises:
            UserError: a scenario has mistakes that show only when it runs.
            HumanoidBtError: a process has died.
            KeyboardInterrupt: Ctrl-C, after what came of the seeds of a scenario that were tried before it.
        """
        runs = self._in_processes(jobs) if jobs > 1 and self.total > 1 else self._here()
        for scenario in self.scenarios:
            trials: list[Trial] = []
            for _ in self.seeds(scenario):
                try:
                    trials.append(next(runs))
                except KeyboardInterrupt:
                    yield Result(scenario, tuple(trials), whole=False)
                    raise
                if progress is not None:
                    progress(scenario, trials[-1])
            failed = [index for index, trial in enumerate(trials) if not trial.passed]
            for index in failed[: MOST_RECORDED if record else 0]:
                try:
                    trials[index] = self._trials.recorded(scenario, trials[index])
                except KeyboardInterrupt:
                    yield Result(scenario, tuple(trials))
                    raise
            yield Result(scenario, tuple(trials))

    def _here(self) -> Iterator[Trial]:
        for scenario in self.scenarios:
            for seed in self.seeds(scenario):
                yield self._trials.run(scenario, seed)

    def _in_processes(self, jobs: int) -> Iterator[Trial]:
        pool = ProcessPoolExecutor(min(jobs, self.total), get_context("spawn"), _begin, (self._root,))
        try:
            waiting = [
                pool.submit(_try, scenario.path, seed) for scenario in self.scenarios for seed in self.seeds(scenario)
            ]
            for done, future in enumerate(waiting):
                yield self._result(future, done)
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in active_children():  # who is interrupted does not wait for what still runs
                process.terminate()

    def _result(self, future: Future[Trial | tuple[Problem, ...]], done: int) -> Trial:
        try:
            result = future.result()
            if isinstance(result, Trial):
                return result
            raise UserError(result)
        except BrokenProcessPool as error:
            left = f"{done} of {self.total} runs are done"
            raise HumanoidBtError(f"a process that tried scenarios has died, out of memory perhaps; {left}") from error


def _files(names: Sequence[str], workspace: Workspace) -> list[Path]:
    """Return the files of scenarios, each once.

    Raises:
        UserError: there are none.
    """
    if not names:
        found = yaml_files(workspace.root / "scenarios")
        if not found:
            hint = "scenarios are files in scenarios/; give names, files or folders, or go to a folder that has it"
            raise UserError(f"no scenarios in {relative(workspace.root)!r}", hint=hint, code="no-file")
        return found
    problems: list[Problem] = []
    files: list[Path] = []
    for name in names:
        path = Path(name)
        try:
            files += _in_folder(path) if is_folder(path) else [workspace.find_scenario(name)]
        except UserError as error:
            problems += error.problems
    if problems:
        raise UserError(problems)
    return list(dict.fromkeys(resolved(file) for file in files))


def _in_folder(folder: Path) -> list[Path]:
    """Return the scenarios of a workspace, or of a folder of scenarios; raises UserError."""
    if not (found := yaml_files(folder, ["scenarios"])):
        raise UserError(f"no scenarios in {str(folder)!r}", hint="they end in .yaml", code="no-file")
    return found


_trials: Trials
_scenarios: dict[Path, Scenario] = {}


def _begin(root: Path | None) -> None:
    """Begin with a process that tries scenarios: the one that started it hears of Ctrl-C, and it ends with that one."""
    global _trials  # noqa: PLW0603 (a process has no other place for what it keeps)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    _trials = Trials(root)


def _end_with_parent() -> None:
    parent = parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


def _try(path: Path, seed: int) -> Trial | tuple[Problem, ...]:
    """Return what came of a seed, or what is wrong with its scenario."""
    try:
        if path not in _scenarios:
            _scenarios[path] = load_scenario(path)
        return _trials.run(_scenarios[path], seed)
    except UserError as error:
        return error.problems
