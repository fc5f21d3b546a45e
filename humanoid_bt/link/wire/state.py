"""States on the wire: header, counts, one block of float64, targets, texts."""

from __future__ import annotations

import functools
import struct
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import accumulate, pairwise
from typing import TypeVar

import numpy as np

from humanoid_bt.core.messages import SIDES, TOUCHED, Array, Contact, FootPose, Gait, Mode, Side, State
from humanoid_bt.link.wire.format import (
    FLOAT,
    Cursor,
    MessageKind,
    WireError,
    guarded,
    header,
    pack_cut_text,
    pack_text,
)
from humanoid_bt.link.wire.targets import pack_sources, pack_targets, unpack_sources, unpack_targets

# Command sequence; joints, footsteps, limit flags; gait, mode, settled; which sides have a hand, a foot, a foot force,
# a hand error; targets, sources; which sides have an obstacle, how a hand is turned, a turn error; contacts. With the
# header a whole number of float64, so that the block after it is aligned.
_COUNTS = struct.Struct("<qHHH13B5x")
_FOOT = struct.Struct("<4d")  # x, y, z, yaw
_NUMBER = struct.Struct("<d")
_SIDE = struct.Struct("<B")
_CONTACT = struct.Struct("<BB4d")  # where, whether the arm yields, force, largest
_GAITS, _MODES = tuple(Gait), tuple(Mode)
_GAIT_INDEX = {gait: index for index, gait in enumerate(_GAITS)}
_MODE_INDEX = {mode: index for index, mode in enumerate(_MODES)}
_SIDES_OF_BITS: tuple[tuple[Side, ...], ...] = ((), SIDES[:1], SIDES[1:], SIDES)
_JOINT_ARRAYS = 5
_UPPER = np.triu_indices(9)
_COVARIANCE = np.ravel_multi_index(_UPPER, (9, 9))  # places of the elements that are sent: it is symmetric
_WHOLE_COVARIANCE = np.zeros((9, 9), np.intp)  # of each element, its place among those
_WHOLE_COVARIANCE[_UPPER] = _WHOLE_COVARIANCE.T[_UPPER] = np.arange(len(_COVARIANCE))
_FIXED_SIZES = (3, 4, 3, 3, len(_COVARIANCE), 3, 3, 3, 3, 3)  # of the arrays after those of the joints
_V = TypeVar("_V")


def state_room(joints: Iterable[str]) -> int:
    """Return the most bytes that a state of a robot with these joints takes, with 150 planned footsteps."""
    fixed = 16384
    return fixed + sum(_JOINT_ARRAYS * FLOAT.itemsize + len(pack_text(joint)) for joint in joints)


@guarded("this state cannot be encoded")
def encode_state(state: State) -> bytes:
    """Return a state as bytes; a long reason is cut.

    Raises:
        WireError: an array has the wrong shape, or a resource or side is unknown.
    """
    joints = len(state.joint_positions)
    hands, hand_bits = _by_side(state.hands)
    feet, foot_bits = _by_side(state.feet)
    forces, force_bits = _by_side(state.foot_force)
    errors, error_bits = _by_side(state.hand_errors)
    obstacles, obstacle_bits = _by_side(state.hand_obstacles)
    orientations, orientation_bits = _by_side(state.hand_orientations)
    turn_errors, turn_error_bits = _by_side(state.hand_turn_errors)
    arrays = (
        state.joint_positions,
        state.joint_velocities,
        state.joint_torques,
        state.setpoint_positions,
        state.setpoint_velocities,
        state.base_position,
        state.base_quaternion,
        state.base_linear_velocity,
        state.base_angular_velocity,
        state.base_covariance.take(_COVARIANCE),
        state.com,
        state.com_velocity,
        state.stance,
        state.gaze_position,
        state.gaze_direction,
        *hands,
        *orientations,
    )
    sizes = (joints,) * _JOINT_ARRAYS + _FIXED_SIZES + (3,) * len(hands) + (4,) * len(orientations)
    parts = [
        header(MessageKind.STATE, state.cycle, state.time),
        _COUNTS.pack(
            state.command_sequence,
            joints,
            len(state.footsteps),
            len(state.limit_flags),
            _GAIT_INDEX[state.gait],
            _MODE_INDEX[state.mode],
            state.base_settled,
            hand_bits,
            foot_bits,
            force_bits,
            error_bits,
            len(state.targets),
            len(state.command_sources),
            obstacle_bits,
            orientation_bits,
            turn_error_bits,
            len(state.contacts),
        ),
        _pack_arrays(arrays, sizes),
        *[_pack_foot(foot) for foot in feet],
        *[_NUMBER.pack(force) for force in forces],
        *[_NUMBER.pack(error) for error in (*errors, *turn_errors)],
        *[_pack_foot(foot) for _, foot in state.footsteps],
        *[_SIDE.pack(SIDES.index(side)) for side, _ in state.footsteps],
        pack_targets(state.targets),
        pack_sources(state.command_sources),
        pack_cut_text(state.stop_reason),
        pack_cut_text(state.stop_source),
        *[pack_text(name) for name in state.limit_flags],
        *[pack_text(name) for name in obstacles],
        *[_pack_contact(group, contact) for group, contact in state.contacts.items()],
    ]
    return b"".join(parts)


