"""What check_body, and check, say of a body that fails."""

from __future__ import annotations

import shutil
from itertools import count
from pathlib import Path

import pytest

from humanoid_bt.checking import robot_motion
from humanoid_bt.checking.robot import robot_problems
from humanoid_bt.files.workspace import builtin_root
from humanoid_bt.testing import check_body as module
from humanoid_bt.testing.check_body import check_body
from humanoid_bt.testing.conformance import RuleOutcome

MINE = """\
from humanoid_bt.control.body.whole_body import WholeBody


class Mine(WholeBody):
    def update(self, estimate, targets, hold):
        if estimate.time > 0.2:
            raise KeyError("oops")
        return super().update(estimate, targets, hold)
"""
GOOD = MINE.replace("0.2", "1e9")


@pytest.fixture(autouse=True)
def briefly(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("_STAND", "_WALK", "_SET_OUT", "_STOP", "_HOLD", "_FALL"):
        monkeypatch.setattr(module, name, 0.3)
    monkeypatch.setattr(robot_motion, "_WALK", 1)


@pytest.fixture
def robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A robot whose body is ``mine.py``."""
    monkeypatch.chdir(tmp_path)
    folder = Path(shutil.copytree(builtin_root() / "sim" / "humanoid", tmp_path / "mine"))
    path = folder / "robot.yaml"
    path.write_text(path.read_text() + "\nbody: {walk: own, own: mine.py}\n")
    return path


def rules(robot: Path, text: str) -> dict[str, RuleOutcome]:
    robot.with_name("mine.py").write_text(text)
    return {rule.name: rule for rule in check_body(robot).rules}


def test_a_body_that_fails_keeps_no_rule_whatever_the_robot_does_then(robot: Path) -> None:
    found = rules(robot, MINE)
    failed = "its body failed after 0.2 s: KeyError: 'oops', raised at mine/mine.py:7:13"
    assert found["stands"] == RuleOutcome("stands", False, failed)
    assert found["same"] == RuleOutcome("same", False, failed)


@pytest.mark.parametrize(
    ("method", "says"),
    [
        ("def __init__(self, *of):\n        raise OSError('no weights')", "cannot be made: OSError: no weights"),
        ("def reset(self, estimate):\n        raise OSError('no weights')", "cannot begin a run: OSError: no weights"),
    ],
)
def test_a_body_that_does_not_begin_is_told_of_and_not_raised(robot: Path, method: str, says: str) -> None:
    found = rules(robot, f"{GOOD}\n    {method}\n")
    assert f"mine/mine.py:11:9: error: the body Mine {says}" in found["begins"].shown


def test_a_body_that_does_not_begin_again_keeps_no_rule_of_the_next_run(robot: Path) -> None:
    again = "def reset(self, estimate):\n        self.begun = super().reset(estimate) is None and not self.begun"
    again += "\n        assert self.begun, 'once'"
    found = rules(robot, f"{GOOD}\n    begun = False\n\n    {again}\n")
    assert "cannot begin a run: AssertionError: once" in found["stops"].shown


@pytest.mark.parametrize(("steps", "in_time"), [(0.004, True), (0.006, False)])
def test_updates_may_take_half_of_the_period(
    robot: Path, monkeypatch: pytest.MonkeyPatch, steps: float, in_time: bool
) -> None:
    ticks = count()
    monkeypatch.setattr(module, "perf_counter", lambda: next(ticks) * steps)
    outcome = rules(robot, GOOD)["in time"]
    assert outcome.passed is in_time
    assert outcome.shown == f"an update takes {steps * 1000:.1f} ms, it may take half of the period of 10 ms"


def test_what_stopped_the_robot_is_told_beside_a_rule_that_it_did_not_keep(robot: Path) -> None:
    stops = rules(robot, GOOD)["stops"]
    assert not stops.passed
    assert stops.shown.endswith("; stopped after 0.4 s: decision silent for more than 100 ms")


def test_check_tells_of_a_body_that_fails_in_place_of_drives_and_postures(robot: Path) -> None:
    robot.with_name("mine.py").write_text(MINE)
    (problem,) = robot_problems(robot)
    assert (problem.code, str(problem.place)) == ("failed-body", "mine/mine.py:4:1")
    assert problem.message == "its body failed after 0.2 s: KeyError: 'oops', raised at mine/mine.py:7:13"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (MINE.replace(":\n", "\n", 1), "the file of a body cannot be imported: SyntaxError: expected ':'"),
        ("import nothing_like_it", "the file of a body cannot be imported: ModuleNotFoundError"),
        (
            MINE + "\n    def reset(self, estimate):\n        raise OSError('no')\n",
            "the body Mine cannot begin a run: OS",
        ),
    ],
)
def test_check_loads_a_body_that_is_there_only_to_be_tried(
    robot: Path, monkeypatch: pytest.MonkeyPatch, text: str, message: str
) -> None:
    monkeypatch.setattr(robot_motion, "_moved", lambda trial: [])
    robot.write_text(robot.read_text().replace("walk: own, ", ""))
    robot.with_name("mine.py").write_text(text)
    (problem,) = robot_problems(robot)
    assert problem.message.startswith(message)
    assert problem.place
    assert problem.place.file == "mine/mine.py"
