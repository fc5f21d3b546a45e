"""The open end of a recording: its file, and the viewers that it feeds."""

from __future__ import annotations

import contextlib
import logging
import math
import subprocess
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from typing import Any
from urllib.parse import quote

import rerun as rr

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.texts import one_line, printable
from humanoid_bt.record.feed import Feed
from humanoid_bt.record.folder import make_room
from humanoid_bt.record.parted_file import PartedFile, Tell, tell_nobody
from humanoid_bt.record.sinks import LOOPBACK, Sinks
from humanoid_bt.record.viewers import FLUSH_TIMEOUT, LONGEST, free_port, start_viewer, wait_until_taken
from humanoid_bt.record.web_page import WebPage

_log = logging.getLogger(__name__)

APPLICATION = "humanoid_bt"

Announce = Callable[[str, float], None]
"""Is told what is done next, "close the file", and how long that is waited for at most [s]."""


def tell_nothing(_what: str, _limit: float) -> None:
    """Announce nothing."""


_VIEWER_MEMORY = "1GiB"  # of the server that keeps the run for a browser that opens late


class Outlet:
    """An open recording and the viewers it feeds.

    Args:
        sinks: where it goes.
        name: the recording's name in the viewer.
        blueprint: how the viewer shows it.
        announce: is told what the end waits for.
        tell: is told what becomes of the file.

    Attributes:
        stream: takes what is recorded.
        url: address of the web viewer, "" if none is served.

    Raises:
        UserError: a sink cannot be opened; those opened before are closed again.
    """

    def __init__(
        self, sinks: Sinks, name: str, blueprint: Any, announce: Announce = tell_nothing, tell: Tell = tell_nobody
    ) -> None:
        sinks.check()
        self._sinks, self._name, self._blueprint = sinks, printable(name), blueprint
        self._announce, self._tell = announce, tell
        self._recording_id, self._created = uuid.uuid4().hex, time.time_ns()
        self.stream = Feed()
        self.url = ""
        self._file: PartedFile | None = None
        self._watched: Any = None  # the stream of the viewers
        self._viewer: subprocess.Popen[bytes] | None = None
        self._page: WebPage | None = None
        self._data_port = 0
        self._closed = False
        try:
            self._open(sinks)
        except BaseException:
            self.close()
            raise

    @property
    def trouble(self) -> str:
        """What is wrong with the file, "" while nothing is."""
        return self._file.trouble if self._file is not None else ""

    @property
    def kept(self) -> float:
        """Engine time [s] up to which nobody can delete what was written, for it is in an earlier file."""
        return self._file.began if self._file is not None and self._file.deleted else math.inf

    def settle(self) -> bool:
        """Have the file get everything; return whether it has got something. True if there is no file.

        A viewer that hangs is not waited for.
        """
        return self._file is None or self._file.settle()

    def go_on(self, time: float) -> None:
        """Go on in another file if this one is large enough.

        Args:
            time: engine time up to which everything was sent [s].
        """
        if self._file is not None and self._file.go_on(time):
            self._make_room()

    def close(self) -> bool:
        """Write out everything and close; the native viewer stays open. Return whether the file has all of it."""
        if self._closed:
            return False
        self._closed = True
        whole = True
        if self._file is not None:
            self._announce("close the file", FLUSH_TIMEOUT)
            whole = self._file.close()
        if self._watched is not None:
            with self._patience("hand the rest to whoever watches"):
                self._watched.flush(timeout_sec=FLUSH_TIMEOUT)
            if self._page is not None:
                self._announce("let browsers take the rest", LONGEST)
                wait_until_taken(self._data_port)
            with self._patience("let go of whoever watches"):
                self._watched.disconnect()
        if self._page is not None:
            self._page.close()
        return whole

    @contextlib.contextmanager
    def _patience(self, what: str) -> Iterator[None]:
        """Wait for the native viewer, but not for ever: one that hangs is ended, or the run would not end either."""
        self._announce(what, FLUSH_TIMEOUT)
        timer = threading.Timer(FLUSH_TIMEOUT, self._end_viewer)
        timer.start()
        try:
            with contextlib.suppress(RuntimeError):  # a viewer that was closed
                yield
        finally:
            timer.cancel()

    def _open(self, sinks: Sinks) -> None:
        if sinks.file is not None:
            open_stream = lambda path: self._open_stream(rr.FileSink(path))  # noqa: E731 (shorter than a function)
            self._file = PartedFile(sinks.file, sinks.part_size, self.stream, open_stream, self._tell)
        targets: list[Any] = []
        if sinks.serve is not None:
            self._data_port = sinks.serve + 1
            targets.append(rr.GrpcServerSink(LOOPBACK, self._data_port, server_memory_limit=_VIEWER_MEMORY))
            self._page = WebPage(sinks.serve, self._data_port)
            source = f"rerun+http://{LOOPBACK}:{self._data_port}/proxy"
            self.url = f"http://{LOOPBACK}:{sinks.serve}?url={quote(source, safe='')}"
        if sinks.view:
            port = free_port()
            self._viewer = start_viewer(port)
            targets.append(rr.GrpcSink(f"rerun+http://{LOOPBACK}:{port}/proxy"))
        if targets:
            self._watched = self._open_stream(*targets)
            self.stream.add(self._watched)
        self._make_room()

    def _open_stream(self, *targets: Any) -> Any:
        """Return a stream into some sinks; to whoever reads them all streams are one recording."""
        stream = rr.RecordingStream(APPLICATION, recording_id=self._recording_id, send_properties=False)
        try:
            stream.set_sinks(*targets, default_blueprint=self._blueprint)
        except RuntimeError as error:
            raise UserError(f"the recording cannot be opened: {one_line(str(error))}") from error
        stream.send_recording_name(self._name)
        stream.send_recording_start_time_nanos(self._created)
        return stream

    def _make_room(self) -> None:
        """Let old recordings make room in the folder."""
        if self._sinks.file is not None and self._sinks.limits is not None:
            text = make_room(self._sinks.file.parent, self._sinks.limits)
            if text:
                self._tell("info", text)

    def _end_viewer(self) -> None:
        if self._viewer is not None and self._viewer.poll() is None:
            _log.warning("the viewer did not take the recording's end within %g s and was ended", FLUSH_TIMEOUT)
            self._viewer.kill()