@guarded("malformed state")
def decode_state(data: bytes | memoryview) -> State:
    """Return the state that bytes hold; its arrays share one read-only block.

    Raises:
        WireError: they hold none.
    """
    cursor = Cursor(data, MessageKind.STATE)
    counts: tuple[int, ...] = _COUNTS.unpack_from(cursor.data, cursor.offset)
    cursor.offset += _COUNTS.size
    sequence, joints, footstep_count, flag_count, gait, mode, settled = counts[:7]
    hands, feet, forces, errors = map(_SIDES_OF_BITS.__getitem__, counts[7:11])
    target_count, source_count = counts[11:13]
    obstacles, orientations, turn_errors = map(_SIDES_OF_BITS.__getitem__, counts[13:16])
    if settled > 1:
        raise WireError(f"{settled} is no truth value")
    places = _places(joints, len(hands), len(orientations))
    values = cursor.floats(
        places[-1].stop + 4 * len(feet) + len(forces) + len(errors) + len(turn_errors) + 4 * footstep_count
    )
    array = map(values.__getitem__, places).__next__
    number = iter(values[places[-1].stop :].tolist()).__next__
    # Arguments are evaluated in the order in which they are written, which is the order on the wire.
    return State(
        time=cursor.header.stamp,
        cycle=cursor.header.sequence,
        joint_positions=array(),
        joint_velocities=array(),
        joint_torques=array(),
        setpoint_positions=array(),
        setpoint_velocities=array(),
        base_position=array(),
        base_quaternion=array(),
        base_linear_velocity=array(),
        base_angular_velocity=array(),
        base_covariance=_symmetric(array()),
        com=array(),
        com_velocity=array(),
        stance=array(),
        gaze_position=array(),
        gaze_direction=array(),
        hands={side: array() for side in hands},
        hand_orientations={side: array() for side in orientations},
        feet={side: _foot(number) for side in feet},
        foot_force={side: number() for side in forces},
        hand_errors={side: number() for side in errors},
        hand_turn_errors={side: number() for side in turn_errors},
        footsteps=_footsteps(cursor, [_foot(number) for _ in range(footstep_count)]),
        gait=_GAITS[gait],
        mode=_MODES[mode],
        base_settled=bool(settled),
        command_sequence=sequence,
        targets=unpack_targets(cursor, target_count),
        command_sources=unpack_sources(cursor, source_count),
        stop_reason=cursor.text(),
        stop_source=cursor.text(),
        limit_flags=tuple([cursor.text() for _ in range(flag_count)]),
        hand_obstacles={side: cursor.text() for side in obstacles},
        contacts=_contacts(cursor, counts[16]),
    )


@functools.lru_cache(16)  # in a run there are few
def _places(joints: int, hands: int, orientations: int) -> tuple[slice, ...]:
    """Return where the arrays of a state are among its numbers, in their order; what is behind them are no arrays."""
    sizes = (joints,) * _JOINT_ARRAYS + _FIXED_SIZES + (3,) * hands + (4,) * orientations
    return tuple(slice(begin, end) for begin, end in pairwise(accumulate(sizes, initial=0)))


def _foot(number: Callable[[], float]) -> FootPose:
    x, y, z, yaw = number(), number(), number(), number()
    return FootPose(x, y, yaw, z)


def _pack_arrays(arrays: Sequence[Array], sizes: Sequence[int]) -> bytes:
    """Return the bytes of numbers, one array after the other: at once, in a third of the time of one by one.

    Raises:
        WireError: one has another size, or more than one axis.
    """
    if (found := tuple(map(len, arrays))) != sizes:
        raise WireError(f"numbers of the shapes {found} where {sizes} are expected")
    return np.concatenate(arrays, dtype=FLOAT).tobytes()


def _pack_foot(foot: FootPose) -> bytes:
    return _FOOT.pack(foot.x, foot.y, foot.z, foot.yaw)


def _symmetric(upper: Array) -> Array:
    whole: Array = upper.take(_WHOLE_COVARIANCE)
    whole.flags.writeable = False
    return whole


def _by_side(values: Mapping[Side, _V]) -> tuple[list[_V], int]:
    """Return the values in the order of the sides, and a bit for each side that has one."""
    if not values:
        return [], 0
    left, right = SIDES
    bits = (left in values) | (right in values) << 1
    ordered = [values[side] for side in _SIDES_OF_BITS[bits]]
    if len(ordered) != len(values):
        raise WireError(f"sides {sorted(values)} where only {SIDES} are known")
    return ordered, bits


def _footsteps(cursor: Cursor, poses: list[FootPose]) -> tuple[tuple[Side, FootPose], ...]:
    return tuple([(SIDES[int(cursor.take(_SIDE)[0])], pose) for pose in poses])


def _pack_contact(group: str, contact: Contact) -> bytes:
    x, y, z = contact.force.tolist()
    return _CONTACT.pack(TOUCHED.index(group), contact.yields, x, y, z, contact.largest)


def _contacts(cursor: Cursor, count: int) -> dict[str, Contact]:
    """Return a number of contacts, which come last."""
    contacts: dict[str, Contact] = {}
    for _ in range(count):
        group, yields, x, y, z, largest = cursor.take(_CONTACT)
        if group >= len(TOUCHED) or yields > 1 or TOUCHED[int(group)] in contacts:
            raise WireError(f"a contact of number {group} that yields {yields}")
        force = np.array((x, y, z))
        force.flags.writeable = False
        contacts[TOUCHED[int(group)]] = Contact(force, largest, bool(yields))
    cursor.end()
    return contacts
