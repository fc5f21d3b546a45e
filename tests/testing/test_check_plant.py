"""The conformance test of plants: the served simulation keeps every rule, and each broken one is found."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from humanoid_bt.cable import server, watchdog
from humanoid_bt.cable.cables import Cable
from humanoid_bt.cable.impairment import Impairment
from humanoid_bt.cable.lockstep import PLANT, LockstepPlant
from humanoid_bt.cable.order import Order
from humanoid_bt.cable.payloads import Description, Hello
from humanoid_bt.cable.server import Served
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.control.controller import Controller
from humanoid_bt.core.clock import DECISION_PERIOD, SERVO_PERIOD, cycles
from humanoid_bt.core.messages import BaseTarget, Command, JointCommand
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.realtime.served_simulation import ServedSimulation
from humanoid_bt.testing.check_plant import check_cabled_plant, weak_drive
from humanoid_bt.testing.conformance import Conformance
from tests.cable.cabled import LOSSY, PERFECT

WORKSPACE = Workspace(builtin_root())
ROBOT = Path(WORKSPACE.find_robot("humanoid"))


@pytest.fixture
def simulation() -> ServedSimulation:
    robot, start = load_robot(ROBOT)
    return ServedSimulation(robot, start, Scene(load_scene(WORKSPACE.find_scene("empty")), 0))


@pytest.fixture
def checked(simulation: ServedSimulation) -> Callable[..., Conformance]:
    def check(impairment: Impairment = PERFECT, key: bytes | None = None, served: Served = simulation) -> Conformance:
        robot, _ = load_robot(ROBOT)
        cabled = LockstepPlant(served, Hello("humanoid", tuple(robot.joint_names)), impairment, key=key)
        cabled.remote.close()
        ports = iter(range(1, 100))

        def cable() -> Cable:
            return cabled.network.cable(PLANT._replace(port=next(ports)))

        def wait() -> float:
            cabled.pass_time()
            return cabled.now() * 1e-9

        return check_cabled_plant(ROBOT, PLANT, cable, wait, key)

    return check


@pytest.mark.parametrize(("impairment", "key"), [(PERFECT, None), (LOSSY, b"k" * 32)])
def test_the_served_simulation_keeps_every_rule(
    checked: Callable[..., Conformance], impairment: Impairment, key: bytes | None
) -> None:
    check = checked(impairment, key)
    check.assert_passed()
    assert len(check.rules) == 11


@pytest.fixture
def documented() -> Callable[[float], Served]:
    """Make the plant of the docs' driver: how high it hangs [m] -> it."""
    page = (Path(__file__).resolve().parents[2] / "docs" / "your-robot.md").read_text(encoding="utf-8")
    source = page.partition("<!-- file: driver.py -->\n```python\n")[2].partition("```")[0]
    names: dict[str, Any] = {"__name__": "driver"}
    exec(compile(source, "driver.py", "exec"), names)
    made: Callable[[float], Served] = names["MyRobot"]
    return made


def test_the_driver_of_the_docs_keeps_every_rule(
    checked: Callable[..., Conformance], documented: Callable[[float], Served]
) -> None:
    checked(served=documented(1.0)).assert_passed()


def test_the_driver_of_the_docs_walks_run_after_run(documented: Callable[[float], Served]) -> None:
    robot, _ = load_robot(ROBOT)
    hello = Hello("humanoid", tuple(robot.joint_names))
    cabled = LockstepPlant(documented(0.0), hello, PERFECT)
    for _ in range(2):
        controller = Controller(robot, cabled)
        for _ in range(round(4.0 / DECISION_PERIOD)):
            now = controller.cycle * SERVO_PERIOD
            controller.submit(Command(controller.cycle, now, {"base": BaseTarget(np.array([0.5, 0.0]), 0.0)}))
            controller.run_cycles(cycles(DECISION_PERIOD))
        assert not controller.supervisor.stops
        assert controller.state().stance == pytest.approx((0.5, 0.0, 0.0), abs=0.05)
        cabled.restart()


def never(*_: object) -> str:
    return ""


BROKEN: dict[str, Callable[[pytest.MonkeyPatch], None]] = {
    "refuses": lambda patch: patch.setattr(Description, "mismatch", never),
    "watchdog": lambda patch: patch.setattr(watchdog.PlantWatchdog, "be_safe", never),
    "order": lambda patch: patch.setattr(Order, "fault", never),
    "lets go": lambda patch: patch.setattr(watchdog.PlantWatchdog, "lost", False),
    "malformed": lambda patch: patch.setattr(server, "unpack_command", _anything),
    "limits": lambda patch: patch.setattr(MujocoPlant, "set_strength", _strong),
}


def _anything(payload: bytes, joints: int) -> JointCommand:
    rows = np.resize(np.frombuffer(payload[: len(payload) // 8 * 8]), (5, joints))
    return JointCommand(*np.abs(np.nan_to_num(rows)))


def _strong(plant: MujocoPlant, _: np.ndarray) -> None:
    plant.model.actuator_forcerange[:] = [-1e4, 1e4]


@pytest.mark.parametrize("rule", BROKEN)
def test_a_plant_that_breaks_a_rule_is_found(
    rule: str, checked: Callable[..., Conformance], monkeypatch: pytest.MonkeyPatch
) -> None:
    BROKEN[rule](monkeypatch)
    check = checked()
    assert rule in [broken.name for broken in check.rules if not broken.passed], str(check)
    with pytest.raises(AssertionError, match=f"FAILED  {rule}"):
        check.assert_passed()


def test_where_nobody_answers_the_first_rules_say_so() -> None:
    def cable() -> Cable:
        return Nowhere()

    check = check_cabled_plant(ROBOT, PLANT, cable, lambda: 0.0)
    assert not check.passed
    assert [rule.name for rule in check.rules] == ["refuses", "welcomes"]
    assert check.rules[0].shown == f"nobody answers at {PLANT}: is the driver running there?"
    assert check.rules[1].shown == "nothing"


@pytest.mark.parametrize(
    ("limits", "drive"),
    [
        ([0.7, 25.0, 5.0, 0.7], 2),  # twice a finger's torque is no more than noise
        ([40.0, 25.0], 1),
        ([0.5, 0.9], 1),
    ],
)
def test_a_drive_is_tried_whose_torque_can_be_told_from_noise(limits: list[float], drive: int) -> None:
    assert weak_drive(np.array(limits)) == drive


class Nowhere:
    """A cable that leads nowhere."""

    def send(self, frame: bytes, to: object) -> None: ...

    def receive(self) -> list[tuple[bytes, object]]:
        return []

    def close(self) -> None: ...
