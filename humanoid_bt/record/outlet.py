"""The open end of a recording: its stream, its file, and the viewers that it feeds."""

from __future__ import annotations

import contextlib
import logging
import subprocess
import threading
from collections.abc import Callable, Iterator
from typing import Any
from urllib.parse import quote

import rerun as rr

from humanoid_bt.core.errors import UserError
from humanoid_bt.record.recording_file import RecordingFile
from humanoid_bt.record.sinks import LOOPBACK, Sinks
from humanoid_bt.record.viewers import FLUSH_TIMEOUT, LONGEST, free_port, start_viewer, wait_until_taken
from humanoid_bt.record.web_page import WebPage

_log = logging.getLogger(__name__)

APPLICATION = "humanoid_bt"

Announce = Callable[[str, float], None]
"""Is told what is done next, "close the file", and how long that is waited for at most [s]."""


def tell_nobody(_what: str, _limit: float) -> None:
    """Announce nothing."""


_LOOKS = 10  # at the file, while the library takes its time to write it
_LOST = 1.0  # s to close a file that is known to be cut short
_VIEWER_MEMORY = "1GiB"  # of the server that keeps the run for a browser that opens late


class Outlet:
    """An open recording stream and the viewers it feeds.

    Args:
        sinks: where it goes.
        name: the recording's name in the viewer.
        blueprint: how the viewer shows it.
        announce: is told what the end waits for.

    Attributes:
        stream: the rerun recording stream.
        url: address of the web viewer, "" if none is served.

    Raises:
        UserError: a sink cannot be opened; those opened before are closed again.
    """

    def __init__(self, sinks: Sinks, name: str, blueprint: Any, announce: Announce = tell_nobody) -> None:
        sinks.check()
        self._announce = announce
        self.stream = rr.RecordingStream(APPLICATION)
        self.url = ""
        self._live = sinks.live
        self._file: RecordingFile | None = None
        self._viewer: subprocess.Popen[bytes] | None = None
        self._page: WebPage | None = None
        self._data_port = 0
        self._closed = False
        try:
            targets = self._open(sinks)
            if targets:
                self._set_sinks(targets, sinks, blueprint)
            self.stream.send_recording_name(name)
        except BaseException:
            self.close()
            raise

    @property
    def trouble(self) -> str:
        """What is wrong with the file, "" while nothing is."""
        return self._file.trouble if self._file is not None else ""

    @property
    def deleted(self) -> bool:
        """Whether nobody can open the file any more."""
        return self._file is not None and self._file.deleted

    def settle(self) -> bool:
        """Return whether the file has got something since the last time; True if there is no file.

        Without a live view it then has everything. A viewer that hangs is not waited for, nor a file that takes nothing
        more: the library may be silent about that.
        """
        got = self._file is None
        for _ in range(_LOOKS):
            written = self._live or bool(self.trouble) or self._written(FLUSH_TIMEOUT / _LOOKS)
            if self._file is not None:
                got = self._file.check() or got
            if written:
                break
        return got

    def _written(self, patience: float) -> bool:
        """Return whether the library has written everything within some time [s]."""
        try:
            self.stream.flush(timeout_sec=patience)
        except RuntimeError:  # the file tells why
            return False
        return True

    def close(self) -> bool:
        """Write out everything and close; the native viewer stays open. Return whether the file has all of it."""
        if self._closed:
            return False
        self._closed = True
        with self._patience("hand the rest to whoever watches"):
            if self._live or not self.trouble:
                self.stream.flush(timeout_sec=FLUSH_TIMEOUT)
        if self._page is not None:
            self._announce("let browsers take the rest", LONGEST)
            wait_until_taken(self._data_port)
        with self._patience("close the file"):
            self._disconnect()
        if self._page is not None:
            self._page.close()
        if self._file is None:
            return True
        whole = self._file.check_end()
        self._file.close()
        return whole

    def _disconnect(self) -> None:
        """Close the stream; where its file could not be written the library may never come back."""

        def close() -> None:
            with contextlib.suppress(RuntimeError):
                self.stream.disconnect()

        closing = threading.Thread(target=close, name="closing", daemon=True)
        closing.start()
        closing.join(_LOST if self.trouble else None)

    @contextlib.contextmanager
    def _patience(self, what: str) -> Iterator[None]:
        """Wait for the native viewer, but not for ever: one that hangs is ended, or the run would not end either."""
        self._announce(what, FLUSH_TIMEOUT)
        timer = threading.Timer(FLUSH_TIMEOUT, self._end_viewer)
        timer.start()
        try:
            with contextlib.suppress(RuntimeError):  # a viewer that was closed; of the file, it tells itself
                yield
        finally:
            timer.cancel()

    def _open(self, sinks: Sinks) -> list[Any]:
        targets: list[Any] = []
        if sinks.file is not None:
            self._file = RecordingFile(sinks.file)
            targets.append(rr.FileSink(sinks.file))
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
        return targets

    def _set_sinks(self, targets: list[Any], sinks: Sinks, blueprint: Any) -> None:
        try:
            self.stream.set_sinks(*targets, default_blueprint=blueprint)
        except RuntimeError as error:
            raise UserError(f"the recording cannot be opened: {error}", hint=f"asked for: {sinks}") from error

    def _end_viewer(self) -> None:
        if self._viewer is not None and self._viewer.poll() is None:
            _log.warning("the viewer did not take the recording's end within %g s and was ended", FLUSH_TIMEOUT)
            self._viewer.kill()
