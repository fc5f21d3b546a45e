"""Trials whose tree succeeds, and that are failures all the same: the robot bumped into something on the way."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from humanoid_bt.campaign.result import Result
from humanoid_bt.campaign.stage_trials import Setup, make
from humanoid_bt.campaign.store import read_results
from humanoid_bt.campaign.trial import Task, Trial
from humanoid_bt.cli import main

BACK = """
format: 1
name: back
root:
  emergency_stop:
    force_success:
      timeout: {duration: 2.5 s, step_back: {distance: 32 cm}}
"""
WALL = """
format: 1
name: room
objects:
  wall: {shape: box, size: [0.1, 2, 1], solid: true, position: [-0.45, 0, 0.5]}
"""


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    """A tree that succeeds although the robot has backed into a wall."""
    for place, text in {"trees/back.yaml": BACK, "sim/scenes/room.yaml": WALL}.items():
        (tmp_path / place).parent.mkdir(parents=True)
        (tmp_path / place).write_text(text)
    return tmp_path


def result(workspace: Path, *fail_on: str) -> Result:
    trial = Trial(0, "back", "humanoid", "room", 0)
    return make(Setup(str(workspace), fail_on=fail_on))(Task(trial))[0]


def test_what_it_bumped_into_counts_as_it_is_asked_for(workspace: Path) -> None:
    failed = result(workspace, "fell", "bumped")
    assert (failed.outcome, failed.bumped, failed.fell) == ("bumped", "wall", False)
    assert failed.reason.startswith("the tree succeeded, but ")
    assert " touches wall at " in failed.reason


@pytest.mark.trials
@pytest.mark.parametrize("fail_on", [(), ("fell", "stopped")])
def test_it_is_told_all_the_same_where_that_is_no_failure(workspace: Path, fail_on: tuple[str, ...]) -> None:
    told = result(workspace, *fail_on)
    assert (told.outcome, told.bumped, told.fell) == ("success", "wall", False)


@pytest.mark.trials
def test_a_campaign_fails_on_it(workspace: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = ["campaign", "back", "--scene", "room", "--seeds", "0", "--workspace", str(workspace), "--quiet"]
    out = workspace / "out"
    assert main([*line, "--fail-on", "bumped", "--require", "bumped == 0", "--out", str(out)]) == 1
    assert "not met: bumped == 0: bumped is 1" in capsys.readouterr().err
    assert read_results(out).rows[0].result.outcome == "bumped"
    assert main(["campaign", "rerun", str(out), "0", "--workspace", str(workspace)]) == 1
    assert "as it was, bit for bit" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("what", "told"), [(["touch"], "--fail-on: .*'touch'.*\n.*bumped"), (["bumped", "--dry"], "'bumped' needs a body")]
)
def test_what_cannot_be_counted_is_refused(
    workspace: Path, capsys: pytest.CaptureFixture[str], what: list[str], told: str
) -> None:
    line = ["campaign", "back", "--scene", "room", "--workspace", str(workspace), "--fail-on", *what]
    assert main([*line, "--out", str(workspace / "out")]) == 2
    assert re.search(told, capsys.readouterr().err)
