"""Pushes that a standing robot can only withstand by stepping: all of control, on physics."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from humanoid_bt.control.body.feedforward import Feedforward
from humanoid_bt.core.messages import Array, BaseTarget, Gait, Mode, State
from humanoid_bt.robot.model import BASE_DOFS
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


def test_the_height_that_is_planned_comes_down_with_a_robot_that_a_push_makes_sink(rig: ControlRig) -> None:
    far = {"base": BaseTarget(np.array([3.0, 0.0]), 0.0)}
    assert rig.run(5.0, far, until=lambda state: state.gait is Gait.STEP and state.base_position[0] > 0.7)
    rig.plant.push("torso", np.array([0.0, 200.0, 0.0]), 0.1)
    body, above = rig.controller.body, []
    for _ in range(75):
        rig.run(0.02, far)
        above.append(body.kinematics.com_height - body.dynamics.com[2])
    assert rig.state.mode is Mode.RUN
    assert 0.02 < max(above) < 0.05  # m; 0.065 if the plan stays where it was


def test_a_robot_that_walks_lunges_only_after_a_push_that_no_step_catches(
    rig: ControlRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Toward the foot that carries it: the other one would have to land beyond that."""
    far, leans, tilts = {"base": BaseTarget(np.array([4.0, 0.0]), 0.0)}, [], []
    body, torso = rig.controller.body, rig.plant.data.body("torso")
    lunge, walker, waist = body.lunge, body.walker, BASE_DOFS + rig.robot.joint("waist_roll")
    speeds, upright, torques = [], [], Feedforward.torques

    def look() -> None:
        leans.append(lunge.lean.copy())
        tilts.append(np.arcsin(torso.xmat[5]))  # to its left, really
        speeds.append(abs(body.kinematics.velocity[waist]))

    def told(self: Feedforward, *planned: Any) -> Array:
        upright.append(planned[-1])
        return torques(self, *planned)

    def lifts_left(_: State) -> bool:
        return walker.swing is not None and walker.swing.side == "left" and walker.swing.progress < 0.1

    monkeypatch.setattr(Feedforward, "torques", told)
    rig.run(2.0, far, cycle=look)
    assert rig.run(2.0, far, lifts_left, look)
    assert not np.any(leans)
    rig.plant.push("torso", np.array([0.0, -200.0, 0.0]), 0.1)
    rig.run(0.6, far, cycle=look)
    assert np.min(leans, axis=0)[1] < -0.3
    assert np.min(tilts) < -0.3
    assert np.max(speeds) > 2.0  # usually 1.5 rad/s at most
    np.testing.assert_allclose(
        np.max(upright, axis=0)[0], 0.12, atol=0.01
    )  # the pelvis' share of 0.6 rad, to the right
    rig.run(3.0, far)
    assert rig.state.mode is Mode.RUN
    assert not lunge.lean.any()
    assert abs(rig.controller.body.dynamics.roll) < 0.1
