"""What the frames of each kind carry, as bytes and back."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from humanoid_bt.cable.safe_state import SAFE_STATES, SafeState
from humanoid_bt.core.clock import SERVO_PERIOD
from humanoid_bt.core.errors import nearest
from humanoid_bt.core.messages import READING_SIZE, Array, JointCommand, Truth
from humanoid_bt.link.wire import WireError, decode_truth, encode_truth
from humanoid_bt.link.wire.format import FLOAT, guarded, pack_cut_text, pack_text
from humanoid_bt.plant.touches import Touch

MOST_SEED = 2**64 - 1
"""Largest seed that fits into a hello."""

_COMMAND_ROWS = 5  # position, velocity, stiffness, damping, torque
_TEXT = struct.Struct("<H")
_HELLO = struct.Struct("<QH")  # seed, joints
_WELCOME = struct.Struct("<QBBddH")  # nonce, simulated, safe state, period, watchdog, joints
_NONCE = struct.Struct("<Q")
_SENSORS = struct.Struct("<QdB7x")  # sequence of the newest command, how long ago it came, what the plant does
_SIMULATED = struct.Struct("<dH")  # largest external force, touches
_TOUCH = struct.Struct("<dB")  # time, whether it was meant
_MOST_TOUCHES = 256  # with their names they fill half a datagram


class PlantState(IntEnum):
    """What a plant does with its drives."""

    WAITS = 0  # nobody has commanded it so far
    FOLLOWS = 1
    HOLDS = 2
    DAMPS = 3


@dataclass(frozen=True)
class Hello:
    """What a driver says of itself.

    Attributes:
        robot: name of the robot that it wants to drive.
        joints: names of its joints, in the order of its commands.
        scene: name of the scene that a simulated plant is to stand in; "" for any, as of a real one.
        seed: of what is random in it.
        digest: of what stands and happens in the scene; "" for anything.
    """

    robot: str
    joints: tuple[str, ...]
    scene: str = ""
    seed: int = 0
    digest: str = ""


@dataclass(frozen=True)
class Description:
    """What a plant says of itself.

    Attributes:
        robot: its name.
        joints: names of its joints, in the order of its sensors.
        simulated: whether it tells where the robot really is.
        safe: what it does when it hears nothing.
        watchdog: for how long it hears nothing until then [s].
        period: of its servo [s].
    """

    robot: str
    joints: tuple[str, ...]
    simulated: bool
    safe: SafeState
    watchdog: float
    period: float

    def mismatch(self, hello: Hello) -> str:
        """Return why a driver that takes the plant for something else cannot have it, "" if it can."""
        if hello.robot != self.robot:
            return f"this plant is the robot {self.robot!r}, not {hello.robot!r}"
        if abs(self.period - SERVO_PERIOD) > SERVO_PERIOD * 1e-3:
            return (
                f"this plant has a servo period of {self.period * 1e3:g} ms, and control of {SERVO_PERIOD * 1e3:g} ms"
            )
        if hello.joints == self.joints:
            return ""
        if len(hello.joints) != len(self.joints):
            return f"{self.robot!r} has {len(self.joints)} joints here, not {len(hello.joints)}"
        index = next(i for i, names in enumerate(zip(hello.joints, self.joints, strict=True)) if names[0] != names[1])
        wrong, right = hello.joints[index], self.joints[index]
        return f"joint {index} of {self.robot!r} is {right!r} here, not {wrong!r}; {nearest(wrong, self.joints)}"


class Sensors(NamedTuple):
    """What the sensors say, and what the plant does.

    Attributes:
        heard: sequence of the newest command that the plant took, 0 before the first.
        ago: how long ago that came [s].
        state: what it does.
        values: those of a :class:`~humanoid_bt.core.messages.Reading`, shape (12 + 3 nj,).
    """

    heard: int
    ago: float
    state: PlantState
    values: Array


class Simulated(NamedTuple):
    """What only a simulation knows, in its own time.

    Attributes:
        truth: where the robot really is.
        force: largest external force on it so far [N, Nm].
        touches: what of the scene it has touched so far.
    """

    truth: Truth
    force: float
    touches: Sequence[Touch]


def pack_hello(hello: Hello) -> bytes:
    """Return it as bytes."""
    texts = (hello.robot, hello.scene, hello.digest, *hello.joints)
    return _HELLO.pack(hello.seed, len(hello.joints)) + b"".join(map(pack_text, texts))


@guarded("malformed hello")
def unpack_hello(payload: bytes) -> Hello:
    """Return what bytes hold.

    Raises:
        WireError: it is something else.
    """
    seed, count = _HELLO.unpack_from(payload)
    robot, scene, digest, *joints = _texts(payload, _HELLO.size, 3 + count)
    return Hello(robot, tuple(joints), scene, seed, digest)


def pack_welcome(nonce: int, plant: Description) -> bytes:
    """Return what a plant is as bytes, in answer to the hello with this number."""
    safe = SAFE_STATES.index(plant.safe)
    head = _WELCOME.pack(nonce, plant.simulated, safe, plant.period, plant.watchdog, len(plant.joints))
    return head + b"".join(map(pack_text, (plant.robot, *plant.joints)))


@guarded("malformed welcome")
def unpack_welcome(payload: bytes) -> tuple[int, Description]:
    """Return the number of the hello that is answered, and what the plant is.

    Raises:
        WireError: it is something else.
    """
    nonce, simulated, safe, period, watchdog, count = _WELCOME.unpack_from(payload)
    robot, *joints = _texts(payload, _WELCOME.size, 1 + count)
    return nonce, Description(robot, tuple(joints), bool(simulated), SAFE_STATES[safe], watchdog, period)


def pack_refusal(nonce: int, reason: str) -> bytes:
    """Return why the hello with this number, or the session, is refused."""
    return _NONCE.pack(nonce) + pack_cut_text(reason)


@guarded("malformed refusal")
def unpack_refusal(payload: bytes) -> tuple[int, str]:
    """Return the number of the hello or session, and why it is refused.

    Raises:
        WireError: it is something else.
    """
    (nonce,) = _NONCE.unpack_from(payload)
    (reason,) = _texts(payload, _NONCE.size, 1)
    return nonce, reason


def pack_command(command: JointCommand) -> bytes:
    """Return a joint command: position, velocity, stiffness, damping, torque of all joints, one after the other."""
    rows = command.position, command.velocity, command.stiffness, command.damping, command.torque
    return np.concatenate(rows).astype(FLOAT, copy=False).tobytes()


def unpack_command(payload: bytes, joints: int) -> JointCommand:
    """Return the joint command that bytes hold.

    Raises:
        WireError: it is for another number of joints, is not finite, or would be no spring and no damper.
    """
    if len(payload) != _COMMAND_ROWS * joints * FLOAT.itemsize:
        raise WireError(f"a command of {len(payload)} bytes where {joints} joints take {_COMMAND_ROWS * joints * 8}")
    rows = np.frombuffer(payload, FLOAT).reshape(_COMMAND_ROWS, joints)
    if not np.isfinite(rows).all():
        raise WireError("a command that is not finite")
    if (rows[2:4] < 0).any():
        raise WireError("a command with negative stiffness or damping")
    return JointCommand(*rows)


def pack_sensors(sensors: Sensors) -> bytes:
    """Return them as bytes."""
    heard, ago, state, values = sensors
    return _SENSORS.pack(heard, ago, state) + values.astype(FLOAT, copy=False).tobytes()


@guarded("malformed sensors")
def unpack_sensors(payload: bytes, joints: int) -> Sensors:
    """Return what bytes hold.

    Raises:
        WireError: it is something else, or of another number of joints.
    """
    size = READING_SIZE + 3 * joints
    if len(payload) != _SENSORS.size + size * FLOAT.itemsize:
        raise WireError(f"sensors of {len(payload)} bytes where {joints} joints take {_SENSORS.size + size * 8}")
    heard, ago, state = _SENSORS.unpack_from(payload)
    return Sensors(heard, ago, PlantState(state), np.frombuffer(payload, FLOAT, offset=_SENSORS.size))


def pack_simulated(known: Simulated) -> bytes:
    """Return what only a simulation knows as bytes, with its first touches if they are very many."""
    touches = known.touches[:_MOST_TOUCHES]
    told = [_TOUCH.pack(one.time, one.meant) + pack_text(one.thing) + pack_text(one.link) for one in touches]
    return _SIMULATED.pack(known.force, len(touches)) + b"".join(told) + encode_truth(known.truth)


@guarded("malformed truth")
def unpack_simulated(payload: bytes) -> Simulated:
    """Return what bytes hold.

    Raises:
        WireError: it is something else.
    """
    force, count = _SIMULATED.unpack_from(payload)
    touches, offset = [], _SIMULATED.size
    for _ in range(count):
        time, meant = _TOUCH.unpack_from(payload, offset)
        (thing, link), offset = _texts_from(payload, offset + _TOUCH.size, 2)
        touches.append(Touch(time, thing, link, bool(meant)))
    return Simulated(decode_truth(payload[offset:]), force, touches)


def _texts(payload: bytes, offset: int, count: int) -> Sequence[str]:
    """Return the texts with which a payload ends."""
    texts, offset = _texts_from(payload, offset, count)
    if offset != len(payload):
        raise WireError(f"its texts end at byte {offset} of {len(payload)}")
    return texts


def _texts_from(payload: bytes, offset: int, count: int) -> tuple[Sequence[str], int]:
    """Return texts that begin at a byte, and where they end."""
    texts = []
    for _ in range(count):
        begin = offset + _TEXT.size
        offset = begin + _TEXT.unpack_from(payload, offset)[0]
        texts.append(payload[begin:offset].decode())
    return texts, offset
