"""Ticks, statuses, starts and ends."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest
from py_trees.common import Status

import humanoid_bt.tree
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.tree.ticking.executor import NodeError
from tests.semantics.claims import shows
from tests.session.helpers import ran
from tests.tree.helpers import Run, run, seen

SPY = '''
from humanoid_bt.core.messages import Percept
from humanoid_bt.core.params import param
from humanoid_bt.decision.skill import Skill, Status

SEEN = []


class Spy(Skill):
    """Note what it sees; then let time pass and the world change."""

    def update(self):
        track = self.robot.track("target")
        SEEN.append((self.robot.clock.now(), self.robot.state.time, None if track is None else track.stamp))
        return self.succeed("")


class Burn(Skill):
    """Compute for a while, then ask the robot to look somewhere."""

    resources = ("gaze",)
    effort: int = param(0, doc="How much.")

    def update(self):
        sum(range(self.effort))
        self.robot.look_at([1, 0, 1])
        return self.running("")


class Glance(Skill):
    """Look somewhere in the first tick only."""

    resources = ("gaze",)

    def __init__(self, name="", **values):
        super().__init__(name, **values)
        self.ticks = 0

    def update(self):
        self.ticks += 1
        if self.ticks == 1:
            self.robot.look_at([1, 0, 1])
        return self.succeed("") if self.ticks == 3 else self.running("")


class Blink(Skill):
    """Look somewhere and succeed."""

    resources = ("gaze",)

    def update(self):
        self.robot.look_at([1, 0, 1])
        return self.succeed("")
'''


@pytest.fixture
def spying(workspace: Workspace) -> Workspace:
    (workspace.root / "skills" / "spy.py").write_text(SPY, encoding="utf-8")
    return workspace


def noted(under_test: Run) -> list[tuple[float, float, float | None]]:
    """Return what the spies saw in the last tick."""
    spy = next(node.behaviour for node in under_test.tree.nodes if node.name.startswith("spy"))
    log: list[tuple[float, float, float | None]] = spy.update.__globals__["SEEN"]
    found = list(log)
    log.clear()
    return found


@shows("tick-snapshot", "tick-time")
def test_every_node_of_a_tick_sees_the_same(spying: Workspace) -> None:
    spies = run(spying, "{sequence: [spy, {act: {name: meanwhile, script: s}}, spy]}")
    percepts = seen(0.0)
    meanwhile = spies.tree.nodes[2].behaviour

    def world_goes_on() -> Status:
        percepts.update(seen(0.05))
        return Status.SUCCESS

    meanwhile.update = world_goes_on  # type: ignore[method-assign]  # this node alone
    spies.tick(percepts)
    assert noted(spies) == [(0.0, 0.0, 0.0)] * 2
    spies.tick(percepts)
    assert noted(spies) == [(0.1, 0.1, 0.05)] * 2


@shows("tick-latest-percept")
def test_of_each_percept_the_latest_is_kept(spying: Workspace) -> None:
    spies = run(spying, "spy")
    spies.tick(seen(0.0))
    spies.tick({})
    spies.tick(seen(0.2))
    spies.tick(seen(0.1))  # it comes late
    assert [stamp for _, _, stamp in noted(spies)] == [0.0, 0.0, 0.2, 0.2]


@shows("tick-one-command")
def test_one_command_leaves_with_the_targets_that_are_left(spying: Workspace) -> None:
    blink = run(spying, "{emergency_stop: {sequence: [blink, idle]}}")
    command = blink.tick()
    assert dict(command.sources) == {"gaze": "t/emergency_stop/sequence/idle"}


@shows("tick-target-once")
def test_a_target_holds_for_one_tick(spying: Workspace) -> None:
    glance = run(spying, "{emergency_stop: glance}")
    assert set(glance.tick().targets) == {"gaze"}
    assert set(glance.tick().targets) == set()


@shows("tick-error-no-command", "status-error")
def test_a_tick_with_an_exception_commits_nothing(workspace: Workspace) -> None:
    never = "{retry: {attempts: -1, inverter: {act: {script: x}}}}"
    broken = run(workspace, f"{{emergency_stop: {{parallel: [idle, {never}]}}}}")
    with pytest.raises(NodeError, match="out of order"):
        broken.tick()
    assert broken.robot.commit().targets == {}
    selector = run(workspace, "{selector: [{act: {script: x}}, {act: {name: instead}}]}")
    with pytest.raises(NodeError, match="out of order"):
        selector.tick()
    assert ("start", "instead") not in selector.log


@shows("tick-no-waiting")
def test_nothing_waits() -> None:
    modules = [*Path(humanoid_bt.tree.__file__).parent.rglob("*.py"), *(builtin_root() / "skills").glob("*.py")]
    assert {"timing.py", "reach.py"} <= {path.name for path in modules}
    for path in modules:
        assert not imports(path) & {"time", "datetime", "threading", "asyncio", "subprocess", "multiprocessing"}, path


def imports(path: Path) -> set[str]:
    """Return the top-level names of the modules that a file imports."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            found.add((node.module or "").partition(".")[0])
        elif isinstance(node, ast.Import):
            found.update(alias.name.partition(".")[0] for alias in node.names)
    return found


