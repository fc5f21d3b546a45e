"""Running trials on stages: the robot, the scenes and the trees are loaded once in each process."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

from humanoid_bt.campaign.plan import Plan
from humanoid_bt.campaign.result import SUCCESS, Explained, Result, Value
from humanoid_bt.campaign.trial import CONDITION, PUSH, SET, Task, Trial
from humanoid_bt.campaign.work import Answer, Run
from humanoid_bt.core.errors import Place, UserError
from humanoid_bt.core.items import item_of
from humanoid_bt.core.texts import shortened
from humanoid_bt.review.explain import explain
from humanoid_bt.testing.events import Event
from humanoid_bt.testing.stage import Stage
from humanoid_bt.testing.tree_run import TreeRun, View
from humanoid_bt.tree.ticking.deciding import deciding

_LONGEST = 500  # characters of a reason or of a text that a skill reports


@dataclass(frozen=True)
class Setup:
    """What every trial of a campaign has in common.

    Attributes:
        workspace: where names are looked up.
        script: what happens in every trial, as YAML has it.
        fail_on: what makes a trial a failure whose tree succeeded.
        perception: the percept sources as they are written; None for what each tree or its scene says.
    """

    workspace: str
    script: tuple[Mapping[str, Any], ...] = ()
    fail_on: tuple[str, ...] = ()
    perception: Any = None

    @classmethod
    def of(cls, plan: Plan, workspace: str) -> Self:
        """Return what the trials of a plan have in common, in a workspace."""
        return cls(workspace, plan.script, plan.fail_on, plan.perception)


def make(setup: Setup) -> Run:
    """Return what runs the trials of a campaign in this process."""
    return _Stages(setup).run


class _Stages:
    """Stages, one for each robot in each scene."""

    def __init__(self, setup: Setup) -> None:
        self._setup = setup
        self._stages: dict[tuple[str, str, bool], Stage] = {}

    def run(self, task: Task) -> Answer:
        """Run a trial; raises UserError if it cannot be."""
        trial = task.trial
        named = [Event.from_item(item_of(push, Place(f"{PUSH} {n}"))) for n, push in enumerate(pushes(trial), start=1)]
        run = self._stage(trial).run(
            trial.tree,
            seed=trial.seed,
            parameters=trial.part(SET),
            duration=trial.duration,
            script=[*self._setup.script, *named],
            conditions=trial.part(CONDITION),
            record=task.recording or None,
            watchers=[stopwatch := _Stopwatch()],
        )
        result = judged(result_of(run), run, self._setup.fail_on)
        return result, _explained(task, result), stopwatch.passed

    def _stage(self, trial: Trial) -> Stage:
        key = trial.robot, trial.scene, trial.dry
        if key not in self._stages:
            setup = self._setup
            self._stages[key] = Stage(setup.workspace, trial.robot, trial.scene, trial.dry, perception=setup.perception)
        return self._stages[key]


class _Stopwatch:
    """Measures how long a run is simulated on the wall clock, from its first tick until the robot stands."""

    def __init__(self) -> None:
        self._began = 0.0
        self.passed = 0.0  # s

    def tick(self, _view: View) -> None:
        """Begin, unless it has begun."""
        self._began = self._began or time.monotonic()

    def end(self, _run: TreeRun) -> None:
        """Take the time."""
        self.passed = time.monotonic() - self._began if self._began else 0.0


def pushes(trial: Trial) -> Sequence[Mapping[str, Any]]:
    """Return the pushes of a trial as events of a script."""
    found: dict[str, dict[str, float]] = {}
    for name, value in trial.part(PUSH).items():
        number, _, quantity = name.rpartition(".")
        found.setdefault(number, {})[quantity] = value
    return [_push(**numbers) for numbers in found.values()]


def _push(at: float, force: float, direction: float, duration: float) -> Mapping[str, Any]:
    vector = [force * math.cos(direction), force * math.sin(direction), 0.0]
    return {"at": at, "push": {"force": vector, "duration": duration}}


def result_of(run: TreeRun) -> Result:
    """Return what came of a run."""
    report = run.report
    values: dict[str, Value] = {}
    units: dict[str, str] = {}
    for entry in report.results:  # the last of a name wins
        value = entry["value"]
        if isinstance(value, float) and not math.isfinite(value):
            continue
        values[entry["name"]] = value if isinstance(value, (bool, int, float)) else shortened(str(value), _LONGEST)
        units[entry["name"]] = entry["unit"]
    return Result(
        outcome=run.outcome,
        reason=shortened(run.reason.splitlines()[0] if run.reason else "", _LONGEST),
        node="" if run.succeeded else _node(run),
        time=report.sim_time,
        fell=run.fell,
        bumped=", ".join(dict.fromkeys(touch["thing"] for touch in report.touches if not touch["meant"])),
        stops=len(report.stops),
        missed=", ".join(str(missed.place) for missed in run.missed if not missed.optional),
        values=values,
        units={name: unit for name, unit in units.items() if unit},
        trace=run.trace,
    )


def judged(result: Result, run: TreeRun, fail_on: Sequence[str]) -> Result:
    """Return what came of a run as a failure if its tree succeeded, and something happened that is one."""
    reasons = {
        "fell": "the robot fell" * result.fell,
        "bumped": (run.report.bumps or [""])[0],
        "stopped": run.stops[0].reason if run.stops else "",
    }
    if what := next((name for name in fail_on if reasons[name]), "") if result.succeeded else "":
        return replace(result, outcome=what, reason=f"the tree succeeded, but {reasons[what]}")
    return result


def _node(run: TreeRun) -> str:
    """Return the path of the node that a reason is about: one that it names, else the leaf that did something last."""
    if run.outcome == "failure" and (decided := deciding(run.changes)) is not None:
        return decided.path
    for node in run.tree.nodes:
        if f"the node {node.path!r}" in run.reason:
            return node.path
    leaves = {node.path for node in run.tree.nodes if node.kind in ("skill", "action", "condition")}
    ran = [change.path for change in run.changes if change.path in leaves and change.status.name == "RUNNING"]
    return ran[-1] if ran else ""


def _explained(task: Task, result: Result) -> Explained | None:
    """Return what the recording of a trial shows, None if it has none."""
    if not task.recording:
        return None
    file = Path(task.recording)
    try:
        found = explain(file)
    except UserError as error:
        return Explained("", f"its recording tells nothing: {error.problems[0].message}", recording=file.name)
    if found.kind == SUCCESS:  # of the tree: what makes a failure of it is in its reason
        return Explained(result.outcome, result.reason, recording=file.name)
    return Explained(found.kind, found.headline, found.node, file.name)
