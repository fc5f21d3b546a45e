"""What a skill does to the program that runs it: nothing, but for what it says."""

from __future__ import annotations

import dataclasses
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import humanoid_bt as hbt
from humanoid_bt.tree.nodes import Sequence
from tests.projects import make_project

SKILLS = '''
import multiprocessing, os, sys, threading, time
from humanoid_bt import Skill, Status, param

class Speak(Skill):
    """Say what is no text."""
    how: str = param("running", doc="How.")

    def update(self):
        if self.how == "attribute":
            self.feedback_message = 43
            return Status.RUNNING
        return getattr(self, self.how)(ValueError("no handle") if self.how == "fail" else 42)

class Write(Skill):
    """Write into what everybody sees."""

    def update(self):
        self.robot.state.base_position[:] = 0.0
        return self.succeed("written")

def sleep(begun):
    begun.set()
    time.sleep(20)

class Fork(Skill):
    """Fork a process, and wait for its end."""
    how: str = param(doc="What becomes of it.")

    def initialise(self):
        if self.how == "terminated":
            fork = multiprocessing.get_context("fork")
            begun = fork.Event()
            sleeper = fork.Process(target=sleep, args=(begun,))
            sleeper.start()
            begun.wait()
            sleeper.terminate()
            self._child = sleeper.pid
            return
        self._child = os.fork()
        if not self._child:
            if self.how == "raises":
                raise RuntimeError("in the child")
            if self.how == "exits":
                sys.exit(7)
            if self.how == "interrupts":
                raise KeyboardInterrupt

    def update(self):
        if not self._child:
            return self.running("as if it were the robot")
        child, status = os.waitpid(self._child, os.WNOHANG)
        return self.succeed(f"code {os.waitstatus_to_exitcode(status)}") if child else self.running("waiting")

class Stray(Skill):
    """Start a thread that does not end."""

    def update(self):
        threading.Thread(target=time.sleep, args=(600,), name="driver of the gripper").start()
        return self.succeed("started")

class Forget(Skill):
    """Forget to return its status, or return another thing."""
    returned: bool | None = param(None, doc="What it returns.")

    def update(self):
        status = self.running("on the way")
        return self.returned

class Misspell(Skill):
    """Call what the robot does not have."""
    resources = ("left_hand",)

    def update(self):
        self.robot.move_hnd("left", (0.4, 0.2, 0.9))
        return self.running("moving")

class Unmade(Skill):
    """Take the place of what makes it a node."""
    width: float = param(1.0, doc="How wide.")

    def __init__(self, name, width=1.0):
        self.tries = 0

    def update(self):
        return self.succeed("made")

class Unready(Skill):
    """Take the place of what gives it the robot."""

    def setup(self, **kwargs):
        self.tries = 0

    def update(self):
        return self.succeed(self.robot.state.mode.value)
'''


@pytest.fixture(scope="module")
def faulty(tmp_path_factory: pytest.TempPathFactory) -> Path:
    project = make_project(tmp_path_factory.mktemp("user") / "project")
    (project / "skills" / "faulty.py").write_text(SKILLS, encoding="utf-8")
    return project


def tree(project: Path, root: str) -> Path:
    path = project / "trees" / "faulty.yaml"
    path.write_text(f"format: 1\nroot: {{{root}}}\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("how", "outcome", "said"),
    [
        ("running", "unfinished", "42"),
        ("succeed", "success", "42"),
        ("fail", "failure", "no handle"),
        ("attribute", "unfinished", "43"),
    ],
)
def test_what_is_no_text_is_said_as_text(faulty: Path, how: str, outcome: str, said: str) -> None:
    report = hbt.run(tree(faulty, f"speak: {{how: {how}}}"), duration=0.04)
    assert report.outcome == outcome
    assert said in report.reason


@pytest.mark.parametrize(
    ("given", "said"), [("", "not None: was 'return' forgotten?"), ("{returned: true}", "not True")]
)
def test_what_returns_no_status_is_told_with_its_place(faulty: Path, given: str, said: str) -> None:
    line = next(n for n, text in enumerate(SKILLS.splitlines(), 1) if "class Forget" in text) + 4
    report = hbt.run(tree(faulty, f"forget: {given}"), duration=0.04)
    assert f"its status must be SUCCESS, FAILURE or RUNNING, {said}\n    its update is at " in report.reason
    assert report.reason.endswith(f"faulty.py:{line}:5")