@shows("tick-slow-node")
def test_a_slow_node_changes_nothing_in_a_lockstep_run(project: Path) -> None:
    (project / "skills" / "spy.py").write_text(SPY, encoding="utf-8")
    hashes = set()
    for effort in (0, 300_000):
        (project / "trees" / "burn.yaml").write_text(
            f"format: 1\nroot: {{emergency_stop: {{burn: {{effort: {effort}}}}}}}\n", encoding="utf-8"
        )
        hashes.add(ran("burn", project, duration=0.2).report.trace_hash)
    assert len(hashes) == 1


@shows("status-values", "status-invalid")
def test_a_ticked_node_has_a_status_and_others_are_invalid(workspace: Workspace) -> None:
    selector = run(workspace, "{selector: [{act: {script: f}}, {act: {script: srr}}, act]}")

    def statuses() -> str:
        return "".join(node.behaviour.status.name[0] for node in selector.tree.nodes)

    assert statuses() == "IIII"
    selector.tick()
    assert statuses() == "SFSI"
    selector.tick()
    assert statuses() == "RFRI"
    selector.halt()
    assert statuses() == "IIII"


@shows("status-no-other")
def test_another_return_value_is_an_exception(workspace: Workspace) -> None:
    broken = run(workspace, "{selector: [{act: {script: n}}, act]}")
    with pytest.raises(NodeError, match="must be SUCCESS, FAILURE or RUNNING, not None"):
        broken.tick()


@shows("status-told")
def test_changes_are_told_once_and_children_first(workspace: Workspace) -> None:
    told = run(workspace, "{inverter: {sequence: [{act: {name: a, script: s}}, {act: {name: b, script: rrs}}]}}")
    told.tick()
    assert told.told() == [("a", "SUCCESS"), ("b", "RUNNING"), ("sequence", "RUNNING"), ("inverter", "RUNNING")]
    told.tick()
    assert told.told() == []
    told.tick()
    assert told.told() == [("b", "SUCCESS"), ("sequence", "SUCCESS"), ("inverter", "FAILURE")]
    idle = run(workspace, "{emergency_stop: idle}")
    idle.tick()
    assert idle.changes[0].feedback == "idle"


@shows("status-told-again")
@pytest.mark.parametrize(
    ("root", "told"),
    [
        ("{repeat: {times: 3, act: {script: s}}}", ["SUCCESS"] * 3),
        ("{repeat: {times: 2, sequence: [{act: {script: s}}, {wait: 0.1 s}]}}", ["SUCCESS", "", "SUCCESS"]),
        ("{retry: {attempts: 3, act: {script: rff}}}", ["RUNNING", "FAILURE", "FAILURE"]),
        ("{while: {condition: state.time < 1 s, inverter: {act: {script: fff}}}}", ["FAILURE"] * 3),
        ("{failure_is_running: {act: {script: f}}}", ["FAILURE"] * 3),
    ],
)  # fmt: skip
def test_a_skill_that_starts_and_ends_at_once_is_told_each_time(
    workspace: Workspace, root: str, told: list[str]
) -> None:
    assert acts(run(workspace, root), len(told)) == told


