"""Pushes that a standing robot can only withstand by stepping: all of control, on physics."""

from __future__ import annotations

import numpy as np
import pytest

from humanoid_bt.core.messages import Gait, Mode, State
from tests.control.control_rig import ControlRig


@pytest.mark.parametrize("degrees", [0, *(pytest.param(degrees, marks=pytest.mark.trials) for degrees in (60, 180))])
def test_a_robot_that_is_pushed_hard_steps_and_stands_again(rig: ControlRig, degrees: float) -> None:
    side = np.radians(degrees)
    rig.run(1.0, {})
    rig.plant.push("torso", 200 * np.array([np.cos(side), np.sin(side), 0.0]), 0.1)
    gaits: list[Gait] = []

    def settled(state: State) -> bool:
        gaits.append(state.gait)
        return Gait.STEP in gaits and state.base_settled

    assert rig.run(5.0, {}, until=settled)
    assert rig.state.mode is Mode.RUN
    assert rig.plant.truth().base_position[2] > 0.9 * rig.standing[2]
    assert np.abs(rig.state.stance[:2]).max() > 0.05
