"""Every row of the safety table, at random moments of what the robot does. 100 of each: ``tests.safety.trials``."""

from __future__ import annotations

import pytest

from humanoid_bt.core.messages import Mode
from humanoid_bt.plant.sensor_failures import FAILURES
from tests.safety.activities import STANDING, WALKING
from tests.safety.rows import DAMAGES, ROWS
from tests.safety.trials import main, shared_machine, summary, trial

_STANDS, _WALKS = list(STANDING), list(WALKING)
_ALIKE = {
    *(f"a sensor of the IMU {how}" for how in FAILURES[1:]),
    *(f"the sensors of a joint {how}" for how in FAILURES[:-1]),
    *(f"commands {damage}" for damage in list(DAMAGES)[1:]),  # of which test_timing tries each one
}
"""Rows of a kind of which ``make test`` tries another one."""
CASES = [
    pytest.param(row, activity, seed, id=f"{row}, {activity}", marks=marks)
    for seed, row in enumerate(ROWS)
    for activity, marks in zip(
        (_STANDS[seed % 2], *_WALKS[seed % 6 : seed % 6 + 2 - seed % 2]),
        [() if index == seed % 2 and row not in _ALIKE else pytest.mark.trials for index in range(3)],
        strict=False,
    )
]


@pytest.mark.parametrize(("row", "activity", "seed"), CASES)
def test_a_fault_does_what_its_row_says(row: str, activity: str, seed: int) -> None:
    outcome = trial(row, activity, seed)
    assert outcome.finite
    if ROWS[row].promised:
        assert outcome.as_told, outcome
    else:  # a robot that falls then is let go
        assert outcome.mode_sequence in (ROWS[row].modes, (*ROWS[row].modes, Mode.DAMP)), outcome


@pytest.mark.parametrize(("activity", "seed"), [("turning", 1001), ("walking away from a hand's target", 1029)])
def test_a_robot_without_a_gyroscope_goes_by_the_orientation(activity: str, seed: int) -> None:
    assert trial("a sensor of the IMU frozen", activity, seed).as_told


def test_a_robot_that_walks_is_not_thrown_by_its_hand() -> None:
    """Its body was given to the hand, and came back in one period."""
    assert trial("IK without solution for 0.1 s", "walking with a hand out", 1010).as_told


@pytest.mark.parametrize("seed", [74, pytest.param(205, marks=pytest.mark.trials)])
def test_a_robot_whose_pelvis_and_trunk_give_way_is_not_thrown_when_its_hand_is_pushed(seed: int) -> None:
    """Ten times as firm, three robots of a hundred fell."""
    assert trial("a hand pushed, 60 N for 0.2 s", "walking with a hand out", seed).as_told


@pytest.mark.trials
def test_the_same_seed_gives_the_same_outcome() -> None:
    first = trial("decision stopped for 0.5 s", "walking straight", 3)
    trial("knocked over, 600 N for 0.2 s", "standing still", 0)
    assert trial("decision stopped for 0.5 s", "walking straight", 3) == first
    assert trial("decision stopped for 0.5 s", "walking straight", 4).moment != first.moment


def test_a_supervisor_that_sleeps_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shared_machine().supervisor, "_decision_timeout", 10**9)
    outcome = trial("decision killed", "walking straight", 0)
    assert outcome.mode_sequence == ()
    assert not outcome.as_told


def test_a_robot_that_falls_is_noticed() -> None:
    outcome = trial("knocked over, 600 N for 0.2 s", "standing still", 0)
    assert outcome.mode_sequence == (Mode.DAMP,)
    assert not outcome.standing
    assert outcome.limp


@pytest.mark.trials
def test_the_table_counts_what_went_as_told() -> None:
    row = ROWS["e-stop raised"]
    outcomes = [trial(row.name, "standing still", 0), trial("decision killed", "turning", 1)]
    assert summary(row, outcomes).startswith("| e-stop raised | 1 of 1 | 1 of 1 | 0.0")


def test_the_command_refuses_a_row_that_does_not_exist(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--row", "earthquake"])
    assert "e-stop raised" in capsys.readouterr().err
