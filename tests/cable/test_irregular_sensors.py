"""Sensors that come irregularly, but are never silent: they show no contact that is none, and no failure."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from humanoid_bt.cable.impairment import Impairment
from humanoid_bt.cable.lockstep import LockstepPlant
from humanoid_bt.control.controller import Controller
from humanoid_bt.control.dynamics import GRAVITY
from humanoid_bt.core.messages import BaseTarget, Command, Mode, Target
from humanoid_bt.plant.interface import SILENT_AFTER
from tests.cable.conftest import Loaded
from tests.cable.test_cable import Make, driven

IRREGULAR = Impairment(latency=0.001, jitter=0.012, loss=0.01)
WALK = {"base": BaseTarget(np.array([1.0, 0.3]), 0.5)}
TURN = {"base": BaseTarget(np.zeros(2), 2.5)}


class Cabled:
    """The built-in humanoid behind a cable, and what it feels."""

    def __init__(self, loaded: Loaded, cabled: LockstepPlant) -> None:
        self.cabled = cabled
        self.controller = Controller(loaded[0], cabled)
        self.touched: set[str] = set()
        self.failed = ""

    def run(self, count: int, targets: Mapping[str, Target]) -> None:
        controller = self.controller
        for _ in range(count):
            if controller.cycle % 20 == 0:
                controller.submit(Command(controller.cycle // 20 + 1, controller.cycle * 1e-3, dict(targets), {}))
            controller.run_cycle()
            self.touched |= set(controller.supervisor.touch.pressed)
            self.failed = self.failed or controller.estimator.watch.fault or self.cabled.fault


@pytest.mark.parametrize("targets", [WALK, TURN], ids=["walking", "turning"])
def test_a_robot_whose_sensors_come_irregularly_feels_nothing_where_nothing_touches_it(
    loaded: Loaded, plant: Make, targets: Mapping[str, Target]
) -> None:
    robot = Cabled(loaded, plant(IRREGULAR))
    robot.run(1500, targets)
    assert (robot.touched, robot.failed, robot.controller.supervisor.mode) == (set(), "", Mode.RUN)


@pytest.mark.parametrize(
    ("impairment", "force"),
    [(Impairment(), 100.0), (Impairment(0.001, 0.003, 0.01), 100.0), (IRREGULAR, 250.0)],
    ids=["regular", "3 ms", "12 ms"],
)
def test_a_robot_whose_sensors_come_irregularly_feels_a_push(
    loaded: Loaded, plant: Make, impairment: Impairment, force: float
) -> None:
    robot = Cabled(loaded, plant(impairment))
    robot.run(500, {})
    assert robot.touched == set()
    robot.cabled._plant.simulation.plant.push("torso", np.array([0.0, -force, 0.0]), 0.1)
    robot.run(150, {})
    assert "torso" in robot.touched


@pytest.mark.parametrize("paused", [False, True], ids=["frames lost", "plant paused"])
def test_a_gap_within_the_limit_of_silence_is_no_contact(
    loaded: Loaded, plant: Make, monkeypatch: pytest.MonkeyPatch, *, paused: bool
) -> None:
    robot = Cabled(loaded, plant())
    cabled, run_plant = robot.cabled, robot.cabled.server.run_cycle
    for moment in range(900, 1060, 40):
        robot.run(moment - robot.controller.cycle, WALK)
        if paused:
            monkeypatch.setattr(cabled.server, "run_cycle", lambda: None)
        else:
            cabled.cable.pulled = True
        robot.run(18, WALK)
        cabled.cable.pulled = False
        monkeypatch.setattr(cabled.server, "run_cycle", run_plant)
    robot.run(60, WALK)
    assert 0.017 < cabled.remote.figures.silence < SILENT_AFTER
    assert (robot.touched, robot.failed) == (set(), "")


def test_a_sensor_that_is_silent_is_found_although_frames_come_irregularly(loaded: Loaded, plant: Make) -> None:
    robot = Cabled(loaded, plant(IRREGULAR))
    robot.run(500, {})
    robot.cabled._plant.simulation.plant.fail_sensor("gyro", "silent")
    robot.run(60, {})
    assert robot.failed == "the gyro is silent"


def test_a_sensor_that_fell_silent_in_a_gap_is_found_after_it(loaded: Loaded, plant: Make) -> None:
    robot = Cabled(loaded, plant(Impairment(0.001)))
    robot.run(200, {})
    robot.cabled._plant.simulation.plant.fail_sensor("left_wrist_roll", "silent")
    robot.cabled.cable.pulled = True
    robot.run(14, {})
    robot.cabled.cable.pulled = False
    robot.run(40, {})
    supervisor = robot.controller.supervisor
    assert supervisor.mode is Mode.PROTECTIVE_STOP
    assert supervisor.reason == "a sensor failed: the sensors of left_wrist_roll are silent"


def test_a_simulation_whose_time_begins_with_a_late_command_has_no_frozen_sensors(loaded: Loaded, plant: Make) -> None:
    robot = Cabled(loaded, plant(Impairment(latency=0.018)))
    robot.run(100, {})
    assert (robot.touched, robot.failed) == (set(), "")


def test_feet_carry_the_weight_of_a_robot_whose_sensors_come_irregularly(loaded: Loaded, plant: Make) -> None:
    robot = Cabled(loaded, plant(IRREGULAR))
    robot.run(300, {})
    load, forces = robot.controller.estimator.load, []
    for _ in range(80):
        robot.run(5, {})
        forces.append(load.force.sum())
        assert load.standing == [True, True]
    assert np.mean(forces) == pytest.approx(loaded[0].mass * GRAVITY, rel=0.05)


def test_a_reading_says_of_how_much_time_it_tells(plant: Make) -> None:
    cabled = plant()
    told = []
    for pulled in (False, True, True, False, False):
        cabled.cable.pulled = pulled
        driven(cabled, 1)
        told.append(cabled.measure().passed)
        assert cabled.measure().passed == 0
    assert told == [1, 0, 0, 3, 1]
