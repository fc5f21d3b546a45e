"""The testing kit in a user's own project, run by a pytest of its own."""

from __future__ import annotations

import os
import re

import pytest

import humanoid_bt.testing.rig  # noqa: F401 (the inner pytest forgets what it imports, and numpy loads only once)
from tests.projects import make_project

TESTS = """
from humanoid_bt.core.errors import UserError
from humanoid_bt.tree.ticking.executor import NodeError
import pytest

def test_a_skill_of_this_project(rig):
    result = rig.run("pause", duration=0.3)
    assert result.succeeded, result.feedback
    assert result.time == pytest.approx(0.3)

def test_a_built_in_skill(rig):
    assert rig.run("idle", timeout="200 ms").commands
    with pytest.raises(UserError, match="'duration' must be a number above 0, not inf"):
        rig.settle(float("inf"))
    with pytest.raises(UserError, match="'timeout' must be a number above 0, not '2 m'"):
        rig.run("idle", timeout="2 m")

def test_every_test_starts_afresh(rig):
    assert rig.time == 0.0

def test_failures_come_with_feedback(rig):
    result = rig.run("give_up")
    assert result.failed
    assert result.feedback == "the thing is not there"

def test_an_exception_of_a_skill_reaches_the_test(rig):
    with pytest.raises(NodeError, match="KeyError: 'missing'"):
        rig.run("walk", raise_after=0.04)

def test_mistakes_name_what_is_valid(rig):
    with pytest.raises(UserError, match="did you mean 'pause'"):
        rig.run("puase")
    with pytest.raises(UserError, match="did you mean 'duration'"):
        rig.run("pause", durations=1)
    with pytest.raises(UserError, match="'side' cannot be 'lft'"):
        rig.hand_distance("lft", (0, 0, 0))
    for side, direction, axis, why in (
        ("lft", (1, 0, 0), "fingers", "'side' cannot be 'lft'"),
        ("left", (0, 0, 0), "fingers", "'direction' cannot be"),
        ("left", (1, 0, 0), "thumb", "'axis' cannot be 'thumb'"),
    ):
        with pytest.raises(UserError, match=why):
            rig.hand_turned(side, direction, axis)

def test_a_scripted_emergency_stop(rig):
    rig.at(0.1, rig.raise_estop)
    result = rig.run("walk", timeout=0.3)
    assert [stop.mode.value for stop in result.stops] == ["emergency_stop"]
    assert rig.settle(4.0).base_settled
"""


@pytest.fixture
def user(pytester: pytest.Pytester) -> pytest.Pytester:
    pytester.makepyfile(test_mine=TESTS)
    return pytester


def test_a_project_tests_its_skills_with_the_rig(user: pytest.Pytester) -> None:
    make_project(user.path)
    result = user.runpytest_inprocess("-p", "no:cacheprovider")
    result.assert_outcomes(passed=7)


@pytest.mark.parametrize("start", [".", "hello", "hello/tests"])
def test_the_workspace_is_the_nearest_one_above_the_test(pytester: pytest.Pytester, start: str) -> None:
    """As in a clone of the engine itself: pytest's root folder is a workspace too, but another one."""
    make_project(pytester.path / "hello")
    (pytester.path / "trees").mkdir()
    (pytester.path / "trees" / "other.yaml").touch()
    pytester.makepyprojecttoml("[tool.pytest.ini_options]\naddopts = '-q'\n")
    tests = pytester.path / "hello" / "tests" / "skills"
    tests.mkdir(parents=True)
    (tests / "test_pause.py").write_text("def test_it(rig):\n    assert rig.run('pause').succeeded\n")
    pytester.chdir()
    os.chdir(start)
    result = pytester.runpytest_inprocess("-p", "no:cacheprovider")
    result.assert_outcomes(passed=1)


def test_a_skill_that_is_not_there_names_the_workspace(user: pytest.Pytester) -> None:
    user.makepyfile(test_mine="def test_it(rig):\n    rig.run('hail')\n")
    result = user.runpytest_inprocess("-p", "no:cacheprovider")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*no skill named 'hail' in the workspace '*"])


def test_a_mistake_in_a_test_is_shown_at_its_own_line(user: pytest.Pytester) -> None:
    make_project(user.path)
    mistakes = (
        "rig.run('pause', durations=1)",
        "rig.run_tree('wait', dry=True, replace={'wait': {'recorded': 'no.rrd'}})",
        "rig.run_tree('wait', dry=True).expect('never: fel')",
    )
    tests = (f"def test_{number}(rig):\n    {mistake}\n" for number, mistake in enumerate(mistakes))
    user.makepyfile(test_mine="\n".join(tests))
    short, full = (user.runpytest_inprocess("-p", "no:cacheprovider", *options) for options in ((), ("--full-trace",)))
    shown, all_ = ([line for line in of.outlines if re.match(r"\S+\.py:\d+: ", line)] for of in (short, full))
    assert [line.rpartition(":")[0] for line in shown] == ["test_mine.py:2", "test_mine.py:5", "test_mine.py:8"]
    assert any("/humanoid_bt/testing/rig.py" in line for line in all_)


def test_an_exception_of_a_skill_is_shown_at_its_own_lines_and_the_line_of_the_test(user: pytest.Pytester) -> None:
    make_project(user.path)
    walk = "    resources = ('base',)\n    def update(self):\n        self.robot.walk_to((1, 2, 3), 0.0)\n"
    forget = "    def update(self):\n        self.running('on the way')\n"
    text = f"from humanoid_bt import Skill\nclass Stray(Skill):\n{walk}\nclass Forget(Skill):\n{forget}"
    (user.path / "skills" / "faulty.py").write_text(text)
    user.makepyfile(test_mine="def test_0(rig):\n    rig.run('stray')\n\ndef test_1(rig):\n    rig.run('forget')\n")
    shown = user.runpytest_inprocess("-p", "no:cacheprovider").outlines
    places = [line.rpartition(":")[0] for line in shown if re.match(r"\S+\.py:\d+: ", line)]
    assert places == ["skills/faulty.py:5", "test_mine.py:2", "test_mine.py:5"]


def test_the_workspace_can_lie_elsewhere(user: pytest.Pytester) -> None:
    make_project(user.path / "robot")
    user.makeini("[pytest]\nhumanoid_bt_workspace = robot\nhumanoid_bt_robot = humanoid\n")
    result = user.runpytest_inprocess("-k", "of_this_project", "-p", "no:cacheprovider")
    result.assert_outcomes(passed=1, deselected=6)


def test_an_unknown_robot_is_one_clear_message(user: pytest.Pytester) -> None:
    make_project(user.path)
    user.makeini("[pytest]\nhumanoid_bt_robot = humanoit\n")
    result = user.runpytest_inprocess("-k", "of_this_project", "-p", "no:cacheprovider")
    result.assert_outcomes(errors=1, deselected=6)
    result.stdout.fnmatch_lines(["*no robot named 'humanoit'*"])


def test_a_project_without_the_rig_pays_nothing(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        "import sys\ndef test_imports():\n    assert 'mujoco' not in sys.modules and 'py_trees' not in sys.modules\n"
    )
    result = pytester.runpytest_subprocess("-p", "no:cacheprovider")
    result.assert_outcomes(passed=1)


def test_the_fixture_explains_itself(pytester: pytest.Pytester) -> None:
    result = pytester.runpytest_inprocess("--fixtures", "-p", "no:cacheprovider")
    result.stdout.fnmatch_lines(["rig*", "*real simulated robot*"])
