"""A body in one file of the user's own."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from humanoid_bt.cli import main
from humanoid_bt.control.body.guarded import GuardedBody
from humanoid_bt.control.body.whole_body import WholeBody
from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import builtin_root
from humanoid_bt.session.lockstep import Lockstep
from humanoid_bt.session.session import Session
from humanoid_bt.testing.check_body import check_body

UNHURRIED = """\
from dataclasses import replace

import numpy as np

from humanoid_bt.control.body.whole_body import WholeBody
from humanoid_bt.core.messages import BaseTarget

NEXT = 0.5  # m


class Unhurried(WholeBody):
    \"\"\"Goes where it is sent in pieces of half a metre.\"\"\"

    def update(self, estimate, targets, hold):
        base = targets.get("base")
        if isinstance(base, BaseTarget):
            way = base.position - self.stance[:2]
            if (far := np.linalg.norm(way)) > NEXT:
                nearer = replace(base, position=self.stance[:2] + way * (NEXT / far))
                targets = {**targets, "base": nearer}
        return super().update(estimate, targets, hold)
"""


@pytest.fixture
def robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A robot whose ``robot.yaml`` names ``mine.py``."""
    monkeypatch.chdir(tmp_path)
    folder = Path(shutil.copytree(builtin_root() / "sim" / "humanoid", tmp_path / "sim" / "mine"))
    path = folder / "robot.yaml"
    path.write_text(path.read_text() + "\nbody: {walk: own, own: mine.py}\n")
    (folder / "mine.py").write_text(UNHURRIED)
    return path


def test_it_walks_in_place_of_the_others(robot: Path) -> None:
    with Session("stand", robot=robot, duration=0.2) as session:
        engine = session._drive.engine
        assert isinstance(engine, Lockstep)
        assert isinstance(engine.controller.body, GuardedBody)
        assert type(engine.controller.body.guarded).__name__ == "Unhurried"
        session.run()
        assert session.report.outcome == "unfinished"
    with Session("stand", robot=robot, body="dcm") as session:
        engine = session._drive.engine
        assert isinstance(engine, Lockstep)
        assert type(engine.controller.body) is WholeBody


def test_where_it_raises_the_robot_is_held_and_the_model_based_body_takes_over(robot: Path) -> None:
    raising = "        if estimate.time > 0.3:\n            raise RuntimeError('no more')\n        base = "
    robot.with_name("mine.py").write_text(UNHURRIED.replace("        base = ", raising, 1))
    line = raising.count("\n") + UNHURRIED[: UNHURRIED.index("        base = ")].count("\n")
    with Session("stand", robot=robot, duration=2.0) as session:
        engine = session._drive.engine
        assert isinstance(engine, Lockstep)
        report = session.run()
        assert type(engine.controller.body) is WholeBody
    (stop,) = report.stops
    assert stop["reason"] == f"RuntimeError: no more, raised at sim/mine/mine.py:{line}:13"
    assert stop["mode"] == "protective_stop"
    assert report.outcome == "unfinished"  # it stands, and did not fall
    assert report.reason.endswith(f"; the robot was in a protective stop: {stop['reason']} (body)")


@pytest.mark.trials
def test_it_keeps_every_rule_of_a_body(robot: Path) -> None:
    check_body(robot).assert_passed()


@pytest.mark.trials
def test_bench_body_tries_it_beside_the_model_based_one(robot: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["bench", "--body", "--robot", str(robot), "--only", "push-standing-60", "--trials", "1", "--json", "b.json"])
    assert {"own", "dcm"} <= set(capsys.readouterr().out.split())
    assert {row["body"] for row in json.loads(Path("b.json").read_text())["rows"]} == {"own", "dcm"}


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("import nothing_of_this_name\n", "mine.py:1:1: error: the file of a body cannot be imported"),
        ("x = 1\n", "mine.py:1:1: error: this file has no body"),
        (UNHURRIED + "\nclass Other(Unhurried):\n    pass\n", "this file has 2 bodies: Unhurried, Other"),
        (
            "class Mine:\n    def update(self, estimate, targets, hold): ...\n",
            "mine.py:1:1: error: Mine cannot be made",
        ),
        (
            "class Mine:\n    def __init__(self, *_): ...\n    def update(self, estimate, targets, hold): ...\n",
            "mine.py:1:1: error: the body Mine has no arms, com_error,",
        ),
        (
            UNHURRIED
            + "\n    def __init__(self, *of):\n        super().__init__(*of)\n        raise ValueError('bad file')\n",
            "mine.py:25:9: error: the body Unhurried cannot be made: ValueError: bad file",
        ),
        (
            UNHURRIED + "\n    def __init__(self, *of):\n        super().__init__(*of)\n        len(5)\n",
            "mine.py:25:9: error: the body Unhurried cannot be made: TypeError: object of type 'int' has no len()",
        ),
        (
            UNHURRIED
            + "\n    def reset(self, estimate):\n        raise RuntimeError('in reset')\n\nclass Helper: ...\n",
            "mine.py:24:9: error: the body Unhurried cannot begin a run: RuntimeError: in reset",
        ),
        (
            UNHURRIED + "\n    period = 0.0033\n",
            "mine.py:11:1: error: the body Unhurried has a period of 0.0033 s",
        ),
        (
            UNHURRIED + "\n    def __init__(self, *of):\n        super().__init__(*of)\n        self.period = 0.0\n",
            "mine.py:11:1: error: the body Unhurried has a period of 0.0 s",
        ),
    ],
)
def test_a_file_that_has_no_body_is_refused_with_its_line(robot: Path, text: str, says: str) -> None:
    robot.with_name("mine.py").write_text(text)
    with pytest.raises(UserError) as caught:
        Session("stand", robot=robot)
    assert says in str(caught.value)


def test_a_file_that_is_missing_is_refused_in_robot_yaml(robot: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot.with_name("mine.py").unlink()
    assert main(["check", str(robot)]) == 2
    assert "error: the body 'mine.py' is missing" in capsys.readouterr().out


def test_a_robot_without_one_says_what_is_missing() -> None:
    with pytest.raises(UserError, match="there is no body of your own") as caught:
        Session("stand", body="own")
    assert caught.value.problems[0].hint == "body: {walk: own, own: my_body.py}"
