"""Many samples of many numbers in few bytes: what a flight recorder writes a thousand times a second.

A block is a table of samples, a row each. Each column has a resolution; what is kept of a number is how many of these
it is. Neighbouring samples of a moving robot differ little, so that the differences from row to row, byte by byte, hold
long runs of equal bytes once their signs are folded into their lowest bits, so that noise around zero changes no other
byte; a general compressor makes a sixth of them. A block with a number that is not finite, or
too large for its resolution, is kept as it is: what happened before a robot fell must be readable bit by bit.

What is no table, messages of any length, goes into bundles.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from humanoid_bt.core.errors import HumanoidBtError
from humanoid_bt.core.messages import Array

_HEADER = struct.Struct("<BIIQ")  # form, rows, columns, check of what follows
_BUNDLE = struct.Struct("<IIQ")  # messages, bytes of them with their sizes, check of what follows
_SIZE = struct.Struct("<I")  # of a message
_EXACT, _ROUNDED = 0, 2
_WIDTH = {_EXACT: 8, _ROUNDED: 4}  # bytes of a number
_ZSTD = pa.Codec("zstd", compression_level=1)  # an eighth of the time of zlib for a little less; higher ones save none
_ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"  # older recordings are compressed by zlib
_MOST = 2**30  # of a column's resolution; what is larger is kept as it is
_LARGEST = 2**28  # bytes of a block; a damaged header must not fill the memory


class BlockError(HumanoidBtError):
    """The bytes are no whole block."""


def pack(block: Array, resolution: Array) -> bytes:
    """Return a block as bytes.

    Args:
        block: shape (rows, columns).
        resolution: of each column, shape (columns,), in its unit.
    """
    rows, columns = block.shape
    with np.errstate(invalid="ignore", over="ignore"):
        counts = block / resolution
        np.rint(counts, out=counts)
    if rows and counts.min() > -_MOST and counts.max() < _MOST:  # also false where one is not finite
        form, body = _ROUNDED, _by_byte(_folded(counts.astype("<i4")))
    else:
        form, body = _EXACT, np.asarray(block, "<f8").tobytes()
    packed = _compressed(body)
    return _HEADER.pack(form, rows, columns, zlib.crc32(packed)) + packed


def unpack(packed: bytes, resolution: Array, only: Sequence[int] | None = None) -> Array:
    """Return a packed block, shape (rows, columns): each number within half of its resolution, or exact.

    Args:
        packed: the block.
        resolution: of each of its columns, shape (columns,).
        only: the columns that are wanted; all if None. What is left out costs little.

    Raises:
        BlockError: the bytes are cut, changed, or were packed for other columns.
    """
    form, rows, columns, raw = _opened(packed)
    if columns != len(resolution):
        raise BlockError(f"a block has {columns} columns, not {len(resolution)}")
    wanted: Any = slice(None) if only is None else list(only)
    if form == _EXACT:
        return np.frombuffer(raw, "<f8").reshape(rows, columns)[:, wanted].copy()
    bytes_of = np.frombuffer(raw, np.uint8).reshape(4, columns, rows)[:, wanted]
    folded = np.ascontiguousarray(bytes_of.transpose(2, 1, 0)).view("<u4").reshape(rows, bytes_of.shape[1])
    steps = (folded >> 1).astype("<i4") ^ -(folded & 1).astype("<i4")
    numbers: Array = np.cumsum(steps, axis=0, dtype=np.int32) * resolution[wanted]
    return numbers


def bundle(messages: Sequence[bytes]) -> bytes:
    """Return messages as one."""
    body = b"".join(part for message in messages for part in (_SIZE.pack(len(message)), message))
    packed = _compressed(body)
    return _BUNDLE.pack(len(messages), len(body), zlib.crc32(packed)) + packed


def unbundle(packed: bytes) -> list[bytes]:
    """Return the messages of a bundle.

    Raises:
        BlockError: the bytes are cut, changed, or no bundle.
    """
    if len(packed) < _BUNDLE.size:
        raise BlockError(f"a bundle of {len(packed)} bytes is too short")
    count, size, check = _BUNDLE.unpack_from(packed)
    body = packed[_BUNDLE.size :]
    if zlib.crc32(body) != check or size > _LARGEST:
        raise BlockError("a bundle is damaged")
    raw, messages, offset = _inflated(body, size), list[bytes](), 0
    while offset + _SIZE.size <= size:
        (length,) = _SIZE.unpack_from(raw, offset)
        messages.append(raw[offset + _SIZE.size : offset + _SIZE.size + length])
        offset += _SIZE.size + length
    if len(messages) != count or offset != size:
        raise BlockError(f"a bundle of {count} messages holds {len(messages)}")
    return messages


def is_whole(packed: bytes, bundled: bool) -> bool:
    """Return whether the bytes of a block, or of a bundle, are as they were written."""
    try:
        unbundle(packed) if bundled else _opened(packed)
    except BlockError:
        return False
    return True


def _opened(packed: bytes) -> tuple[int, int, int, bytes]:
    """Return form, rows and columns of a block, and its numbers as bytes.

    Raises:
        BlockError: the bytes are cut or changed.
    """
    if len(packed) < _HEADER.size:
        raise BlockError(f"a block of {len(packed)} bytes is too short")
    form, rows, columns, check = _HEADER.unpack_from(packed)
    body = packed[_HEADER.size :]
    size = rows * columns * _WIDTH.get(form, 0)
    if zlib.crc32(body) != check or form not in _WIDTH or size > _LARGEST:
        raise BlockError("a block is damaged")
    return form, rows, columns, _inflated(body, size)


def _compressed(body: bytes) -> bytes:
    packed: bytes = _ZSTD.compress(body, asbytes=True)
    return packed


def _inflated(body: bytes, size: int) -> bytes:
    """Return so many bytes that were compressed: bytes that claim to be few cannot become many.

    Raises:
        BlockError: they are not so many, or were not compressed.
    """
    try:
        if body.startswith(_ZSTD_MAGIC):
            raw: bytes = _ZSTD.decompress(body, size, asbytes=True)
            return raw
        stream = zlib.decompressobj()
        raw = stream.decompress(body, size + 1)
    except (OSError, zlib.error) as error:
        raise BlockError(f"a block is damaged: {error}") from error
    if len(raw) != size or not stream.eof:
        raise BlockError(f"a block holds {len(raw)} bytes or more, not {size}")
    return raw


def _folded(numbers: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the steps from row to row, their signs in their lowest bits."""
    steps = numbers.copy()
    steps[1:] -= numbers[:-1]
    signs = steps >> 31
    steps <<= 1
    steps ^= signs
    return steps


def _by_byte(steps: NDArray[np.int32]) -> bytes:
    """Return first all lowest bytes, column by column, then all second ones and so on."""
    columns = np.ascontiguousarray(steps.T)
    return b"".join([(columns >> shift).astype(np.uint8).tobytes() for shift in (0, 8, 16, 24)])
