"""Both ends of a cable on simulated time: who drives, what is followed, what is told, and the watchdog."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from humanoid_bt.cable.frames import Frame, FrameKind, pack
from humanoid_bt.cable.impairment import Impairment
from humanoid_bt.cable.lockstep import DRIVER, PLANT, LockstepPlant
from humanoid_bt.cable.payloads import Description, Hello, PlantState, pack_simulated
from humanoid_bt.cable.remote_plant import CableFigures, RemotePlant
from humanoid_bt.control.controller import Controller
from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import BaseTarget, Command, HandTarget, JointCommand
from humanoid_bt.link.wire import encode_command
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.touches import Touch
from humanoid_bt.realtime.served_simulation import ServedSimulation
from tests.cable.cabled import LOSSY, still
from tests.cable.conftest import Loaded
from tests.cable.real_robot import RealRobot

Make = Callable[..., LockstepPlant]
STRANGER = PLANT._replace(port=2)


def driven(cabled: LockstepPlant, count: int) -> None:
    for _ in range(count):
        cabled.step(still(cabled))


def another(cabled: LockstepPlant, hello: Hello, key: bytes | None = None) -> RemotePlant:
    return RemotePlant(cabled.network.cable(STRANGER), PLANT, hello, key, cabled.now)


def texts(cabled: LockstepPlant) -> str:
    return "\n".join(text for _, text in cabled.told)


def test_a_perfect_cable_changes_nothing_bit_for_bit(loaded: Loaded, plant: Make) -> None:
    robot, start, scene = loaded
    local = MujocoPlant(robot, scene)
    local.place(start)
    states = []
    for driven_plant in (local, plant()):
        controller = Controller(robot, driven_plant)
        for cycle in range(400):
            if cycle % 20 == 0:
                target = BaseTarget(np.array([1.0, 0.0]), 0.0)
                controller.submit(Command(cycle // 20 + 1, cycle * 1e-3, {"base": target}))
            controller.run_cycle()
        states.append(controller.state())
    assert np.array_equal(states[0].joint_positions, states[1].joint_positions)
    assert np.array_equal(states[0].setpoint_positions, states[1].setpoint_positions)


def test_a_cable_tells_how_late_and_how_bad_it_is(plant: Make) -> None:
    cabled = plant(Impairment(latency=0.003, jitter=0.003, loss=0.05))
    driven(cabled, 2000)
    figures = cabled.remote.figures
    assert 0.006 <= figures.round_trip <= 0.012
    assert cabled.measure().age >= 0.003
    assert 0.02 < figures.lost / 2000 < 0.08
    assert figures.late > 0
    assert str(figures).startswith("round trip ")


def test_frames_that_come_too_late_are_told_beside_those_that_are_lost() -> None:
    figures = CableFigures(round_trip=0.0076, longest=0.017, silence=0.01, came=690, lost=10, late=300)
    assert "; 1.0% of 1000 frames lost, 30.0% too late; longest silence 10 ms" in str(figures)


def test_the_truth_of_a_simulation_comes_in_the_engines_time(plant: Make) -> None:
    cabled = plant(LOSSY)
    for _ in range(100):
        cabled.pass_time()  # a plant whose own clock has run before
    driven(cabled, 202)
    cabled.measure()
    truth = cabled.remote.take_truth()
    assert truth is not None
    assert 0.17 < truth.time < 0.202
    assert truth.base_position[2] > 0.5
    assert cabled.remote.take_truth() is None


def test_what_a_simulated_robot_touches_comes_although_frames_are_lost(loaded: Loaded, hello: Hello) -> None:
    served = ServedSimulation(*loaded)
    cabled = LockstepPlant(served, hello, Impairment(latency=0.004, loss=0.4))
    driven(cabled, 500)
    touches = served.simulation.plant.touches.all
    touches.append(Touch(served.simulation.plant.time, "ball", "left_hand", True))
    driven(cabled, 200)
    touches.append(Touch(served.simulation.plant.time, "post", "right_shin", False))
    driven(cabled, 200)
    cabled.measure()
    first, second = cabled.remote.touches
    assert (first.thing, first.link, first.meant) == ("ball", "left_hand", True)
    assert (second.thing, second.link, second.meant) == ("post", "right_shin", False)
    assert (first.time, second.time) == (pytest.approx(0.5, abs=0.01), pytest.approx(0.7, abs=0.01))


def test_a_simulated_plant_knows_what_the_robot_is_sent_to_touch(loaded: Loaded, hello: Hello) -> None:
    served = ServedSimulation(*loaded)
    cabled = LockstepPlant(served, hello)
    driven(cabled, 50)
    cabled.remote.surround({"left_hand": HandTarget(np.array([0.3, 0.2, 0.9]), press=5.0)})
    driven(cabled, 21)
    assert served.simulation.plant.touches.targets["left_hand"].press == 5.0
    cabled.remote.surround({})
    driven(cabled, 21)
    assert served.simulation.plant.touches.targets == {}


def test_what_comes_after_something_newer_counts_no_more(loaded: Loaded, hello: Hello) -> None:
    served = ServedSimulation(*loaded)
    cabled = LockstepPlant(served, hello)
    driven(cabled, 50)
    remote, driver, far = cabled.remote, cabled.network.end(DRIVER), cabled.network.end(PLANT)
    remote.surround({"left_hand": HandTarget(np.array([0.3, 0.2, 0.9]), press=5.0)})
    driven(cabled, 1)
    old = Command(49, 0.049, {})
    driver.send(pack(Frame(FrameKind.TARGETS, remote.session, 49, 0.049, encode_command(old))), PLANT)
    driven(cabled, 21)
    assert served.simulation.plant.touches.targets["left_hand"].press == 5.0

    cabled.measure()
    truth, known = remote.take_truth(), served.truth()
    assert truth is not None
    far.send(pack(Frame(FrameKind.TRUTH, remote.session, 2, 0.002, pack_simulated(known))), DRIVER)
    cabled.measure()
    assert remote.take_truth() is None


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"robot": "g1"}, "this plant is the robot 'humanoid', not 'g1'"),
        ({"joints": ("a", "b")}, r"'humanoid' has \d+ joints here, not 2"),
        ({"scene": "moon"}, "this plant stands in the scene 'empty', not 'moon'"),
        ({"digest": "1"}, "the scene 'empty' of this plant is not that of the run: its file says something else"),
    ],
)
def test_a_driver_for_something_else_is_refused_and_both_sides_say_so(
    plant: Make, hello: Hello, change: dict[str, object], why: str
) -> None:
    cabled = plant()
    cabled.remote.close()
    cabled.pass_time()
    stranger = another(cabled, replace(hello, **change))
    with pytest.raises(UserError, match=why):
        stranger.connect(cabled.pass_time)
    assert f"{STRANGER} is refused: " in texts(cabled)


def test_a_joint_with_another_name_is_named(plant: Make, hello: Hello) -> None:
    joints = ("waist_yo", *hello.joints[1:])
    with pytest.raises(UserError, match=f"joint 0 of 'humanoid' is '{hello.joints[0]}' here, not 'waist_yo'"):
        plant(says=replace(hello, joints=joints))


def test_a_second_driver_is_refused_and_the_first_goes_on(plant: Make, hello: Hello) -> None:
    cabled = plant()
    driven(cabled, 100)
    with pytest.raises(UserError, match=r"udp://127.0.0.1:4748 drives this plant since 0 s"):
        another(cabled, hello).connect(cabled.pass_time)
    assert "udp://127.0.0.1:2 is refused: udp://127.0.0.1:4748 drives the plant" in texts(cabled)
    cabled.step(still(cabled))
    cabled.measure()
    assert cabled.fault == ""


def test_commands_of_a_stranger_are_not_followed(plant: Make) -> None:
    cabled = plant()
    driven(cabled, 10)
    stranger = cabled.network.cable(STRANGER)
    limp = bytes(5 * 8 * len(still(cabled).position))
    for session in (cabled.remote.session, 1):
        stranger.send(pack(Frame(FrameKind.COMMAND, session, 12, 0.012, limp)), PLANT)
    driven(cabled, 1)
    assert "commands from udp://127.0.0.1:2 are not heard: it has no session" in texts(cabled)
    assert stranger.receive()
    assert cabled.server.state is PlantState.FOLLOWS


def test_nobody_answers_where_there_is_no_plant(plant: Make, hello: Hello) -> None:
    cabled = plant()
    nowhere = RemotePlant(cabled.network.cable(STRANGER), PLANT._replace(port=3), hello, None, cabled.now)
    with pytest.raises(UserError, match=r"no plant answers at udp://127\.0\.0\.1:3"):
        nowhere.connect(cabled.pass_time)


@pytest.mark.parametrize(
    ("plants", "drivers", "why"),
    [
        (b"k" * 32, None, "it takes only frames sealed with its key"),
        (b"k" * 32, b"o" * 32, "it takes only frames sealed with its key"),
        (None, b"o" * 32, "it takes only frames without a key"),
    ],
)
def test_a_driver_without_the_key_learns_why(
    plant: Make, hello: Hello, plants: bytes | None, drivers: bytes | None, why: str
) -> None:
    cabled = plant(key=plants)
    with pytest.raises(UserError, match=why):
        another(cabled, hello, drivers).connect(cabled.pass_time)
    assert "a frame from udp://127.0.0.1:2 is refused" in texts(cabled)


def test_who_has_the_key_drives(plant: Make) -> None:
    cabled = plant(LOSSY, key=b"k" * 32)
    driven(cabled, 100)
    assert cabled.fault == ""
    assert cabled.server.state is PlantState.FOLLOWS


@pytest.mark.parametrize(("safe", "state"), [("hold", PlantState.HOLDS), ("damp", PlantState.DAMPS)])
def test_a_pulled_cable_brings_the_plant_to_its_safe_state_and_both_sides_say_so(
    plant: Make, safe: str, state: PlantState
) -> None:
    cabled = plant(safe=safe)
    driven(cabled, 50)
    cabled.cable.pulled = True
    driven(cabled, 19)
    assert cabled.server.state is PlantState.FOLLOWS
    driven(cabled, 1)
    assert cabled.server.state is state
    driven(cabled, 1)
    cabled.measure()
    assert cabled.server.state is state
    assert cabled.fault == "the plant is silent for more than 20 ms"
    assert ("error", "no command for 20 ms") in [(level, text.partition(":")[0]) for level, text in cabled.told]
    driven(cabled, 150)
    assert cabled.remote.lost
    assert "udp://127.0.0.1:4748 was silent for 100 ms: the plant" in texts(cabled)
    assert cabled.server.driver is None


def test_what_is_too_old_as_it_comes_is_a_fault_and_after_a_while_the_end(plant: Make) -> None:
    cabled = plant()
    driven(cabled, 50)
    cabled.cable._impairment = Impairment(latency=0.025)
    driven(cabled, 150)
    assert cabled.fault == "what the plant says is more than 20 ms old"
    assert not cabled.remote.lost
    driven(cabled, 150)
    assert cabled.remote.lost
    assert "is 25 ms away" in cabled.fault
    assert cabled.remote.figures.silence < 0.1  # it was heard all the time


def test_a_driver_that_is_not_heard_is_told_by_the_plant(plant: Make) -> None:
    cabled = plant()
    driven(cabled, 50)
    for _ in range(30):
        cabled.pass_time()  # its commands do not arrive, and it hears the plant
    cabled.measure()
    assert cabled.fault == "the plant hears no commands, and holds its last position"
    driven(cabled, 2)
    assert cabled.server.state is PlantState.FOLLOWS
    assert cabled.fault == ""
    assert ("warning", "plant: commands come again: the plant follows") in cabled.remote.take_news()


def test_a_driver_that_comes_back_too_late_is_a_driver_no_more(plant: Make) -> None:
    cabled = plant()
    driven(cabled, 50)
    for _ in range(110):
        cabled.pass_time()
    driven(cabled, 2)
    assert cabled.server.state is PlantState.HOLDS
    assert cabled.remote.lost
    assert "the plant has let go: this driver was silent for 100 ms" in cabled.fault


def test_after_a_driver_another_one_begins_anew(plant: Make, hello: Hello) -> None:
    cabled = plant()
    driven(cabled, 50)
    cabled.remote.close()
    cabled.pass_time()
    assert cabled.server.state is PlantState.HOLDS
    assert cabled.server.driver is None
    second = another(cabled, hello)
    second.connect(cabled.pass_time)
    assert cabled.server.driver == STRANGER
    assert cabled.server.state is PlantState.WAITS


def test_what_a_real_robot_did_before_is_no_fault_of_a_new_driver(loaded: Loaded, hello: Hello) -> None:
    """It holds as the last driver has left it, until the first command of the new one comes."""
    cabled = LockstepPlant(RealRobot(*loaded), hello)
    driven(cabled, 50)
    cabled.remote.close()
    for _ in range(500):
        cabled.pass_time()
    second = another(cabled, hello)
    second.connect(cabled.pass_time)
    second.measure()
    assert (cabled.server.state, second.fault) == (PlantState.HOLDS, "")
    for _ in range(150):
        second.step(still(cabled))
        cabled.pass_time()
        second.measure()
    assert (cabled.server.state, second.fault) == (PlantState.FOLLOWS, "")
    assert second.take_truth() is None
    assert not second.take_news()


def test_a_plant_that_ends_leaves_its_drives_in_the_safe_state(
    loaded: Loaded, hello: Hello, monkeypatch: pytest.MonkeyPatch
) -> None:
    served, given = RealRobot(*loaded, safe="damp"), list[JointCommand]()
    cabled = LockstepPlant(served, hello)
    driven(cabled, 50)
    monkeypatch.setattr(served, "step", given.append)
    cabled.server.close()
    cabled.measure()
    assert cabled.fault == "the plant ends"
    assert not given[-1].stiffness.any()


def test_a_plant_that_takes_any_driver_is_refused_by_one_that_it_does_not_fit(loaded: Loaded, hello: Hello) -> None:
    served = ServedSimulation(*loaded)
    served.description = Careless(**{**vars(served.description), "period": 0.002})
    with pytest.raises(UserError, match="does not fit: this plant has a servo period of 2 ms, and control of 1 ms"):
        LockstepPlant(served, hello)


class Careless(Description):
    """Takes everybody, on the plant's side; the driver makes up its own of what it is told."""

    def mismatch(self, hello: Hello) -> str:
        return ""


def test_a_driver_that_only_says_hello_does_not_keep_the_plant(plant: Make) -> None:
    cabled = plant()
    for _ in range(10_002):
        cabled.pass_time()
    assert cabled.server.driver is None
    assert "sent no command within 10 s" in texts(cabled)


def test_a_clock_that_jumps_ends_in_the_safe_state(plant: Make) -> None:
    cabled = plant()
    driven(cabled, 50)
    cabled.remote._sequence += 9000
    driven(cabled, 25)
    assert cabled.server.state is PlantState.HOLDS
    assert "a command is refused: its count jumped from 50 to 9051" in texts(cabled)
