"""Where a recording goes: a file, a native viewer, a web viewer on this machine."""

from __future__ import annotations

import contextlib
import errno
import logging
import os
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.record.viewers import FLUSH_TIMEOUT, LOOPBACK, free_port, serve_web, start_viewer, wait_until_taken

_log = logging.getLogger(__name__)

APPLICATION = "humanoid_bt"

_VIEWER_MEMORY = "1GiB"  # of the server that keeps the run for a browser that opens late


@dataclass(frozen=True)
class Sinks:
    """Where a recording goes; any of them together.

    Attributes:
        file: the .rrd file to write, overwritten if it exists.
        view: open the native viewer on this machine's display.
        serve: serve the web viewer on this port of 127.0.0.1, and its data on the port after it.
    """

    file: Path | None = None
    view: bool = False
    serve: int | None = None

    @property
    def active(self) -> bool:
        """Whether anything is recorded or shown at all."""
        return self.file is not None or self.view or self.serve is not None

    def check(self) -> None:
        """Find out what would not work, before a run starts.

        Raises:
            UserError: no display, a port in use, a folder that cannot be written.
        """
        if self.file is not None:
            _check_file(self.file)
        if self.view:
            _check_display()
        if self.serve is not None:
            if not 1 <= self.serve <= 65534:
                raise UserError(f"port {self.serve} does not exist", hint="valid: 1024 to 65534")
            _check_port(self.serve)
            _check_port(self.serve + 1)


class Outlet:
    """An open recording stream and the viewers it feeds.

    Args:
        sinks: where it goes.
        name: the recording's name in the viewer.
        blueprint: how the viewer shows it.

    Attributes:
        stream: the rerun recording stream.
        url: address of the web viewer, "" if none is served.

    Raises:
        UserError: a sink cannot be opened; those opened before are closed again.
    """

    def __init__(self, sinks: Sinks, name: str, blueprint: Any) -> None:
        import rerun as rr  # noqa: PLC0415  # it takes half a second, and most runs of a program record nothing

        sinks.check()
        self._rerun = rr
        self.stream = rr.RecordingStream(APPLICATION)
        self.url = ""
        self._viewer: subprocess.Popen[bytes] | None = None
        self._web: subprocess.Popen[bytes] | None = None
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

    def close(self) -> None:
        """Write out everything and close; the file is whole then. The native viewer stays open."""
        if self._closed:
            return
        self._closed = True
        with self._patience():
            self.stream.flush()
        if self._web is not None:
            wait_until_taken(self._data_port)
        with self._patience():
            self.stream.disconnect()
        if self._web is not None:
            if self._web.stdin is not None:
                self._web.stdin.close()
            self._web.wait()

    @contextlib.contextmanager
    def _patience(self) -> Iterator[None]:
        """Wait for the native viewer, but not for ever: one that hangs is ended, or the run would not end either."""
        timer = threading.Timer(FLUSH_TIMEOUT, self._end_viewer)
        timer.start()
        try:
            yield
        finally:
            timer.cancel()

    def _open(self, sinks: Sinks) -> list[Any]:
        targets: list[Any] = []
        if sinks.file is not None:
            targets.append(self._rerun.FileSink(sinks.file))
        if sinks.serve is not None:
            server = self._rerun.GrpcServerSink(LOOPBACK, sinks.serve + 1, server_memory_limit=_VIEWER_MEMORY)
            targets.append(server)
            source = f"rerun+http://{LOOPBACK}:{sinks.serve + 1}/proxy"
            self._web, self._data_port = serve_web(sinks.serve, source), sinks.serve + 1
            self.url = f"http://{LOOPBACK}:{sinks.serve}?url={quote(source, safe='')}"
        if sinks.view:
            port = free_port()
            self._viewer = start_viewer(port)
            targets.append(self._rerun.GrpcSink(f"rerun+http://{LOOPBACK}:{port}/proxy"))
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


def _check_file(path: Path) -> None:
    folder = path.parent
    shown = relative(path)
    if path.is_dir():
        raise UserError(f"the recording {shown!r} is a folder", hint="valid: a file name, such as run.rrd")
    if not folder.is_dir():
        raise UserError(f"the recording's folder {relative(folder)!r} is missing", hint=f"mkdir -p {relative(folder)}")
    existed = path.exists()
    try:
        with path.open("ab"):
            pass
        if not existed:
            path.unlink()
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise UserError(
            f"the recording {shown!r} cannot be written: {reason}", hint="valid: a file in a folder that you may write"
        ) from error


def has_display() -> bool:
    """Return whether there is a display to open a viewer on."""
    return bool(sys.platform == "darwin" or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _check_display() -> None:
    if has_display():
        return
    raise UserError(
        "no display to open the viewer on (neither DISPLAY nor WAYLAND_DISPLAY is set)",
        hint="use --serve to watch in a browser, or open the recording later with: rerun FILE",
    )


def _check_port(port: int) -> None:
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((LOOPBACK, port))
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                raise UserError(
                    f"port {port} is in use on {LOOPBACK}",
                    hint="the web viewer needs a free port and the one after it: choose another, such as --serve 9190",
                ) from error
            raise UserError(f"port {port} cannot be used: {error.strerror}", hint="valid: 1024 to 65534") from error
