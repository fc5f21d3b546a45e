"""The viewer's programs on this machine: a window, what makes up the page for browsers, who has taken everything."""

from __future__ import annotations

import contextlib
import http.client
import importlib.util
import logging
import os
import socket
import subprocess
import tempfile
import time
from pathlib import Path
from typing import IO

from humanoid_bt.core.errors import UserError
from humanoid_bt.record.sinks import LOOPBACK

_log = logging.getLogger(__name__)

FLUSH_TIMEOUT = 5.0
"""What a live viewer gets at the end to take the rest, or a browser to take anything [s]."""

LONGEST = 30.0
"""What a slow browser gets at most, as long as it goes on taking something [s]."""

_START_TIMEOUT = 20.0  # a viewer is up in 1 s; a cold disk takes longer [s]
_SCREEN_TIME = 0.5  # a viewer without a screen is gone by then [s]
_QUIET = 0.3  # a browser for which nothing has been on the way for this long has everything [s]
_POLL = 0.05  # time between two looks at what is on the way [s]
_ESTABLISHED = "01"
_PAGE = ("/", "/favicon.ico", "/sw.js", "/re_viewer.js", "/re_viewer_bg.wasm")

_NOWHERE = f"http://{LOOPBACK}:9"  # nobody answers there
_QUIETLY = {
    "CI": "1",  # the viewer takes this for a test of its makers, and reports nothing to them
    **{name: _NOWHERE for proxy in ("HTTP_PROXY", "HTTPS_PROXY", "ALL_PROXY") for name in (proxy, proxy.lower())},
    "NO_PROXY": LOOPBACK,  # else it asks whether there is a newer one, and has no setting for that
}


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


def start_viewer(port: int, *files: Path) -> subprocess.Popen[bytes]:
    """Open the native viewer; it listens on loopback only and outlives this program.

    Args:
        port: at which it listens.
        files: recordings that it shows; data will be sent to it if there are none.
    """
    shows = [str(file.absolute()) for file in files] or ["--expect-data-soon"]
    options = ["--bind", LOOPBACK, "--port", str(port), "--hide-welcome-screen", *shows]
    with tempfile.TemporaryFile() as messages:
        viewer = _start(options, messages)
        _wait_until_open(viewer, port, "the viewer", messages)
        with contextlib.suppress(subprocess.TimeoutExpired):  # it listens before it finds that it has no screen
            viewer.wait(_SCREEN_TIME)
            raise _not_started("the viewer", messages)
    return viewer


def page_files() -> dict[str, tuple[str, bytes]]:
    """Return what the viewer's page for browsers is made of: path -> kind of content, and content.

    The program that has them serves them for a moment, to this one.
    """
    port = free_port()
    options = ["--serve-web", "--bind", LOOPBACK, "--web-viewer-port", str(port), "--port", str(free_port())]
    with tempfile.TemporaryFile() as messages:
        server = _start(options, messages)
        try:
            _wait_until_open(server, port, "the web viewer", messages)
            return {path: _fetched(port, path) for path in _PAGE}
        except (OSError, http.client.HTTPException) as error:
            raise _not_started(f"the web viewer ({error})", messages) from error
        finally:
            server.kill()
            server.wait()


def _fetched(port: int, path: str) -> tuple[str, bytes]:
    with contextlib.closing(http.client.HTTPConnection(LOOPBACK, port, timeout=_START_TIMEOUT)) as connection:
        connection.request("GET", path)
        answer = connection.getresponse()
        return answer.headers["Content-Type"], answer.read()


def _start(options: list[str], messages: IO[bytes]) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [_rerun_program(), *options],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=messages,
        env={**os.environ, **_QUIETLY},
        start_new_session=True,  # Ctrl-C ends the run, not the viewer
    )


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
        if now - moved >= FLUSH_TIMEOUT or now - begun >= LONGEST:
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
    process.kill()
    raise _not_started(what, messages)


def _not_started(what: str, messages: IO[bytes]) -> UserError:
    messages.seek(0)
    lines = messages.read().decode(errors="replace").strip().splitlines()
    reason = lines[-1] if lines else "it said nothing"
    return UserError(f"{what} did not start: {reason}", hint="without it: --record FILE, and open it with: rerun FILE")
