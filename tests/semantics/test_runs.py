"""Whole runs: exceptions, ends, exit codes, and what is refused before."""

from __future__ import annotations

import math
import signal
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Literal

import pyarrow as pa
import pytest
import rerun as rr
import yaml

from humanoid_bt.cli import keys, main
from humanoid_bt.core.errors import ControlLost, UserError
from humanoid_bt.core.messages import Mode
from humanoid_bt.decision.blackboard import Key
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.session.lockstep import Lockstep
from humanoid_bt.session.options import RunOptions
from humanoid_bt.session.session import Session
from humanoid_bt.tree.ticking.executor import NodeError
from tests.semantics.claims import shows
from tests.session.helpers import Ran, after, ran
from tests.tree.helpers import Run as Ticked
from tests.tree.helpers import load, run

SKILLS = """
import signal

from humanoid_bt import RobotHandle, Skill, Status
from humanoid_bt.core.params import param


class Signal(Skill):
    number: int = param(doc="The signal that comes.")
    times: int = param(1, doc="How often.")

    def update(self):
        for _ in range(self.times):
            signal.raise_signal(self.number)
        return self.running("")


class Thief(Skill):
    def setup(self, **kwargs):
        self.robot = RobotHandle(kwargs["robot"], self.path, ("base",))

    def update(self):
        self.robot.walk_to((1.0, 0.0), 0.0)
        return self.running("")
"""


def tree(project: Path, name: str, root: str) -> str:
    """Write a tree of the project; return its name."""
    (project / "skills" / "more.py").write_text(SKILLS, encoding="utf-8")
    (project / "trees" / f"{name}.yaml").write_text(f"format: 1\nroot: {root}\n", encoding="utf-8")
    return name


@pytest.fixture(scope="session")
def raised(project: Path, tmp_path_factory: pytest.TempPathFactory) -> Ran:
    """A run in which a skill that walks raises an exception after 0.3 s."""
    name = tree(project, "late", "{emergency_stop: {sequence: [{wait: 40 ms}, {walk: {raise_after: 0.3}}]}}")
    return ran(name, project, tmp_path_factory.mktemp("raise") / "raise.rrd")


# ---- exceptions ----------------------------------------------------------------------------------------------------


@shows("error-ends", "exit-error", "error-safe-hold")
def test_an_exception_ends_the_run(raised: Ran, project: Path) -> None:
    assert raised.report.exit_code == 4
    assert [stop["mode"] for stop in raised.report.stops] == ["protective_stop"]
    assert raised.session.engine.sense()[0].mode is Mode.PROTECTIVE_STOP
    for error in ("SystemExit", "CancelledError", "KeyboardInterrupt"):
        leaves = tree(project, "leaves", f"{{emergency_stop: {{leave: {{after: 0 s, error: {error}}}}}}}")
        assert ran(leaves, project).report.exit_code == 4


@shows("exit-error")
def test_two_owners_end_the_run(project: Path) -> None:
    thieves = tree(project, "thieves", "{emergency_stop: {parallel: [walk, thief]}}")
    report = ran(thieves, project).report
    assert report.exit_code == 4
    assert "'base' is commanded by two nodes at once" in report.reason


@shows("error-node-first", "error-halts")
def test_an_exception_halts_the_whole_tree(workspace: Workspace) -> None:
    broken = run(
        workspace, "{parallel: [{act: {name: a}}, {inverter: {act: {name: bad, script: x}}}, {act: {name: c}}]}"
    )
    with pytest.raises(NodeError):
        broken.tick()
    assert broken.log == [("start", "a"), ("start", "bad"), ("INVALID", "bad"), ("INVALID", "a")]
    broken = run(workspace, "{timeout: {duration: 9, parallel: [{act: {name: a}}, {act: {name: bad, script: rx}}]}}")
    broken.tick()
    with pytest.raises(NodeError):
        broken.tick()
    assert broken.told() == [(name, "INVALID") for name in ("bad", "a", "parallel", "timeout")]


@shows("error-message")
def test_the_message_says_where(raised: Ran, project: Path) -> None:
    lines = (project / "skills/mine.py").read_text(encoding="utf-8").splitlines()
    line = 1 + lines.index('            raise KeyError("missing")')
    for part in (
        f"{project / 'trees/late.yaml'}:2:",
        "'late/emergency_stop/sequence/walk' raised KeyError: 'missing'",
        f"raised at {project / 'skills/mine.py'}:{line}:",
    ):
        assert part in raised.report.reason


