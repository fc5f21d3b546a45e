"""The robot at the end of a cable that is bad, or is pulled while it walks. Many times: ``tests.cable.trials``."""

from __future__ import annotations

import pytest

from humanoid_bt.cable.safe_state import SafeState
from humanoid_bt.cable.watchdog import PlantWatchdog
from humanoid_bt.core.messages import Mode
from tests.cable.cabled import LOSSY
from tests.cable.trials import fetch, plugged, pull
from tests.safety.rows import SETTLE
from tests.trees.fetch_trials import fault


def test_a_ball_is_touched_over_a_cable_that_is_late_and_loses_frames() -> None:
    report, engine = fetch(23, LOSSY)  # where a gait that lands by the heel falls
    assert fault(report) == ""
    assert engine.cabled.remote.figures.round_trip > 0.002


@pytest.mark.parametrize(("safe", "activity"), [("hold", "walking straight"), ("damp", "turning")])
def test_a_pulled_cable_stops_both_sides_and_both_say_so(safe: SafeState, activity: str) -> None:
    assert pull(safe, activity, 3)[0].as_told


def test_a_cable_that_is_plugged_in_again_at_once_lets_the_robot_go_on() -> None:
    outcome, machine = pull("hold", "walking straight", 5, plugged_after=0.06)
    assert outcome.modes == (Mode.PROTECTIVE_STOP, Mode.RUN)
    assert not machine.cabled.cabled.remote.lost
    machine.release()
    assert machine.run(SETTLE, until=lambda state: state.base_settled)
    assert machine.supervisor.mode is Mode.RUN


@pytest.mark.trials
@pytest.mark.parametrize("seed", [1002, 1007, 3056, 3173])
def test_a_robot_that_walks_goes_on_after_a_silence(seed: int) -> None:
    """In some it fell with tilt and velocity as they were before, in some with the velocity of a leg that carried."""
    assert plugged(seed)


def test_a_plant_without_a_watchdog_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(PlantWatchdog, "be_safe", lambda _: None)
    outcome, _ = pull("hold", "walking straight", 3)
    assert outcome.safe is None
    assert not outcome.as_told
