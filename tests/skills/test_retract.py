"""The skill ``retract``, alone on the simulated robot."""

import numpy as np
import pytest

from humanoid_bt import Rig


@pytest.mark.parametrize("hand", [pytest.param("left", marks=pytest.mark.trials), "both"])
def test_waits_until_the_hand_hangs_beside_the_body(rig: Rig, hand: str) -> None:
    rest = rig.state.hands["left"].copy()
    rig.run("wave", hand="left", timeout=2.5)
    assert rig.state.hands["left"][2] > 1.1
    result = rig.run("retract", hand=hand)
    assert result.succeeded, result.feedback
    assert np.linalg.norm(rig.state.hands["left"] - rest) < 0.03
    assert not any(command.targets for command in result.commands)
    assert not result.stops


def test_succeeds_soon_when_the_hands_are_there(rig: Rig) -> None:
    result = rig.run("retract")
    assert result.succeeded
    assert result.time < 0.5


def test_does_not_take_a_hand_that_is_about_to_move_for_one_at_rest(rig: Rig) -> None:
    rest = rig.state.hands["right"].copy()
    rig.run("offer", target=(1.0, -0.3, 1.2), hold=1.0)
    result = rig.run("retract", hold=0.1)
    assert result.succeeded
    assert np.linalg.norm(rig.state.hands["right"] - rest) < 0.05


def test_fails_with_the_reason_while_the_robot_is_stopped(rig: Rig) -> None:
    rig.run("wave", hand="left", timeout=1.0)
    rig.raise_estop("somebody came near")
    result = rig.run("retract", patience=1.2)  # in which they have come to rest where they are
    assert result.failed
    assert "somebody came near" in result.feedback
