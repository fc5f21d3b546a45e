"""The messages of a recording's file, read without its library: that ends a program for one damaged byte.

A file is a head, then messages: kind, size, content. One that carries data is a protocol buffer around an Arrow stream,
compressed by LZ4, whose schema names the entity it is for. What is damaged is left out and counted, and reading goes on
with the next message that looks like one; so does a file that ends within one, because its writer was killed.
"""

from __future__ import annotations

import errno
import os
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, BinaryIO

import pyarrow as pa

from humanoid_bt.record.parts import MAGIC

_HEAD = 12  # bytes before the first message
_MESSAGE = struct.Struct("<QQ")  # kind, size
_END, _DATA = 0, 2  # kinds
_KINDS = range(8)  # that there may be; this version has four
_COMPRESSION, _SIZE, _CONTENT = 2, 3, 5  # fields of a message with data
_LZ4 = 2
_MOST_GROWTH = 255  # of what LZ4 has compressed: a damaged size must not fill the memory
_LARGEST = 1 << 30  # bytes of a message
_TRAILER = 64  # bytes that may follow the end; before more of them it is damage
_WINDOW = 1 << 20  # bytes in which the next message is looked for at once
_LIKE_DATA = _DATA.to_bytes(8, "little")
_MAYBE_DAMAGED = (pa.ArrowException, OSError, ValueError, TypeError, KeyError, IndexError, StopIteration)


class RrdFile:
    """A recording's file.

    Args:
        path: it.

    Attributes:
        damaged: how many of the messages that were looked at could not be read.
        cut: why the file could not be read to its end, "" if it could so far.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.damaged = 0
        self.cut = ""

    def batches(self, entity: str) -> Iterator[Any]:
        """Yield what the file has for an entity, each a ``pyarrow.RecordBatch``, in the order of the file.

        Raises:
            OSError: it cannot be read.
            ValueError: it is no recording.
        """
        return (batch for _, batch in self.batches_of(lambda named: named == entity))

    def batches_of(self, wanted: Callable[[str], bool]) -> Iterator[tuple[str, Any]]:
        """Yield what the file has for entities that are wanted, each with the entity's name; as :meth:`batches`."""
        for content in self._contents():
            try:
                entity, batch = _batch(content, wanted)
            except _MAYBE_DAMAGED:
                self.damaged += 1
                continue
            if batch is not None:
                yield entity, batch

    def _contents(self) -> Iterator[bytes]:
        """Yield the content of every message with data."""
        if not self._path.is_file():  # a pipe would wait for somebody who writes
            self._path.stat()
            number = errno.EISDIR if self._path.is_dir() else errno.EINVAL
            raise OSError(number, os.strerror(number))
        with self._path.open("rb") as file:
            size = os.fstat(file.fileno()).st_size
            if not file.read(_HEAD).startswith(MAGIC):
                raise ValueError("it does not begin as one does")
            while len(head := file.read(_MESSAGE.size)) == _MESSAGE.size:
                kind, length = _MESSAGE.unpack(head)
                begin = file.tell()
                if length > size - begin:
                    size = os.fstat(file.fileno()).st_size  # it may have grown meanwhile
                ends = kind == _END
                if ends and size - begin - length <= _TRAILER:
                    return
                if ends or kind not in _KINDS or length > min(size - begin, _LARGEST):
                    after = _next(file, begin - _MESSAGE.size + 1, size)
                    if after is None:
                        self.cut = f"it ends within a message, at byte {begin} of {size}"
                        return
                    self.damaged += 1
                    file.seek(after)
                elif kind == _DATA:
                    yield file.read(length)
                else:
                    file.seek(length, os.SEEK_CUR)
            if head:
                self.cut = f"it ends within the head of a message, at byte {file.tell()}"


def _next(file: BinaryIO, begin: int, size: int) -> int | None:
    """Return where the next message begins that looks like one with data, None if there is none."""
    while begin < size:
        file.seek(begin)
        window = file.read(_WINDOW + _MESSAGE.size)
        at = window.find(_LIKE_DATA)
        while 0 <= at <= len(window) - _MESSAGE.size:
            _, length = _MESSAGE.unpack_from(window, at)
            if 0 < length <= min(size - begin - at - _MESSAGE.size, _LARGEST):
                return begin + at
            at = window.find(_LIKE_DATA, at + 1)
        begin += _WINDOW
    return None


def _batch(content: bytes, wanted: Callable[[str], bool]) -> tuple[str, Any]:
    """Return the entity that a message is for and what it has, None if the entity is not wanted.

    Raises:
        One of those in ``_MAYBE_DAMAGED``: it is damaged.
    """
    fields = dict(_fields(content))
    raw, size = fields[_CONTENT], fields[_SIZE]
    if fields.get(_COMPRESSION) == _LZ4:
        if size > _MOST_GROWTH * len(raw) + _WINDOW:
            raise ValueError(f"{len(raw)} bytes cannot become {size}")
        raw = pa.decompress(raw, size, codec="lz4_raw")
    stream = pa.ipc.open_stream(raw)
    entity = stream.schema.metadata[b"rerun:entity_path"].decode()
    if not wanted(entity):
        return entity, None
    batch = stream.read_next_batch()
    batch.validate(full=True)
    if not all(name.isprintable() for name in batch.schema.names):  # which are looked at only as they are asked for
        raise ValueError("columns without names")
    return entity, batch


def _fields(message: bytes) -> Iterator[tuple[int, Any]]:
    """Yield number and value of the fields of a protocol buffer: whole numbers and bytes, which is all there are."""
    at = 0
    while at < len(message):
        key, at = _number(message, at)
        number, at = _number(message, at)
        if key & 7 == 2:
            yield key >> 3, message[at : at + number]
            at += number
        elif key & 7 == 0:
            yield key >> 3, number
        else:
            raise ValueError(f"a field of kind {key & 7}")


def _number(message: bytes, at: int) -> tuple[int, int]:
    """Return a number of seven bits a byte, and where it ends."""
    value = shift = 0
    while True:
        byte = message[at]
        value, shift, at = value | (byte & 127) << shift, shift + 7, at + 1
        if byte < 128:
            return value, at
        if shift > 63:
            raise ValueError("a number without an end")