@shows("error-recorded")
def test_the_recording_has_the_exception_and_the_commands(raised: Ran) -> None:
    assert raised.recording is not None
    texts: list[str] = []
    for chunk in rr.chunk.RrdReader(raised.recording).stream():
        batch = chunk.to_record_batch()
        for column, field in zip(batch.columns, batch.schema, strict=True):
            if pa.types.is_list(field.type) and pa.types.is_string(field.type.value_type):
                texts += [text for row in column.to_pylist() for text in row or ()]
    assert any("raised KeyError: 'missing'" in text for text in texts)
    assert any("late/emergency_stop/sequence/walk" in text for text in texts)


# ---- the end of a run ----------------------------------------------------------------------------------------------


@shows("exit-success", "exit-failure", "end-root")
def test_the_root_decides(project: Path) -> None:
    success, failure = ran("wait", project), ran("give_up", project)
    assert (success.report.exit_code, failure.report.exit_code) == (0, 1)
    assert [change.status.name for change in success.told.changes if change.path.endswith("pause")] == [
        "RUNNING",
        "SUCCESS",
    ]


SMOKE = "{raise_emergency_stop: {reason: smoke}}"


@shows("exit-stopped", "exit-waits", "exit-while-stopped")
@pytest.mark.parametrize(
    "root", [f"{{emergency_stop: {{parallel: [pause, {SMOKE}]}}}}", f"{{parallel: [{SMOKE}, running]}}"]
)
@pytest.mark.parametrize(("on_estop", "end"), [(None, 0.02), ("end", 0.02), ("wait", 0.5)])
def test_an_emergency_stop(project: Path, root: str, on_estop: Literal["wait", "end"] | None, end: float) -> None:
    report = ran(tree(project, "stop", root), project, duration=0.5, on_estop=on_estop).report
    assert (report.outcome, report.exit_code) == ("stopped", 3)
    assert report.reason.startswith("smoke (stop/")
    assert report.sim_time == pytest.approx(end)


@shows("exit-while-stopped")
def test_a_tree_that_ends_while_the_robot_is_stopped(project: Path) -> None:
    root = f"{{sequence: [{{force_success: {{timeout: {{duration: 200 ms, {SMOKE[1:-1]}}}}}}}]}}"
    report = ran(tree(project, "past", root), project, on_estop="wait").report
    assert (report.outcome, report.exit_code) == ("stopped", 3)
    assert report.reason.endswith("; the tree ended")


@shows("exit-while-stopped")
def test_a_run_that_somebody_ends_while_the_robot_is_stopped(project: Path) -> None:
    name = tree(project, "stop", f"{{emergency_stop: {SMOKE}}}")
    report = ran(name, project, on_estop="wait", interrupted=after(20, "Ctrl-C")).report
    assert (report.exit_code, report.reason) == (3, "smoke (stop/emergency_stop/raise_emergency_stop); Ctrl-C")


@shows("exit-fall")
@pytest.mark.parametrize("on_estop", [pytest.param("wait", marks=pytest.mark.trials), "end"])
def test_a_fall_ends_the_run(project: Path, on_estop: Literal["wait", "end"]) -> None:
    with Session("walk", workspace=project, on_estop=on_estop) as session:
        session.push((600.0, 0.0, 0.0), duration=0.3)
        session.run_until(5.0)
    report = session.report
    assert (report.outcome, report.exit_code, report.fell) == ("stopped", 3, True)
    assert report.reason.endswith("(supervisor); a fall ends the run")


@shows("exit-duration")
def test_the_duration_is_over(project: Path) -> None:
    report = ran("wait", project, duration=0.1).report
    assert (report.outcome, report.exit_code, report.sim_time) == ("unfinished", 5, 0.1)
    assert report.reason.startswith("the tree still ran after 0.1 s at 'wait/emergency_stop/pause'"), report.reason
    assert "--duration" in report.reason


@shows("exit-limit")
def test_the_limit_of_a_run_without_a_duration(workspace: Workspace) -> None:
    quick = load(workspace, "root: {timeout: {duration: 1 min, act: }}")
    slow = load(
        workspace, "root: {sequence: [{timeout: {duration: 9 min, act: }}, {timeout: {duration: 3 min, act: }}]}"
    )
    assert [RunOptions(tree).limit(False, tree) for tree in (quick, slow)] == [600.0, 720.0]
    assert RunOptions(slow, duration=2.0).limit(True, slow) == 2.0
    for options, watched in (
        (RunOptions(quick, mode="realtime"), False),
        (RunOptions(quick, watch=True), False),
        (RunOptions(quick), True),
    ):
        assert options.limit(watched, quick) == math.inf
        assert options.waits(watched)


