from __future__ import annotations

import os
import random
from collections.abc import Callable

import numpy as np
import pytest

from humanoid_bt.cable import payloads
from humanoid_bt.cable.frames import Frame, FrameKind, SealError, pack, unpack
from humanoid_bt.cable.lockstep import DRIVER, PLANT, LockstepPlant
from humanoid_bt.cable.order import Order
from humanoid_bt.cable.payloads import Description, Hello, PlantState, Sensors, Simulated
from humanoid_bt.core.messages import JointCommand, Truth
from humanoid_bt.link.wire import WireError
from humanoid_bt.plant.touches import Touch
from tests.cable.cabled import still

KEY, OTHER = b"k" * 32, b"o" * 32
FRAME = Frame(FrameKind.COMMAND, 2**63 + 1, 17, 0.017, b"payload")
FUZZ = int(os.environ.get("HUMANOID_BT_FRAMES", "3000"))
"""Frames of the fuzz test; 100 000 take a minute."""


@pytest.mark.parametrize("key", [None, KEY])
def test_a_frame_comes_back_as_it_was(key: bytes | None) -> None:
    assert unpack(pack(FRAME, key), key) == FRAME


@pytest.mark.parametrize("key", [None, KEY])
def test_no_bit_of_a_frame_can_change(key: bytes | None) -> None:
    data = pack(FRAME, key)
    for bit in range(8 * len(data)):
        changed = bytearray(data)
        changed[bit // 8] ^= 1 << bit % 8
        with pytest.raises(WireError):
            unpack(bytes(changed), key)


@pytest.mark.parametrize(("sealed", "read"), [(None, KEY), (KEY, None), (OTHER, KEY)])
def test_a_frame_with_another_seal_is_told_apart_from_a_damaged_one(sealed: bytes | None, read: bytes | None) -> None:
    with pytest.raises(SealError):
        unpack(pack(FRAME, sealed), read)


def test_another_version_is_named() -> None:
    data = bytearray(pack(FRAME))
    data[2] = 9
    with pytest.raises(WireError, match="a frame of version 9, where 1 is understood"):
        unpack(bytes(data))


def test_payloads_come_back_as_they_were() -> None:
    hello = Hello("größe", ("left_hip", "right_hip"), "empty", 7, "0a1b")
    plant = Description("größe", ("left_hip", "right_hip"), True, "damp", 0.02, 0.001)
    rows = np.random.default_rng(0).random((5, 2))
    command = payloads.unpack_command(payloads.pack_command(JointCommand(*rows)), 2)
    truth = Truth(1.0, *np.split(np.arange(13.0), [3, 7, 10]), np.arange(2.0))
    assert payloads.unpack_hello(payloads.pack_hello(hello)) == hello
    assert payloads.unpack_welcome(payloads.pack_welcome(5, plant)) == (5, plant)
    assert payloads.unpack_refusal(payloads.pack_refusal(5, "besetzt ü")) == (5, "besetzt ü")
    assert np.array_equal((command.position, command.torque), rows[[0, 4]])
    sensors = payloads.unpack_sensors(payloads.pack_sensors(Sensors(3, 0.002, PlantState.HOLDS, np.arange(18.0))), 2)
    assert sensors[:3] == (3, 0.002, PlantState.HOLDS)
    assert np.array_equal(sensors.values, np.arange(18.0))
    touches = [Touch(0.5, "größter_ball", "left_hand", True), Touch(0.7, "post", "right_shin", False)]
    back = payloads.unpack_simulated(payloads.pack_simulated(Simulated(truth, 12.5, touches)))
    assert (back.force, back.touches) == (12.5, touches)
    assert np.array_equal(back.truth.gaze_direction, truth.gaze_direction)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda rows: rows[:, :-1], "a command of 120 bytes where 4 joints take 160"),
        (lambda rows: rows * np.nan, "not finite"),
        (lambda rows: rows * [[1], [1], [-1], [1], [1]], "negative stiffness"),
    ],
)
def test_a_command_that_nobody_can_follow_is_none(change: Callable[[np.ndarray], np.ndarray], why: str) -> None:
    payload = payloads.pack_command(JointCommand(*change(np.ones((5, 4)))))
    with pytest.raises(WireError, match=why):
        payloads.unpack_command(payload, 4)


def test_what_is_old_comes_twice_or_jumps_does_not_count() -> None:
    order = Order()
    assert [order.fault(*frame) for frame in [(5, 0.005), (6, 0.006), (9, 0.009)]] == ["", "", ""]
    assert order.lost == 2
    assert order.fault(9, 0.009) == "out of order: 9 after 9"
    assert order.fault(8, 0.008) == "out of order: 8 after 9"
    assert (order.late, order.lost) == (2, 1)
    assert order.fault(10, 7.01) == "its clock jumped by 7 s in 1 ms"
    assert order.fault(10, -3.0).startswith("its clock jumped by -3.01 s")
    assert order.fault(2**40, 0.010).startswith("its count jumped")
    assert order.fault(10, 0.010) == ""


def test_no_frame_however_broken_disturbs_either_end(plant: Callable[..., LockstepPlant]) -> None:
    """Damaged, cut, repeated and made-up frames come from the driver, the plant and strangers, in every cycle."""
    cabled, rng = plant(), random.Random(3)
    network = cabled.network
    ends = [(PLANT, network.cable(FUZZER)), (DRIVER, network.cable(OTHER_FUZZER))]
    ends += [(PLANT, network.end(DRIVER)), (DRIVER, network.end(PLANT))]
    good = pack(Frame(FrameKind.SENSORS, cabled.remote.session, 3, 0.003, bytes(800)))
    for _ in range(FUZZ // 10):
        for to, end in ends:
            for _ in range(3 if to == PLANT else 2):
                end.send(_broken(rng, cabled.remote.session, good), to)
        cabled.step(still(cabled))
        assert cabled.fault == ""
    assert cabled.server.state is PlantState.FOLLOWS
    assert cabled.remote.figures.lost == 0
    assert cabled.remote.figures.came >= FUZZ // 10
    assert len(cabled.told) <= 6 * (1 + FUZZ // 10_000)  # a flood of frames is no flood of messages


FUZZER, OTHER_FUZZER = PLANT._replace(port=9), PLANT._replace(port=10)
KINDS = [kind for kind in FrameKind if kind not in (FrameKind.REFUSED, FrameKind.BYE)]


def _broken(rng: random.Random, session: int, good: bytes) -> bytes:
    """Return bytes that are no frame, or one of the session that means nothing, or nothing any more."""
    match rng.randrange(4):
        case 0:
            return rng.randbytes(rng.randrange(200))
        case 1:
            numbers = rng.getrandbits(64), rng.getrandbits(64), rng.gauss(0, 100)
            return pack(Frame(rng.choice(KINDS), *numbers, rng.randbytes(50)))
        case 2:
            sequence, stamp = rng.randrange(1000), rng.random()
            return pack(Frame(rng.choice(KINDS), session, sequence, stamp, rng.randbytes(rng.randrange(700))))
    data = bytearray(good)
    for _ in range(rng.randrange(1, 4)):
        data[rng.randrange(len(data))] ^= rng.randrange(1, 256)
    return bytes(data[: rng.randrange(len(data) + 1)])
