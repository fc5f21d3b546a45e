"""A recording that ends within a message: the disk was full, or its writer was killed. What is before that is whole."""

from __future__ import annotations

import os
import struct
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_HEAD = 12  # bytes before the first message
_MESSAGE = struct.Struct("<QQ")  # kind and size of what follows
_MOST = 1 << 30  # bytes that are copied at once


@contextmanager
def whole_part(path: Path) -> Iterator[Path]:
    """Yield a file, for as long as it is needed, with the whole messages of a recording that was cut.

    Args:
        path: the recording.

    Raises:
        OSError: it cannot be read, or there is no room for a copy.
    """
    with path.open("rb") as file, tempfile.NamedTemporaryFile(suffix=path.suffix) as copy:
        left = whole_bytes(path)
        while left > 0:
            data = file.read(min(left, _MOST))
            copy.write(data)
            left -= len(data)
        copy.flush()
        yield Path(copy.name)


def whole_bytes(path: Path) -> int:
    """Return how many bytes a recording has before the message that is cut."""
    size, end = path.stat().st_size, _HEAD
    descriptor = os.open(path, os.O_RDONLY)
    try:
        while len(header := os.pread(descriptor, _MESSAGE.size, end)) == _MESSAGE.size:
            after = end + _MESSAGE.size + _MESSAGE.unpack(header)[1]
            if after > size:
                break
            end = after
    finally:
        os.close(descriptor)
    return min(end, size)