@shows("exit-control-gone")
def test_control_is_gone(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def gone(_engine: Lockstep) -> None:
        raise ControlLost("the control process was killed")

    monkeypatch.setattr(Lockstep, "advance", gone)
    report = ran("walk", project).report
    assert (report.exit_code, report.reason) == (4, "the control process was killed")


@shows("exit-interrupted", "end-second")
@pytest.mark.parametrize(
    ("root", "reason"),
    [
        (f"{{signal: {{number: {signal.SIGINT:d}}}}}", "Ctrl-C"),
        (f"{{signal: {{number: {signal.SIGTERM:d}}}}}", "SIGTERM"),
        (f"{{signal: {{number: {signal.SIGINT:d}, times: 2}}}}", "stopped at once"),
    ],
)
def test_a_signal_ends_the_run(
    project: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], root: str, reason: str
) -> None:
    monkeypatch.chdir(project)
    assert main(["run", tree(project, "signal", root), "--no-record"]) == 130
    assert reason in capsys.readouterr().out


@shows("exit-interrupted")
def test_the_key_q_ends_the_run(
    project: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    @contextmanager
    def press_q(actions: Mapping[str, Callable[[], None]], _prompts: object) -> Iterator[None]:
        actions["q"]()
        yield

    monkeypatch.chdir(project)
    monkeypatch.setattr(keys, "available", lambda: True)
    monkeypatch.setattr(keys, "listening", press_q)
    assert main(["run", "wait", "--no-record"]) == 130
    assert "the key q" in capsys.readouterr().out


@shows("end-stand")
@pytest.mark.parametrize("end", ["interrupted", "duration"])
def test_the_robot_comes_to_a_stand(project: Path, end: str) -> None:
    walked = (
        ran("walk", project, interrupted=after(50, "enough"))
        if end == "interrupted"
        else ran("walk", project, duration=1.0)
    )
    assert walked.told.changes[-1].status.name == "INVALID"
    state = walked.session.engine.sense()[0]
    assert state.base_settled
    assert dict(state.command_sources) == {}
    assert walked.report.sim_time < state.time <= walked.report.sim_time + 5


# ---- before the first tick -----------------------------------------------------------------------------------------


@shows("before-all")
def test_check_and_run_find_the_same(
    project: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(project)
    name = tree(
        project, "wrong", "{emergency_stop: {sequence: [{pause: {duratio: 1}}, {pause: {duration: 1 m}}, walc]}}"
    )
    try:
        found = {}
        for command in (["check", name], ["run", name, "--no-record"]):
            assert main(command) == 2
            output = capsys.readouterr()
            found[command[0]] = [line for line in (output.out + output.err).splitlines() if "wrong.yaml:2:" in line]
        assert found["check"] == found["run"]
        assert len(found["check"]) == 3
    finally:
        (project / "trees" / "wrong.yaml").unlink()


@shows("before-emergency-stop")
def test_a_command_needs_an_emergency_stop(workspace: Workspace) -> None:
    with pytest.raises(UserError, match="'idle' commands gaze, posture outside an emergency_stop"):
        load(workspace, "root: {sequence: [{emergency_stop: act}, idle]}")


@shows("before-watchdog")
def test_a_percept_needs_a_watchdog(workspace: Workspace) -> None:
    near = "within: {percept: target, distance: 1}"
    with pytest.raises(UserError, match="'within' uses the percept 'target' outside a watchdog on it"):
        load(workspace, f"root: {{{near}}}")
    with pytest.raises(UserError, match="outside a watchdog"):
        load(workspace, f"root: {{watchdog: {{percept: target, max_age: 1, on_stale: {{{near}}}, act: }}}}")
    load(workspace, f"root: {{watchdog: {{percept: target, max_age: 1, on_stale: act, {near}}}}}")


PICKY = """
from humanoid_bt.core.errors import UserError
from humanoid_bt.decision.skill import Skill, Status

class Picky(Skill):
    def setup(self, **kwargs):
        raise UserError("there is no tail")
    def update(self):
        raise AssertionError("it was ticked")
"""


@shows("before-setup")
def test_setup_comes_before_anything_moves(workspace: Workspace) -> None:
    (workspace.root / "skills" / "picky.py").write_text(PICKY, encoding="utf-8")
    with pytest.raises(
        UserError, match=r"t.yaml:2:19: error: there is no tail\n.*t.yaml:2:26: error: there is no tail"
    ):
        run(workspace, "{sequence: [picky, picky]}")
    calls: list[str] = []
    counted = load(workspace, "root: {sequence: [{act: {name: a}}, {timeout: {duration: 1, act: {name: b}}}]}")
    for node in counted.nodes:
        before = node.behaviour.setup

        def count(name: str = node.name, before: object = before, **values: object) -> None:
            calls.append(name)
            before(**values)  # type: ignore[operator]  # py_trees declares none

        node.behaviour.setup = count  # type: ignore[method-assign]  # this node alone
    Ticked(counted).ticks(2)
    assert sorted(calls) == ["a", "b", "sequence", "timeout"]


CURIOUS = """
import py_trees

class Curious(py_trees.behaviour.Behaviour):
    def setup(self, **kwargs):
        self.got = kwargs
    def update(self):
        return py_trees.common.Status.SUCCESS
"""


@shows("before-setup-gets")
def test_setup_gets_the_robot(workspace: Workspace) -> None:
    (workspace.root / "skills" / "curious.py").write_text(CURIOUS, encoding="utf-8")
    curious = run(workspace, "curious")
    assert vars(curious.tree.root)["got"] == {"robot": curious.robot}
    curious.clock.cycle = 40
    assert curious.robot.clock.now() == curious.clock.now() == 0.04
    keyed = run(workspace, "{set_blackboard: {key: k, value: 1}}")
    assert isinstance(vars(keyed.tree.root)["key"], Key)


@shows("before-robot")
def test_a_robot_or_a_scene_that_is_not_there(workspace: Workspace) -> None:
    for header in ("robot: humanoit", "scene: emty"):
        with pytest.raises(UserError, match="did you mean"):
            load(workspace, f"{header}\nroot: success")
    humanoid, handless = builtin_root() / "sim" / "humanoid", workspace.root / "sim" / "handless"
    handless.mkdir(parents=True)
    config = yaml.safe_load((humanoid / "robot.yaml").read_text(encoding="utf-8"))
    del config["hands"]
    (handless / "robot.yaml").write_text(yaml.safe_dump(config | {"name": "handless"}), encoding="utf-8")
    (handless / "humanoid.xml").write_bytes((humanoid / "humanoid.xml").read_bytes())
    reach = "watchdog: {percept: target, max_age: 1, reach: {target: target}}"
    with pytest.raises(UserError, match="'reach' commands left_hand, right_hand: the robot 'handless' has none"):
        load(workspace, f"robot: handless\nroot: {{emergency_stop: {{{reach}}}}}")


@shows(
    *("before-unreachable", "before-hysteresis", "before-starts-again", "before-at-once", "before-time-limit"),
    "before-decided",
)
@pytest.mark.parametrize(
    ("root", "codes"),
    [
        ("{selector: [running, success]}", ["unreachable"]),
        ("{selector: [{act: }, success]}", []),
        ("{if: {condition: 1 < 2, then: success, else: failure}}", ["unreachable"]),
        ("{if: {condition: n < 2, then: success, else: failure}}", []),
        ("{timeout: {duration: 1, success: }}", ["no-effect"]),
        ("{reactive_sequence: [{condition: distance(target) < 1}, {act: }]}", ["no-hysteresis"]),
        ("{reactive_sequence: [{condition: distance(target) < 1 hysteresis 0.1}, {act: }]}", []),
        ("{reactive_sequence: [{act: }, {reach: {target: target}}]}", ["starts-again"]),
        ("{reactive_selector: [{act: }, idle]}", ["starts-again"]),
        ("{sequence: [{act: }, {reach: {target: target}}]}", []),
        ("{reactive_sequence: [{selector: [{condition: n < 2}, {act: }]}, {reach: {target: target}}]}", []),
        ("{approach: {target: target}}", ["no-time-limit"]),
        ("{timeout: {duration: 9, approach: {target: target}}}", []),
    ],
)
def test_warnings(workspace: Workspace, root: str, codes: list[str]) -> None:
    above = f"emergency_stop: {{watchdog: {{percept: target, max_age: 1, sequence: [{{condition: n > 0}}, {root}]}}}}"
    found = load(workspace, f"parameters: {{n: 1}}\nroot: {{{above}}}").warnings
    assert [problem.code for problem in found] == codes


@shows("before-scene")
def test_a_percept_that_no_scene_publishes(project: Path) -> None:
    dog = tree(project, "nothing", "{watchdog: {percept: unicorn, max_age: 1, on_stale: success, running: }}")
    done = ran(dog, project)
    assert done.report.exit_code == 0
    assert any("publishes no percept 'unicorn'" in text for _, level, text in done.told.events if level == "warning")
