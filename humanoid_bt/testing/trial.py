"""One seed of a scenario, tried: what came of it, and its recording if it failed."""

from __future__ import annotations

import shlex
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from humanoid_bt.core.errors import HumanoidBtError, UserError, relative
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.record.folder import make_room
from humanoid_bt.record.folder_limits import load_limits
from humanoid_bt.session.options import RUNS, default_recording, make_folder
from humanoid_bt.session.teller import NO_PERCEPT
from humanoid_bt.testing.expectations import Failure
from humanoid_bt.testing.scenario import Scenario
from humanoid_bt.testing.stage import Stage
from humanoid_bt.testing.tree_run import TreeRun


@dataclass(frozen=True)
class Trial:
    """What came of one seed of a scenario.

    Attributes:
        scenario: its name.
        file: its file.
        seed: the seed.
        outcome, reason: how the run ended.
        time: simulated time until the tree ended [s].
        wall_time: time that took [s].
        failures: the expectations that it has not met.
        command: what tries it again.
        trace: hash of all that happened.
        recording: the recording of the same run, "" without one.
        note: what is to be told of the recording, or of percepts that could never come.
    """

    scenario: str
    file: str
    seed: int
    outcome: str
    reason: str
    time: float
    wall_time: float
    failures: tuple[Failure, ...]
    command: str
    trace: str = ""
    recording: str = ""
    note: str = ""

    @property
    def passed(self) -> bool:
        """Whether it has met all expectations."""
        return not self.failures

    @property
    def lines(self) -> list[str]:
        """What failed, where it is recorded and how it is tried again, as lines."""
        found: list[str] = []
        for failure in self.failures:
            found += [f"{failure.place}: {failure.expectation}" if failure.place.file else failure.expectation]
            found += [f"    {failure.moment}", *(f"    {name}: {value}" for name, value in failure.values.items())]
        rows = [("the run", f"{self.outcome}: {self.reason}"), *self.further]
        return found + [f"{name:<11} {text}" for name, text in rows]

    @property
    def further(self) -> list[tuple[str, str]]:
        """What helps with a failure: rows of a name and a text."""
        rows = [("recording", self.recording), ("note", self.note)]
        rows.append(("explain it", f"humanoid-bt explain {shlex.quote(self.recording)}" if self.recording else ""))
        return [row for row in [*rows, ("try again", self.command)] if row[1]]

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data for JSON."""
        failures = [
            {
                "expectation": failure.expectation,
                "place": str(failure.place),
                "time": round(failure.time, 3),
                "why": failure.why,
                "values": dict(failure.values),
            }
            for failure in self.failures
        ]
        values = {name: getattr(self, name) for name in self.__dataclass_fields__}
        return {**values, "passed": self.passed, "failures": failures}


class Trials:
    """Tries scenarios, with one stage for those of one robot and scene.

    Args:
        root: the workspace that was asked for; each file's own if None.
    """

    def __init__(self, root: Path | None = None) -> None:
        self._root = root
        self._stages: dict[tuple[object, ...], Stage] = {}

    def workspace(self, path: Path) -> Workspace:
        """Return where the names of a scenario file are looked up; raises UserError."""
        return Workspace(self._root) if self._root else Workspace.of_tree(path)

    def run(self, scenario: Scenario, seed: int) -> Trial:
        """Try one seed.

        Raises:
            UserError: the scenario, or something that it names, has mistakes.
        """
        began = time.monotonic()
        run, failures = self._judged(scenario, seed, None)
        return Trial(
            scenario=scenario.name,
            file=relative(scenario.path),
            seed=seed,
            outcome=run.outcome if run else "error",
            reason=run.reason if run else failures[0].why,
            time=run.time if run else 0.0,
            wall_time=time.monotonic() - began,
            failures=tuple(failures),
            command=self._command(scenario, seed),
            trace=run.trace if run else "",
            note=_never_seen(run) if run and failures else "",
        )

    def recorded(self, scenario: Scenario, trial: Trial) -> Trial:
        """Try a seed once more, recorded: in lockstep it is the same run.

        Returns:
            What came of it before, with the recording, or with a note on why there is none.
        """
        path = default_recording(f"{scenario.name}-seed{trial.seed}")
        try:
            make_folder()
            make_room(RUNS, load_limits(RUNS))
            run, _ = self._judged(scenario, trial.seed, path)
        except UserError as error:
            return replace(trial, note=f"not recorded: {error.problems[0].message}")
        if run is None or run.recording is None:
            return replace(trial, note="not recorded: the run did not begin")
        same = run.trace == trial.trace
        note = (
            trial.note
            if same
            else f"the run that was recorded went another way ({run.outcome}): it is not deterministic"
        )
        return replace(trial, recording=relative(run.recording), note=note)

    def _judged(self, scenario: Scenario, seed: int, record: Path | None) -> tuple[TreeRun | None, list[Failure]]:
        stage = self._stage(scenario)
        try:
            run = stage.run(
                scenario.tree,
                seed=seed,
                parameters=scenario.parameters.items,
                duration=scenario.duration,
                script=scenario.script,
                conditions=scenario.conditions,
                replace=scenario.replace,
                record=record,
            )
        except UserError:
            raise
        except HumanoidBtError as error:  # a skill's setup
            return None, [Failure("the run begins", scenario.place("tree"), 0.0, str(error), {})]
        return run, scenario.expect.failures(run)

    def _stage(self, scenario: Scenario) -> Stage:
        workspace = self.workspace(scenario.path)
        sources = scenario.perception
        key = workspace.root, scenario.robot, scenario.scene, scenario.dry, sources and repr(sources.written)
        if key not in self._stages:
            self._stages[key] = Stage(workspace, scenario.robot, scenario.scene, scenario.dry, perception=sources)
        return self._stages[key]

    def _command(self, scenario: Scenario, seed: int) -> str:
        root = [] if self._root is None else ["--workspace", relative(self._root)]
        return shlex.join(["humanoid-bt", "test", relative(scenario.path), "--seeds", str(seed), *root])


def _never_seen(run: TreeRun) -> str:
    """Return which percepts the tree asks for that could never come, "" if none."""
    return "; ".join(event["text"] for event in run.report.events if NO_PERCEPT in event["text"])