def test_what_a_skill_misspells_is_told_with_what_it_may_mean(faulty: Path) -> None:
    report = hbt.run(tree(faulty, "emergency_stop: misspell"), duration=0.04)
    said = "AttributeError: 'RobotHandle' object has no attribute 'move_hnd'; did you mean 'move_hand'?"
    assert said in report.reason


def test_nobody_writes_into_what_everybody_sees(faulty: Path) -> None:
    report = hbt.run(tree(faulty, "write: "))
    assert report.outcome == "error"
    assert "raised ValueError: assignment destination is read-only" in report.reason
    with hbt.Session("wait", workspace=faulty) as session:
        session.step()
        arrays = [value for value in vars_of(session.state) if isinstance(value, np.ndarray)]
        assert len(arrays) > 10
        assert not [array for array in arrays if array.flags.writeable]
        assert not [value for value in vars_of(session.state) if isinstance(value, dict)]
        with pytest.raises(TypeError, match="does not support item assignment"):
            session.state.hands["left"] = np.zeros(3)  # type: ignore[index]  # as a skill without types does


@pytest.mark.parametrize(
    ("skill", "method", "call"),
    [("unmade", "Unmade.__init__", "super().__init__()"), ("unready", "Unready.setup", "super().setup(**kwargs)")],
)
def test_what_a_skill_overrides_and_does_not_call_is_named(faulty: Path, skill: str, method: str, call: str) -> None:
    begin = f"def {method.partition('.')[2]}("
    line = next(n for n, text in enumerate(SKILLS.splitlines(), 1) if begin in text)
    said = re.escape(f"faulty.py:{line}:5: error: {method} does not call {call} [broken-skill]")
    with pytest.raises(hbt.UserError, match=said) as twice:
        hbt.run(tree(faulty, f"sequence: [{{{skill}: {{name: a}}}}, {{{skill}: {{name: b}}}}]"))
    assert len(twice.value.problems) == 1
    for use in (lambda: hbt.check_skill(skill, workspace=faulty), lambda: hbt.Rig(faulty).run(skill)):
        with pytest.raises(hbt.UserError, match=said):
            use()


def test_nor_can_one_stand_in_a_tree_made_in_python() -> None:
    class Unmade(hbt.Skill):
        """Take the place of what makes it a node."""

        def __init__(self, name: str) -> None:
            self.tries = 0

        def update(self) -> hbt.Status:
            return self.succeed("made")

    with pytest.raises(hbt.UserError, match=r"Unmade.__init__ does not call super\(\).__init__\(\)"):
        Sequence("all", [Unmade("one")])


def vars_of(state: hbt.State) -> list[object]:
    return [*(getattr(state, field.name) for field in dataclasses.fields(state)), *state.hands.values()]


CHILDREN = {"raises": 1, "exits": 7, "returns": 1, "interrupts": 1, "terminated": -signal.SIGTERM}


def test_forked_children_end_alone(faulty: Path) -> None:
    forks = ", ".join(f"fork: {{name: {how}, how: {how}}}" for how in CHILDREN)
    tree(faulty, f"timeout: {{duration: 10 s, sequence: [{forks}]}}")
    command = [sys.executable, "-m", "humanoid_bt", "run", "faulty", "--no-record", "--no-view", "--pace", "20"]
    done = subprocess.run(command, cwd=faulty, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    for how, code in CHILDREN.items():
        assert len(re.findall(rf"✓ {how} +code {code}\n", done.stdout)) == 1
    assert done.stdout.count("simulated") == 1
    said = [line for line in done.stderr.splitlines() if re.match(r"\w+(:|$)", line)]
    came_back = "a process that 'returns' forked came back from it: it must end with os._exit()"
    assert said == ["RuntimeError: in the child", f"RuntimeError: {came_back}", "KeyboardInterrupt"]


@pytest.mark.trials
def test_a_thread_that_does_not_end_does_not_keep_the_program(faulty: Path) -> None:
    tree(faulty, "stray: ")
    command = [sys.executable, "-m", "humanoid_bt", "run", "faulty", "--no-record", "--no-view"]
    done = subprocess.run(command, cwd=faulty, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0
    assert "success: stray: started" in done.stdout
    assert "the thread 'driver of the gripper' still runs" in done.stderr
