from __future__ import annotations

import math
import random
import struct
from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest

from humanoid_bt.core.errors import HumanoidBtError
from humanoid_bt.core.messages import (
    ArmTarget,
    BaseTarget,
    Command,
    Contact,
    FootPose,
    Gait,
    GazeTarget,
    HandTarget,
    Mode,
    Pause,
    Percept,
    Pointing,
    PostureTarget,
    State,
    Target,
    Truth,
)
from humanoid_bt.link import wire
from humanoid_bt.link.wire import Event, MessageKind, WireError

MUTATIONS = 2000

TARGETS: dict[str, Target] = {
    "gaze": GazeTarget(np.array([1.0, -2.0, 3.0])),
    "base": BaseTarget(np.array([0.1, -0.0]), math.pi),
    "left_hand": HandTarget(np.array([math.nan, math.inf, 5e-324])),
    "posture": PostureTarget(-0.05),
    "right_hand": HandTarget(np.array([1.0, -0.0, 3.0]), press=12.5),
}
MANNERS: dict[str, Target] = {
    "left_hand": HandTarget(np.array([0.1, 0.2, math.nan]), np.array([0.5, -0.5, math.inf, -0.0]), speed=0.1),
    "right_hand": HandTarget(np.array([0.0, -0.0, 0.3]), Pointing(np.array([0.0, 0.0, -1.0]), "facing"), relative=True),
}
ARMS: dict[str, Target] = {
    "left_hand": ArmTarget({"linker_ellbogen_ü": -1.2, "left_wrist_yaw": math.nan}, speed=0.4),
    "right_hand": ArmTarget({}),
}
SOURCES = {"gaze": "fetch/look", "base": "fetch/größe/approach", "posture": ""}
COMMAND = Command(12, 0.24, TARGETS, SOURCES)
PERCEPTS = [
    Percept("target", 1.0, np.array([0.1, 0.2, 0.3]), 0.9),
    Percept("tür ✓", 1.1, np.array([-0.0, math.nan, 1e308]), 0.0),
    Percept("table", 1.1, np.array([1.0, 0.2, -0.3]), 0.8, np.array([0.6, 1 / 3, 0.7]), -0.4),
    Percept(
        "cup",
        1.2,
        np.array([1.0, 0.2, -0.3]),
        0.8,
        orientation=np.array([0.5, -0.5, 0.5, 1 / 3]),
        class_name="täßchen",
        covariance=np.arange(9.0).reshape(3, 3) / 7,
    ),
]
EVENT = Event(1.5, "warning", "the robot fell ✗")
_FOOT = FootPose(0.1, 0.2, 0.3, 0.4)


def make_state(joints: int = 31) -> State:
    numbers = np.random.default_rng(1)

    def array(size: int) -> Any:
        values = numbers.normal(size=size)
        values[:1] = struct.unpack("<d", b"\1\2\3\4\5\0\xf8\x7f")  # a NaN that carries something
        return values

    return State(
        time=12.345,
        cycle=12345,
        joint_positions=array(joints),
        joint_velocities=array(joints),
        joint_torques=array(joints),
        setpoint_positions=array(joints),
        setpoint_velocities=array(joints),
        base_position=array(3),
        base_quaternion=array(4),
        base_linear_velocity=array(3),
        base_angular_velocity=array(3),
        base_covariance=np.add.outer(spread := array(9), spread),
        com=array(3),
        com_velocity=array(3),
        hands={"left": array(3), "right": array(3)},
        feet={"left": _FOOT, "right": replace(_FOOT, x=-0.0)},
        stance=array(3),
        gaze_position=array(3),
        gaze_direction=array(3),
        foot_force={"left": 100.0, "right": math.inf},
        gait=Gait.STEP,
        footsteps=(("left", _FOOT), ("right", replace(_FOOT, yaw=-1.0))),
        base_settled=False,
        mode=Mode.PROTECTIVE_STOP,
        stop_reason="decision silent",
        stop_source="supervisor",
        command_sequence=77,
        command_sources=SOURCES,
        targets=TARGETS,
        hand_errors={"right": 0.02},
        hand_orientations={"left": array(4)},
        hand_turn_errors={"left": 0.5},
        hand_obstacles={"right": "linker_unterarm_ü"},
        limit_flags=("left_knee", "schulter_ü"),
        contacts={
            "torso": Contact(np.array([1.0, -2.0, math.inf]), 43.0),
            "left_arm": Contact(np.array([0.0, -0.0, 30.0]), 31.5, yields=True),
        },
    )


