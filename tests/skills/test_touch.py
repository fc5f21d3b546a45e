"""The skill ``touch``, alone on the simulated robot, at a wall and a table that are there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

import humanoid_bt as hbt
from humanoid_bt import Rig
from humanoid_bt.core.messages import Command, HandTarget
from humanoid_bt.plant.mujoco_plant import MujocoPlant

SCENE = """\
format: 1
name: room
objects:
  wall: {shape: box, size: [10 cm, 2 m, 1 m], position: [0.43, 0, 1.2], solid: true}
  table: {shape: box, size: [20 cm, 1 m, 4 cm], position: [0.32, 0, 0.70], solid: true}
"""
TREE = """\
format: 1
name: touching
parameters: {hand: right, direction: ahead, force: 10.0, distance: 0.25, hold: 1.0, patience: 4.0, tolerance: 2.0}
root:
  emergency_stop:
    touch:
      hand: $hand
      direction: $direction
      height: 90 cm
      distance: $distance
      force: $force
      tolerance: $tolerance
      hold: $hold
      patience: $patience
"""


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> hbt.Workspace:
    folder: Path = tmp_path_factory.mktemp("touching")
    for place, text in {"sim/scenes/room.yaml": SCENE, "trees/touching.yaml": TREE}.items():
        (folder / place).parent.mkdir(parents=True)
        (folder / place).write_text(text)
    return hbt.Workspace(folder)


@pytest.fixture(scope="module")
def stage(workspace: hbt.Workspace) -> hbt.Stage:
    """The humanoid in front of a wall, a table below its hands."""
    return hbt.Stage(workspace, "humanoid", "room")


@pytest.fixture
def pressed(stage: hbt.Stage, monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """True force of anything on wall and table, in every servo cycle [N]."""
    forces: list[float] = []
    number = np.zeros(6)
    step: Callable[..., None] = MujocoPlant.step

    def look(plant: MujocoPlant, command: object) -> None:
        step(plant, command)
        model, data, whole = plant.model, plant.data, 0.0
        for contact in range(data.ncon):
            if any(model.geom(geom).name.startswith("object_") for geom in data.contact.geom[contact]):
                mujoco.mj_contactForce(model, data, contact, number)
                whole += number[0]
        forces.append(whole)

    monkeypatch.setattr(MujocoPlant, "step", look)
    return forces


@pytest.mark.parametrize(
    ("hand", "direction", "force"),
    [
        ("right", "ahead", 10.0),
        pytest.param("left", "down", 10.0, marks=pytest.mark.trials),
        pytest.param("left", "ahead", 40.0, marks=pytest.mark.trials),
        pytest.param("left", "ahead", 20.0, marks=pytest.mark.trials),
        pytest.param("right", "ahead", 50.0, marks=pytest.mark.trials),
        pytest.param("right", "ahead", 5.0, marks=pytest.mark.trials),
    ],
)
def test_presses_as_hard_as_it_is_told(
    stage: hbt.Stage, pressed: list[float], hand: str, direction: str, force: float
) -> None:
    run = stage.run("touching", parameters={"hand": hand, "direction": direction, "force": force}, duration=20)
    assert run.outcome == "success", run.reason
    assert run.samples[-1].touched in {("wall",), ("table",)}
    assert not run.samples[-1].bumped
    (success,) = (event["time"] for event in run.report.events if event["text"] == "the tree ended: success")
    ended = round(success * 1000) - 20  # in its last tick it lets go
    assert np.abs(np.array(pressed[ended - 1000 : ended]) - force).max() < max(3.0, 0.1 * force)
    assert max(pressed[:ended]) < 60


def test_says_that_it_pushes_the_robot_off_its_feet(stage: hbt.Stage, pressed: list[float]) -> None:
    push = {"at": 3.4, "push": {"force": [-120.0, 0.0, 0.0], "duration": 0.3}}
    run = stage.run("touching", parameters={"force": 30.0}, duration=20, script=[push])
    assert run.reason == "touch: the robot has to step: it cannot press with 30 N there"
    assert max(pressed) < 60


def test_presses_for_longer_than_its_patience_though_not_always_as_hard(stage: hbt.Stage) -> None:
    values = {"force": 10.0, "tolerance": 1.2, "hold": 1.0, "patience": 1.2}
    run = stage.run("touching", parameters=values, duration=20)
    assert run.outcome == "success", run.reason


def test_touches_within_the_last_of_its_distance(stage: hbt.Stage) -> None:
    run = stage.run("touching", parameters={"hold": 0.0, "distance": 0.11}, duration=20)
    assert run.outcome == "success", run.reason


def test_takes_no_wrong_feeling_for_a_touch(workspace: hbt.Workspace) -> None:
    stage = hbt.Stage(workspace, "humanoid", "empty")
    values = {"direction": "up", "force": 5.0, "distance": 0.1}
    run = stage.run("touching", parameters=values, duration=20, conditions={"hand_payload": 2})
    assert run.reason == "touch: nothing to touch within 10 cm"


@pytest.mark.trials
def test_keeps_the_contract(tmp_path: Path) -> None:
    scene = tmp_path / "sim/scenes/empty.yaml"
    scene.parent.mkdir(parents=True)
    scene.write_text(SCENE)
    Rig(hbt.Workspace(tmp_path)).check_skill("touch", hold=0.2).assert_passed()


def test_says_that_nothing_is_there(rig: Rig) -> None:
    result = rig.run("touch", timeout=20)
    assert result.failed
    assert result.feedback == "nothing to touch within 25 cm"


def test_moves_for_a_distance_however_short(rig: Rig) -> None:
    result = rig.run("touch", distance=0.015)
    assert result.feedback == "nothing to touch within 1.5 cm"
    begins = next(i for i, command in enumerate(result.commands) if _press(command))
    begin, end = (result.states[i].hands["right"][0] for i in (begins - 1, -1))
    assert end - begin > 0.014


def _press(command: Command) -> float:
    """Return with which force the right hand is to press [N]."""
    target = command.targets.get("right_hand")
    return target.press if isinstance(target, HandTarget) else 0.0


def test_waits_for_a_steady_base(rig: Rig) -> None:
    rig.run("walk_to", x=1.0, y=0.0, timeout=0.8)
    assert rig.run("touch", timeout=0.3).feedback == "waiting for a steady base"


def test_lets_go_when_its_arm_has_to_yield(rig: Rig) -> None:
    rig.at(2.0, lambda: rig.push((-60.0, 0.0, 0.0), 0.3, "right_hand"))
    result = rig.run("touch", timeout=20)
    assert result.failed
    assert result.feedback.startswith("right arm touched something: ")
