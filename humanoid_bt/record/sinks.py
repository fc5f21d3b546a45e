"""Where a recording goes, as it is asked for: a file, a native viewer, a web viewer on this machine."""

from __future__ import annotations

import errno
import os
import socket
import sys
from dataclasses import dataclass
from pathlib import Path

from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.record.folder_limits import FolderLimits
from humanoid_bt.record.parts import PART_SIZE, first_of

LOOPBACK = "127.0.0.1"


@dataclass(frozen=True)
class Sinks:
    """Where a recording goes; any of them together.

    Attributes:
        file: the .rrd file to write, overwritten if it exists.
        view: open the native viewer on this machine's display.
        serve: serve the web viewer on this port of 127.0.0.1, and its data on the port after it.
        part_size: bytes from which on the recording goes on in another file.
        limits: of the folder of the file, where older recordings make room; None for a file that somebody named.
    """

    file: Path | None = None
    view: bool = False
    serve: int | None = None
    part_size: float = PART_SIZE
    limits: FolderLimits | None = None

    @property
    def active(self) -> bool:
        """Whether anything is recorded or shown at all."""
        return self.file is not None or self.live

    @property
    def live(self) -> bool:
        """Whether anybody can watch."""
        return self.view or self.serve is not None

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


def _check_file(path: Path) -> None:
    folder = path.parent
    shown = relative(path)
    if (first := first_of(path)) != path:  # whose parts a recording of that name would overwrite
        hint = f"valid: a name that does not end with '.part' and a number, such as {first.stem}-2{path.suffix}"
        raise UserError(f"the recording {shown!r} has the name of a part of {relative(first)!r}", hint=hint)
    try:
        if path.is_dir():
            raise UserError(f"the recording {shown!r} is a folder", hint="valid: a file name, such as run.rrd")
        if not folder.is_dir():
            hint = f"mkdir -p {relative(folder)}"
            raise UserError(f"the recording's folder {relative(folder)!r} is missing", hint=hint)
        existed = path.exists()
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