STATE = make_state()
BARE_STATE = replace(
    make_state(0), hands={}, feet={}, foot_force={}, footsteps=(), command_sources={}, targets={}, hand_errors={},
    contacts={}, hand_obstacles={}, hand_orientations={}, hand_turn_errors={}, limit_flags=(), stop_reason="",
    stop_source="", command_sequence=-1, base_settled=True,
)  # fmt: skip


def plain(value: Any) -> Any:
    """Return something that compares equal exactly if every bit is equal."""
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, float):
        return struct.pack("<d", value)
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (tuple, list)):
        return [plain(item) for item in value]
    if hasattr(value, "__dataclass_fields__"):
        return type(value), {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    return type(value), value


TRUTH = Truth(0.3, np.arange(3.0), np.arange(4.0) / 7, np.arange(3.0) / 3, np.ones(3), np.arange(31.0) / 11)
CASES: list[tuple[Callable[[Any], bytes], Callable[[Any], Any], Any]] = [
    (wire.encode_state, wire.decode_state, STATE),
    (wire.encode_state, wire.decode_state, BARE_STATE),
    (wire.encode_command, wire.decode_command, COMMAND),
    (wire.encode_command, wire.decode_command, Command(13, 0.26, MANNERS, SOURCES)),
    (wire.encode_command, wire.decode_command, Command(14, 0.28, ARMS, SOURCES)),
    (wire.encode_command, wire.decode_command, Command(0, 0.0)),
    (wire.encode_command, wire.decode_command, Command(3, 0.06, pause=Pause("break at fetch/reach", "Größe"))),
    (wire.encode_percepts, wire.decode_percepts, wire.Sight(PERCEPTS, {"cup": "hidden", "Ø": ""})),
    (wire.encode_percepts, wire.decode_percepts, wire.Sight([], {})),
    (wire.encode_event, wire.decode_event, EVENT),
    (wire.encode_truth, wire.decode_truth, TRUTH),
]
NAMES = [
    "state",
    "bare state",
    "command",
    "manners",
    "arms",
    "empty command",
    "pause",
    "percepts",
    "no percepts",
    "event",
    "truth",
]
each_message = pytest.mark.parametrize(("encode", "decode", "message"), CASES, ids=NAMES)


@each_message
def test_a_message_comes_back_bit_for_bit(
    encode: Callable[[Any], bytes], decode: Callable[[Any], Any], message: Any
) -> None:
    data = encode(message)
    assert plain(decode(data)) == plain(message)
    assert plain(decode(memoryview(b"x" + data)[1:])) == plain(message)
    assert encode(decode(data)) == data


@each_message
def test_a_cut_or_longer_message_is_malformed(
    encode: Callable[[Any], bytes], decode: Callable[[Any], Any], message: Any
) -> None:
    data = encode(message)
    for length in range(len(data)):
        with pytest.raises(WireError):
            decode(data[:length])
    with pytest.raises(WireError):
        decode(data + b"\0")


@each_message
def test_whatever_the_bytes_are_decoding_answers_with_one_error(
    encode: Callable[[Any], bytes], decode: Callable[[Any], Any], message: Any
) -> None:
    chance, data = random.Random(2), encode(message)
    for _ in range(MUTATIONS):
        mutant = bytearray(data)
        for _ in range(chance.choice((1, 1, 2, 8))):
            match chance.randrange(4):
                case 0:
                    mutant[chance.randrange(len(mutant))] = chance.randrange(256)
                case 1:
                    mutant[chance.randrange(min(64, len(mutant)))] ^= 1 << chance.randrange(8)
                case 2:
                    at = chance.randrange(len(mutant))
                    mutant[at : at + chance.randrange(9)] = chance.randbytes(chance.randrange(9))
                    mutant = mutant or bytearray(1)
                case 3:
                    at = chance.randrange(len(mutant))
                    mutant[at : at + 4] = b"\xff\xff\xff\x7f"
        try:
            again = decode(bytes(mutant))
        except WireError:
            continue
        assert plain(decode(encode(again))) == plain(again)


def test_noise_is_no_message() -> None:
    chance = random.Random(3)
    for decode in {decode for _, decode, _ in CASES}:
        for size in (0, 1, 23, 24, 100, 3000):
            with pytest.raises(WireError, match=r"too short|not a message of version 5"):
                decode(chance.randbytes(size))


def test_a_message_of_another_kind_or_version_is_refused() -> None:
    data = wire.encode_command(COMMAND)
    with pytest.raises(WireError, match=r"kind 2 where state \(1\) is expected"):
        wire.decode_state(data)
    with pytest.raises(WireError, match="not a message of version 5"):
        wire.decode_command(data[:2] + b"\2" + data[3:])
    assert issubclass(WireError, HumanoidBtError)


def test_peek_tells_kind_sequence_and_stamp() -> None:
    assert wire.peek(wire.encode_command(COMMAND)) == (MessageKind.COMMAND, 12, 0.24)
    assert wire.peek(wire.encode_state(STATE)) == (MessageKind.STATE, 12345, 12.345)
    assert wire.peek(wire.encode_percepts(wire.Sight(PERCEPTS, {}))) == (MessageKind.PERCEPTS, 4, 1.2)
    assert wire.peek(memoryview(wire.encode_event(EVENT))) == (MessageKind.EVENT, 0, 1.5)


def test_decoded_arrays_are_aligned_and_read_only() -> None:
    state = wire.decode_state(memoryview(b"x" + wire.encode_state(STATE))[1:])
    for array in (state.joint_positions, state.hands["right"], state.gaze_direction):
        assert array.flags.aligned
        assert not array.flags.writeable
    target = wire.decode_command(wire.encode_command(COMMAND)).targets["left_hand"]
    assert isinstance(target, HandTarget)
    assert not target.position.flags.writeable


def test_what_people_read_is_cut_and_what_names_something_is_not() -> None:
    state = wire.decode_state(wire.encode_state(replace(STATE, stop_reason="ü" * 5000, stop_source="x" * 3000)))
    assert state.stop_reason == "ü" * (wire.MAX_TEXT // 2)
    assert state.stop_source == "x" * wire.MAX_TEXT
    paused = wire.decode_command(wire.encode_command(Command(0, 0.0, pause=Pause("x" * 9000, "ü" * 9000))))
    assert paused.pause == Pause("x" * 1024, "ü" * 512)
    assert wire.decode_event(wire.encode_event(replace(EVENT, text="\udcff" * 900))).text.startswith("\\udcff")
    with pytest.raises(WireError, match="a text of 70000 bytes, at most 65535"):
        wire.encode_percepts(wire.Sight([], {"x" * 70000: "hidden"}))


@pytest.mark.parametrize(
    "command",
    [
        Command(0, 0.0, {"tail": PostureTarget(0.0)}),
        Command(0, 0.0, {}, {"tail": "fetch"}),
        Command(0, 0.0, {"base": BaseTarget(np.zeros(3), 0.0)}),
        Command(0, 0.0, {"gaze": GazeTarget(np.zeros((1, 3)))}),
        Command(0, 0.0, {"posture": "low"}),  # type: ignore[dict-item]  # the mistake that is tried
        Command(0, 0.0, {"posture": PostureTarget("low")}),  # type: ignore[arg-type]  # the mistake that is tried
        Command(2**64, 0.0),
        Command(0, 0.0, pause=Pause("keyboard", None)),  # type: ignore[arg-type]  # the mistake that is tried
    ],
)
def test_a_command_that_has_no_bytes_is_refused(command: Command) -> None:
    with pytest.raises(WireError):
        wire.encode_command(command)


def test_other_messages_that_have_no_bytes_are_refused() -> None:
    for state in (
        replace(STATE, joint_torques=np.zeros(30)),
        replace(STATE, base_quaternion=np.zeros(3)),
        replace(STATE, hands={"middle": np.zeros(3)}),  # type: ignore[dict-item]  # the mistake that is tried
    ):
        with pytest.raises(WireError):
            wire.encode_state(state)
    with pytest.raises(WireError, match=r"shape \(2,\) where \(3,\)"):
        wire.encode_percepts(wire.Sight([Percept("target", 0.0, np.zeros(2), 1.0)], {}))
    with pytest.raises(WireError, match="there is no level 'fatal'; valid: info, warning, error"):
        wire.encode_event(Event(0.0, "fatal", "x"))  # type: ignore[arg-type]  # the mistake that is tried


def test_a_picture_comes_back_as_it_was() -> None:
    color = np.arange(4 * 6 * 3, dtype=np.uint8).reshape(4, 6, 3)
    depth = np.full((4, 6), np.inf, dtype=np.float32)
    depth[2, 3] = 1.25
    picture = wire.SeenPicture(1.5, color, depth, 7.5, np.array([1.0, 2.0, 3.0]), np.eye(3))
    data = wire.encode_picture(picture)
    assert len(data) <= wire.picture_room(6, 4)
    back = wire.decode_picture(data)
    assert (back.time, back.focal) == (1.5, 7.5)
    for one, other in zip(back, picture, strict=True):
        assert np.array_equal(one, other)
    for broken in (data[:-1], data + b"x", data[:30]):
        with pytest.raises(WireError):
            wire.decode_picture(broken)
