"""What the recorder is told, as bytes: a pickle for each call, in which a tick is in the form of the wire.

The numbers of servo cycles come after theirs.
"""

from __future__ import annotations

import pickle
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from humanoid_bt.core.messages import Array, Percept
from humanoid_bt.decision.result import Reported
from humanoid_bt.perception.track import Track
from humanoid_bt.record.tick import Tick, state_of

_SAMPLE, _CYCLES, _RESULTS = "sample", "cycles", "results"
_NUMBER = np.dtype(float).itemsize  # bytes
_NOWHERE = np.full(3, np.nan)  # a recording shows where a percept is in the world, never in an older base frame


class Source(Protocol):
    """What calls are read from."""

    def read(self, size: int, /) -> bytes:
        """Return so many bytes, fewer only at the end."""

    def readline(self) -> bytes:
        """Return the bytes up to the next line break."""


def encode_call(method: str, *arguments: object) -> bytes:
    """Return a call of the recorder as bytes."""
    return pickle.dumps((method, arguments), pickle.HIGHEST_PROTOCOL)


def encode_sample(
    tick: Tick, tracks: Mapping[str, Track], objects: Mapping[str, Array], hidden: Iterable[str]
) -> bytes:
    """Return the call of a tick as bytes: a third of the time that pickling its messages takes.

    Args:
        tick: what decision saw and commanded.
        tracks: percepts by name, placed in the world.
        objects: true positions of scene objects by name, world frame, shape (3,) [m].
        hidden: names of those that perception cannot see now.

    Raises:
        WireError: the tick is none that the wire can carry.
    """
    rows = [
        (name, track.stamp, track.confidence, track.position_world.tolist(), track.age, *_box(track), *_more(track))
        for name, track in tracks.items()
    ]
    places = {name: position.tolist() for name, position in objects.items()}
    return encode_call(_SAMPLE, tick.encode(), rows, places, tuple(hidden))


def encode_cycles(plans: Array, cycles: Array) -> tuple[bytes, bytes, bytes]:
    """Return the call of servo cycles as bytes, in parts: in half of the time that a pickle with the numbers takes."""
    call = encode_call(_CYCLES, plans.shape, cycles.shape)
    return call, np.asarray(plans, float).tobytes(), np.asarray(cycles, float).tobytes()


def encode_results(time: float, path: str, results: Sequence[Reported]) -> bytes:
    """Return the call of what a skill has reported as bytes: a third of the time that pickling them as they are takes.

    Args:
        time: engine time [s].
        path: the skill's.
        results: what it has set by now.
    """
    return encode_call(_RESULTS, time, path, [tuple(one) for one in results])


def _more(track: Track) -> tuple[list[float] | None, str, list[list[float]] | None]:
    orientation, covariance = track.orientation_world, track.covariance_world
    return (
        None if orientation is None else orientation.tolist(),
        track.class_name,
        None if covariance is None else covariance.tolist(),
    )


def _box(track: Track) -> tuple[list[float] | None, float]:
    return (None if track.size is None else track.size.tolist()), track.heading_world


def decode_call(source: Source) -> tuple[str, tuple[Any, ...]]:
    """Return the next call: the recorder's method and its arguments.

    Args:
        source: from a process of this run, for a pickle can do anything.

    Raises:
        EOFError: there is none any more.
        pickle.UnpicklingError: it is cut short.
    """
    method, arguments = pickle.load(source)
    if method == _CYCLES:
        return method, tuple([_rows(source, *shape) for shape in arguments])
    if method == _RESULTS:
        time, path, results = arguments
        return method, (time, path, [Reported(*one) for one in results])
    return method, _sample(*arguments) if method == _SAMPLE else arguments


def _rows(source: Source, count: int, width: int) -> Array:
    """Return the rows of numbers that come next; raises EOFError if they are cut short."""
    size = count * width * _NUMBER
    if len(data := source.read(size)) < size:
        raise EOFError
    return np.frombuffer(data).reshape(count, width)


def _sample(
    data: bytes, rows: list[Any], places: Mapping[str, list[float]], hidden: tuple[str, ...]
) -> tuple[Any, ...]:
    state = state_of(data)
    tracks = {
        name: Track(
            Percept(
                name,
                stamp,
                _NOWHERE,
                confidence,
                None if size is None else np.array(size),
                orientation=None if turn is None else np.array(turn),
                class_name=kind,
                covariance=None if spread is None else np.array(spread),
            ),
            np.array(position),
            age,
            state,
            heading,
        )
        for name, stamp, confidence, position, age, size, heading, turn, kind, spread in rows
    }
    return state, tracks, {name: np.array(position) for name, position in places.items()}, hidden, data
