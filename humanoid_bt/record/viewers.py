"""The viewer's programs on this machine: a window, a page for browsers, and whether they have taken everything."""

from __future__ import annotations

import contextlib
import importlib.util
import logging
import socket
import subprocess
import tempfile
import time
from pathlib import Path
from typing import IO

from humanoid_bt.core.errors import UserError

_log = logging.getLogger(__name__)

LOOPBACK = "127.0.0.1"
FLUSH_TIMEOUT = 5.0
"""What a live viewer gets at the end to take the rest, or a browser to take anything [s]."""

_START_TIMEOUT = 20.0  # a viewer is up in 1 s; a cold disk takes longer [s]
_SCREEN_TIME = 0.5  # a viewer without a screen is gone by then [s]
_QUIET = 0.3  # a browser for which nothing has been on the way for this long has everything [s]
_LONGEST = 30.0  # what a slow browser gets at most, as long as it goes on taking something [s]
_POLL = 0.05  # time between two looks at what is on the way [s]
_ESTABLISHED = "01"

_WITH_PARENT = 'exec 3<&0; (read -r _ <&3; kill $$) & exec "$@" </dev/null 3<&-'
"""Shell: run a program, and end it at the end of input, which comes when the parent closes its end or dies."""


def free_port() -> int:
    """Return a port that nobody uses."""
    with socket.socket() as probe:
        probe.bind((LOOPBACK, 0))
        return int(probe.getsockname()[1])


def _rerun_program() -> str:
    """Return the viewer's program, which the rerun package brings along."""
    package = importlib.util.find_spec("rerun_cli")
    if package is None or not package.submodule_search_locations:
        raise UserError("the viewer's program is missing", hint="pip install rerun-sdk brings it along")
    return str(Path(package.submodule_search_locations[0]) / "rerun")


def start_viewer(port: int) -> subprocess.Popen[bytes]:
    """Open the native viewer; it listens on loopback only and outlives this program."""
    options = ["--bind", LOOPBACK, "--port", str(port), "--hide-welcome-screen", "--expect-data-soon"]
    with tempfile.TemporaryFile() as messages:
        viewer = subprocess.Popen(
            [_rerun_program(), *options],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=messages,
            start_new_session=True,  # Ctrl-C ends the run, not the viewer
        )
        _wait_until_open(viewer, port, "the viewer", messages)
        with contextlib.suppress(subprocess.TimeoutExpired):  # it listens before it finds that it has no screen
            viewer.wait(_SCREEN_TIME)
            raise _not_started("the viewer", messages)
    return viewer


def serve_web(port: int, source: str) -> subprocess.Popen[bytes]:
    """Serve the web viewer on loopback (rerun's own function for it listens on every interface).

    It ends with this program, also when this program is killed.
    """
    options = ["--serve-web", "--bind", LOOPBACK, "--web-viewer-port", str(port), source]
    with tempfile.TemporaryFile() as messages:
        web = subprocess.Popen(
            ["/bin/sh", "-c", _WITH_PARENT, "sh", _rerun_program(), *options],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=messages,
            start_new_session=True,
        )
        try:
            _wait_until_open(web, port, "the web viewer", messages)
        except BaseException:
            web.communicate()
            raise
    return web


def wait_until_taken(port: int) -> None:
    """Wait until browsers have taken what the server of this process has for them, which drops the rest as it closes.

    The server says nothing about that, but the system knows what is on the way on this machine's connections.
    """
    begun = quiet = moved = time.monotonic()
    before = 0
    while (held := _on_the_way(port)) is not None:
        now = time.monotonic()
        if held:
            quiet = now
        if held != before:
            moved, before = now, held
        if now - quiet >= _QUIET:
            return
        if now - moved >= FLUSH_TIMEOUT or now - begun >= _LONGEST:
            _log.warning("a browser did not take the recording's end within %.0f s", now - begun)
            return
        time.sleep(_POLL)


def _on_the_way(port: int) -> int | None:
    """Return the bytes that connections to a port of this machine hold, None if there are no connections."""
    try:
        rows = [line.split() for line in Path("/proc/net/tcp").read_text().splitlines()[1:]]
    except OSError:  # not Linux: the wait is all there is
        return 0
    held = None
    for _, local, remote, state, queues, *_ in rows:
        sent, received = (int(queue, 16) for queue in queues.split(":"))
        if state == _ESTABLISHED and local.endswith(f":{port:04X}"):
            held = (held or 0) + sent
        elif state == _ESTABLISHED and remote.endswith(f":{port:04X}"):
            held = (held or 0) + received
    return held


def _wait_until_open(process: subprocess.Popen[bytes], port: int, what: str, messages: IO[bytes]) -> None:
    deadline = time.monotonic() + _START_TIMEOUT
    while time.monotonic() < deadline:
        with contextlib.suppress(OSError), socket.create_connection((LOOPBACK, port), timeout=0.2):
            return
        if process.poll() is not None:
            break
        time.sleep(0.05)
    if process.stdin is None:
        process.kill()
    raise _not_started(what, messages)


def _not_started(what: str, messages: IO[bytes]) -> UserError:
    messages.seek(0)
    lines = messages.read().decode(errors="replace").strip().splitlines()
    reason = lines[-1] if lines else "it said nothing"
    return UserError(f"{what} did not start: {reason}", hint="without it: --record FILE, and open it with: rerun FILE")
