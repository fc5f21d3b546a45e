"""What all messages have in common: the header, texts, vectors, and one error."""

from __future__ import annotations

import functools
import struct
from collections.abc import Callable
from enum import IntEnum
from typing import NamedTuple, ParamSpec, TypeVar

import numpy as np

from humanoid_bt.core.errors import HumanoidBtError
from humanoid_bt.core.messages import Array

VERSION = 5
"""Of the format; both ends must have the same."""

MAX_TEXT = 2048
"""Bytes of UTF-8 after which what people read (reasons, events) is cut, so that it cannot outgrow a slot."""

MAX_PATH = 1024
"""Bytes of UTF-8 after which the path of a node is cut in the middle: it is told to people, and names nothing here."""

FLOAT = np.dtype("<f8")

_MAGIC = b"hb"
_HEADER = struct.Struct("<2sBB4xqd")  # magic, version, kind, sequence, stamp
_SIZE = struct.Struct("<H")
_MAX_SIZE = 0xFFFF
_CUT = "/.../"
_P = ParamSpec("_P")
_R = TypeVar("_R")


class WireError(HumanoidBtError, ValueError):
    """Bytes that are no message of this format, or a message that has no bytes."""


class MessageKind(IntEnum):
    """What a message is."""

    STATE = 1
    COMMAND = 2
    PERCEPTS = 3
    EVENT = 4
    TRUTH = 5
    PICTURE = 6


class Header(NamedTuple):
    """The beginning of every message.

    Attributes:
        kind: what follows.
        sequence: a command's sequence, a state's cycle, the number of percepts, 0 for the others.
        stamp: engine time [s]; of percepts the newest, 0 without any.
    """

    kind: int
    sequence: int
    stamp: float


def peek(data: bytes | memoryview) -> Header:
    """Return the header without decoding the rest.

    Raises:
        WireError: this is no message.
    """
    try:
        magic, version, kind, sequence, stamp = _HEADER.unpack_from(data)
    except struct.error:
        raise WireError(f"{len(data)} bytes are too short for a message") from None
    if magic != _MAGIC or version != VERSION:
        raise WireError(f"not a message of version {VERSION}: it begins with {bytes(data[:4])!r}")
    return Header(kind, sequence, stamp)


def header(kind: MessageKind, sequence: int, stamp: float) -> bytes:
    """Return the header of a message."""
    return _HEADER.pack(_MAGIC, VERSION, kind, sequence, stamp)


def guarded(action: str) -> Callable[[Callable[_P, _R]], Callable[_P, _R]]:
    """Return a decorator that turns everything bytes or values can do wrong into :class:`WireError`."""

    def decorate(function: Callable[_P, _R]) -> Callable[_P, _R]:
        @functools.wraps(function)
        def wrapper(*args: _P.args, **kwargs: _P.kwargs) -> _R:
            try:
                return function(*args, **kwargs)
            except WireError:
                raise
            except (struct.error, ValueError, TypeError, LookupError, ArithmeticError, AttributeError) as error:
                raise WireError(f"{action}: {error}") from error

        return wrapper

    return decorate


class Cursor:
    """Reads a message from its beginning to its end.

    Args:
        data: the message.
        kind: what it must be.

    Attributes:
        data: the message.
        header: its header.
        offset: of the next byte.

    Raises:
        WireError: it is something else.
    """

    __slots__ = ("data", "header", "offset")

    def __init__(self, data: bytes | memoryview, kind: MessageKind) -> None:
        self.data = bytes(data)
        self.header = peek(self.data)
        self.offset = _HEADER.size
        if self.header.kind != kind:
            raise WireError(f"a message of kind {self.header.kind} where {kind.name.lower()} ({kind}) is expected")

    def take(self, layout: struct.Struct) -> tuple[int | float, ...]:
        """Return the values of a layout."""
        values = layout.unpack_from(self.data, self.offset)
        self.offset += layout.size
        return values

    def floats(self, count: int) -> Array:
        """Return numbers, shape (count,), read-only."""
        values = np.frombuffer(self.data, FLOAT, count, self.offset)
        self.offset += values.nbytes
        return values

    def text(self) -> str:
        """Return a text."""
        begin = self.offset + _SIZE.size
        end = begin + _SIZE.unpack_from(self.data, self.offset)[0]
        if end > len(self.data):
            raise WireError(f"a text ends at byte {end} of {len(self.data)}")
        self.offset = end
        return self.data[begin:end].decode()

    def end(self) -> None:
        """Check that nothing is left.

        Raises:
            WireError: something is.
        """
        if self.offset != len(self.data):
            raise WireError(f"{len(self.data) - self.offset} bytes after the end of the message")


@functools.lru_cache(256)  # most are the same from tick to tick
def pack_text(text: str) -> bytes:
    """Return a text as UTF-8 after its size; what UTF-8 cannot hold becomes an escape.

    Raises:
        WireError: it is too long.
    """
    content = text.encode(errors="backslashreplace")
    if len(content) > _MAX_SIZE:
        raise WireError(f"a text of {len(content)} bytes, at most {_MAX_SIZE}: {text[:40]!r}...")
    return _SIZE.pack(len(content)) + content


def pack_cut_text(text: str, room: int = MAX_TEXT) -> bytes:
    """Return a text for people, cut to a number of bytes."""
    if len(text) > room // 10:  # a character takes at most four bytes, or a ten-byte escape
        text = text.encode(errors="backslashreplace")[:room].decode(errors="ignore")
    return pack_text(text)


def pack_path(path: str) -> bytes:
    """Return the path of a node, cut in the middle to :data:`MAX_PATH` bytes."""
    if len(path) > MAX_PATH // 10:
        content = path.encode(errors="backslashreplace")
        if len(content) > MAX_PATH:
            half = MAX_PATH // 2 - len(_CUT)
            path = _CUT.join((content[:half].decode(errors="ignore"), content[-half:].decode(errors="ignore")))
    return pack_text(path)


def pack_floats(values: Array, size: int) -> bytes:
    """Return the bytes of numbers of shape (size,).

    Raises:
        WireError: they have another shape.
    """
    array = np.asarray(values, FLOAT)
    if array.shape != (size,):
        raise WireError(f"numbers of shape {array.shape} where ({size},) is expected")
    return array.tobytes()
