"""How fast a robot is simulated, with few cycles: what is measured, not how much it is."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from humanoid_bt.bench import control, speed
from humanoid_bt.bench.figure import figure
from humanoid_bt.bench.promises import ARMS, WALKER_SPEED, Promise
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.robot.config import Walk
from humanoid_bt.robot.model import BASE_COORDINATES
from tests.policy_files import write_standing_robot

ROBOT = Workspace(builtin_root()).find_robot("humanoid").absolute()


@pytest.fixture(autouse=True)
def briefly(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(control, "_CYCLES", 40)
    monkeypatch.setattr(speed, "_CYCLES", 40)
    monkeypatch.setattr(speed, "_BEGIN", 200)


def measured(robot: Path, body: str) -> dict[str, Promise | None]:
    figures = list(speed.measure_speed(robot, [body], 2))  # type: ignore[list-item]  # body is one of the two
    assert all(0 < one.low <= one.ratio <= one.high for one in figures)
    return {one.name: one.promise for one in figures}


def test_a_body_is_measured_as_it_stands_walks_and_moves_its_hands() -> None:
    found = measured(ROBOT, "dcm")
    assert [name.partition(":")[0] for name in found] == [
        "dcm stands",
        "dcm walks",
        "dcm walks",
        "dcm moves both hands",
    ]
    assert set(found.values()) == {None}


def test_a_learned_walker_has_promises(tmp_path: Path) -> None:
    pytest.importorskip("onnxruntime", reason="learned walkers need onnxruntime: pip install 'humanoid-bt[policy]'")
    robot, standing = load_robot(ROBOT)
    found = measured(write_standing_robot(tmp_path, robot.joint_names, standing[BASE_COORDINATES:]), "policy")
    assert list(found.values()) == [WALKER_SPEED, WALKER_SPEED, None, ARMS]


def test_a_promise_in_microseconds_is_about_what_it_took_and_not_about_the_ratio() -> None:
    quick = figure("one solve", "physics", "us CPU", [(290e-6, 1e-6)], scale=1e6, promise=ARMS)
    slow = figure("one solve", "physics", "us CPU", [(310e-6, 1.0)], scale=1e6, promise=ARMS)
    assert (quick.verdict, slow.verdict) == ("ok", "missed")


OWN = """\
from humanoid_bt.control.body.whole_body import WholeBody


class Mine(WholeBody):
    def update(self, estimate, targets, hold):
        if estimate.time > 0.21:
            raise KeyError("oops")
        return super().update(estimate, targets, hold)
"""


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """A robot with a body of the user's own, which fails as it is measured."""
    robot = Path(shutil.copytree(ROBOT.parent, tmp_path / "mine")) / "robot.yaml"
    robot.write_text(robot.read_text() + "\nbody: {own: own.py}\n")
    robot.with_name("own.py").write_text(OWN)
    return robot


def test_a_body_of_the_users_own_has_a_solve_if_it_builds_on_one_of_ours(own: Path) -> None:
    own.with_name("own.py").write_text(OWN.replace("0.21", "1e9"))
    assert speed.measure_solve(own, "own", 2)


@pytest.mark.parametrize("measure", [speed.measure_walk, speed.measure_solve])
def test_a_body_that_fails_is_not_measured(own: Path, measure: Callable[[Path, Walk, int], object]) -> None:
    message = r"robot\.yaml:\d+:\d+: error: humanoid .*: its body failed after 0\.2 s: KeyError: 'oops'"
    with pytest.raises(UserError, match=message):
        measure(own, "own", 2)
