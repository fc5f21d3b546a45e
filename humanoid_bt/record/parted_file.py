"""The file of a recording while it is written; when it is large enough, another one follows."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.core.messages import Level
from humanoid_bt.record.feed import Feed
from humanoid_bt.record.parts import part_of, remove_further
from humanoid_bt.record.recording_file import RecordingFile
from humanoid_bt.record.viewers import FLUSH_TIMEOUT

_T = TypeVar("_T")

Tell = Callable[[Level, str], None]
"""Is told what becomes of a recording: how bad it is, and a line of text."""


def tell_nobody(_level: Level, _text: str) -> None:
    """Tell nothing."""


_LOOKS = 10  # at the file, while the library takes its time to write it
_LOST = 1.0  # s to close a file that is known to be cut short


class PartedFile:
    """Writes what is recorded into a file, and from a size on into the next one.

    Every part begins with all that holds at that time, so that it can be opened alone. Until the end other runs are
    kept away from all of them.

    Args:
        path: the first part; what is left there of an older recording is overwritten.
        part_size: bytes from which on another one follows.
        feed: what is recorded.
        open_stream: returns a stream into a file; the streams of all parts are one recording.
        tell: is told what becomes of it.

    Attributes:
        began: engine time at which the part began that is written now [s]; -inf for the first one.

    Raises:
        UserError: another run writes the file, or it cannot be opened.
    """

    def __init__(
        self, path: Path, part_size: float, feed: Feed, open_stream: Callable[[Path], Any], tell: Tell = tell_nobody
    ) -> None:
        self._path, self._part_size, self._feed, self._open_stream = path, part_size, feed, open_stream
        self._tell = tell
        self._parts: list[RecordingFile] = []
        self.began = -math.inf
        self._stream = self._begin(path)
        feed.add(self._stream)
        remove_further(path)

    @property
    def trouble(self) -> str:
        """What is wrong with the part that is written now, "" while nothing is."""
        return self._parts[-1].trouble

    @property
    def deleted(self) -> bool:
        """Whether nobody can open that part any more."""
        return self._parts[-1].deleted

    def settle(self) -> bool:
        """Write out everything; return whether the file has got something since the last time.

        A file that takes nothing more is hardly waited for: the library may be silent about it.
        """
        got = False
        for _ in range(_LOOKS):
            written = bool(self.trouble) or _flush(self._stream, FLUSH_TIMEOUT / _LOOKS)
            got = self._parts[-1].check() or got
            if written:
                break
        return got

    def go_on(self, time: float) -> bool:
        """Go on in another part if this one is large enough; return whether it was.

        Args:
            time: engine time up to which everything was written [s].
        """
        before, stream = self._parts[-1], self._stream
        if before.size < self._part_size or before.trouble:
            return False
        try:
            self._stream = self._begin(part_of(self._path, len(self._parts) + 1))
        except UserError as error:
            self._part_size = math.inf
            self._tell("warning", f"{error.problems[0].message}: {relative(before.path)!r} becomes larger instead")
            return False
        self._feed.remove(stream)
        self._feed.add(self._stream, time)
        _flush(self._stream)  # from now on it can be read, whatever happens
        self.began = time
        _close(stream, FLUSH_TIMEOUT)
        before.check_end()
        if before.trouble:
            self._tell("error", before.trouble)
        self._tell("info", f"the recording goes on in {relative(self._parts[-1].path)!r}")
        return True

    def close(self) -> bool:
        """Write out everything and close; return whether the file has got something since the last time."""
        if not self.trouble:
            _flush(self._stream)
        _close(self._stream, _LOST if self.trouble else None)
        whole = self._parts[-1].check_end()
        for part in self._parts:
            part.close()
        return whole

    def _begin(self, path: Path) -> Any:
        """Return a stream into a new part, in which its beginning stands.

        That a file has no room shows as it is opened, or only as it is written, or by neither ever coming to an end:
        it depends on the library's threads.
        """
        file = RecordingFile(path)
        try:
            stream = _within(FLUSH_TIMEOUT, lambda: self._open_stream(path))
            if not _flush(stream) and file.refusal():
                raise UserError("the recording cannot be begun")
        except BaseException as error:  # whatever ends it, also Ctrl-C, leaves no file behind
            why = file.give_up() or ("nothing can be written there" if isinstance(error, TimeoutError) else "")
            if why and isinstance(error, (UserError, TimeoutError)):
                hint = "free its disk, or give another file with --record FILE (record=FILE in Python)"
                raise UserError(f"the recording {relative(path)!r} cannot be written: {why}", hint=hint) from error
            raise
        self._parts.append(file)
        return stream


def _flush(stream: Any, patience: float = FLUSH_TIMEOUT) -> bool:
    """Return whether the library has written everything within some time [s]."""
    try:
        stream.flush(timeout_sec=patience)
    except RuntimeError:  # the file tells why
        return False
    return True


def _close(stream: Any, patience: float | None) -> None:
    """Close a stream, which may take some time [s]."""
    with suppress(RuntimeError, TimeoutError):
        _within(patience, stream.disconnect)


def _within(patience: float | None, call: Callable[[], _T]) -> _T:
    """Return what the library answers; where a file takes nothing it may never come back, and is left.

    Raises:
        TimeoutError: it did not come back within some time [s].
    """
    answer: Future[_T] = Future()

    def ask() -> None:
        try:
            answer.set_result(call())
        except BaseException as error:  # for who waits, as what was answered is
            answer.set_exception(error)

    threading.Thread(target=ask, name="library", daemon=True).start()
    return answer.result(patience)