@shows("status-told-halted")
@pytest.mark.parametrize(
    ("root", "says"),
    [
        ("{force_failure: {parallel: [{act: {script: r}}, failure]}}", "halted: 'parallel' failed"),
        (
            "{force_failure: {parallel: [{sequence: [{act: {script: r}}, running]}, failure]}}",
            "halted: 'parallel' failed",
        ),
        ("{on_error: {act: {script: x}}}", "raised RuntimeError: out of order"),
    ],
)
def test_a_node_that_is_started_and_halted_in_one_tick_is_told_with_the_reason(
    workspace: Workspace, root: str, says: str
) -> None:
    life = run(workspace, root)
    for _ in range(2):
        life.tick()
        told = [(change.status.name, change.feedback) for change in life.changes if change.path.endswith("act")]
        assert told == [("INVALID", says)]
        assert all(change.feedback for change in life.changes if change.status.name == "INVALID")


@shows("status-told-reset")
@pytest.mark.parametrize(
    "above",
    [
        "{on_error: {sequence: [DO, {act: {name: bad, script: x}}]}}",
        "{running_is_success: {sequence: [DO, running]}}",
        "{force_success: {parallel: {failure: one, children: [{sequence: [DO, running]}, {act: {script: f}}]}}}",
    ],
)
def test_a_skill_that_ends_and_is_reset_in_one_tick_is_told_with_what_it_came_to(
    workspace: Workspace, above: str
) -> None:
    (workspace.root / "skills" / "weigh.py").write_text(
        "from humanoid_bt import Skill, result\n"
        "class Weigh(Skill):\n"
        "    grams: int = result(doc='Its weight.')\n"
        "    def update(self):\n"
        "        self.grams = 120\n"
        "        return self.succeed('weighed')\n"
    )
    life = run(workspace, above.replace("DO", "weigh"))
    for _ in range(2):
        life.tick()
        told = [change for change in life.changes if change.path.endswith("/weigh")]
        assert [(one.status.name, one.feedback) for one in told] == [("SUCCESS", "weighed"), ("INVALID", "")]
        assert [[result.value for result in one.results] for one in told] == [[120], []]


@shows("status-told-reset")
def test_so_is_one_that_ran_before_and_its_exception_ends_the_run(workspace: Workspace) -> None:
    life = run(workspace, "{sequence: [{act: {script: rs}}, {act: {name: bad, script: x}}]}")
    life.tick()
    with pytest.raises(NodeError):
        life.tick()
    assert life.told() == [("act", "SUCCESS"), ("bad", "INVALID"), ("act", "INVALID"), ("sequence", "INVALID")]


@shows("status-asked-again")
@pytest.mark.parametrize(
    "root",
    [
        "{reactive_sequence: [{act: {script: s}}, running]}",
        "{reactive_selector: [{inverter: {act: {script: s}}}, running]}",
        "{reactive_if: {condition: {act: {script: s}}, then: running}}",
        "{guard: {condition: {act: {script: s}}, running: }}",
        "{while: {condition: {act: {script: s}}, running: }}",
    ],
)
def test_a_skill_that_is_only_asked_again_is_told_when_it_changes(workspace: Workspace, root: str) -> None:
    assert acts(run(workspace, root), 3) == ["SUCCESS", "", ""]


def acts(under_test: Run, ticks: int) -> list[str]:
    """Return what is told of the act in each tick."""
    found = []
    for _ in range(ticks):
        under_test.tick()
        found.append(dict(under_test.told()).get("act", ""))
    return found


@shows("start-initialise")
def test_a_node_is_started_whenever_it_does_not_run(workspace: Workspace) -> None:
    act = run(workspace, "{act: {script: rrsfr}}")
    starts = []
    for _ in range(5):
        act.log.clear()
        act.tick()
        starts.append(("start", "act") in act.log)
    assert starts == [True, False, False, True, True]


@shows("end-terminate")
@pytest.mark.parametrize(("script", "end"), [("rs", "SUCCESS"), ("rf", "FAILURE")])
def test_terminate_is_called_once_with_the_result(workspace: Workspace, script: str, end: str) -> None:
    act = run(workspace, f"{{act: {{script: {script}}}}}")
    act.tick()
    act.log.clear()
    act.tick()
    assert act.log == [(end, "act")]


@shows("end-releases")
def test_a_skill_that_ends_releases_in_the_same_tick(spying: Workspace) -> None:
    assert run(spying, "{emergency_stop: blink}").tick().targets == {}
    assert run(spying, "{emergency_stop: glance}").tick().targets  # one that runs on keeps it
