"""Bad sinks are one clear message; good ones work together."""

from __future__ import annotations

import errno
import socket
import subprocess
import sys
import urllib.request
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.record import sinks
from humanoid_bt.record.recorder import Recorder
from humanoid_bt.record.sinks import Sinks
from tests.record.helpers import events


def test_a_missing_folder_is_named_with_the_remedy(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"(?s)folder .*nowhere.* is missing.*mkdir -p"):
        Sinks(tmp_path / "nowhere" / "run.rrd").check()


def test_a_folder_is_not_a_recording(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="is a folder"):
        Sinks(tmp_path).check()


def test_a_read_only_folder_is_named_with_the_reason(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> NoReturn:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)
    with pytest.raises(UserError, match=r"run\.rrd' cannot be written: Permission denied"):
        Sinks(tmp_path / "run.rrd").check()


def test_checking_leaves_no_file_and_keeps_an_old_one(tmp_path: Path) -> None:
    Sinks(tmp_path / "new.rrd").check()
    assert not (tmp_path / "new.rrd").exists()
    (tmp_path / "old.rrd").write_text("old")
    Sinks(tmp_path / "old.rrd").check()
    assert (tmp_path / "old.rrd").read_text() == "old"


def test_no_display_points_to_the_other_ways(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sinks.sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(UserError, match=r"(?s)no display.*--serve.*rerun FILE"):
        Sinks(view=True).check()


@pytest.mark.parametrize("variable", ["DISPLAY", "WAYLAND_DISPLAY"])
def test_a_display_is_enough(monkeypatch: pytest.MonkeyPatch, variable: str) -> None:
    monkeypatch.setenv(variable, ":0")
    Sinks(view=True).check()


@pytest.mark.parametrize("offset", [0, 1], ids=["viewer", "data"])
def test_a_port_in_use_is_named(offset: int) -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(UserError, match=f"port {port} is in use"):
            Sinks(serve=port - offset).check()


@pytest.mark.parametrize("port", [0, -1, 65535, 100000])
def test_a_port_that_cannot_be_is_refused(port: int) -> None:
    with pytest.raises(UserError, match="does not exist"):
        Sinks(serve=port).check()


def listens(address: str, port: int) -> bool:
    try:
        socket.create_connection((address, port), timeout=1.0).close()
    except OSError:
        return False
    return True


def free_pair() -> int:
    for port in range(20000, 30000, 2):
        try:
            Sinks(serve=port).check()
        except UserError:
            continue
        return port
    raise AssertionError("no free ports")


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have only one loopback address")
def test_the_web_viewer_is_served_on_loopback_only_and_ends_with_the_run(
    record: Callable[..., Recorder], tmp_path: Path
) -> None:
    port = free_pair()
    with record(sinks=Sinks(tmp_path / "run.rrd", serve=port)) as recorder:
        recorder.event(0.0, "info", "started")
        assert recorder.url.startswith(f"http://127.0.0.1:{port}?url=")
        with urllib.request.urlopen(recorder.url) as page:
            assert b"rerun" in page.read().lower()
        # Whoever binds all addresses also answers on the other loopback ones.
        for used in (port, port + 1):
            assert listens("127.0.0.1", used)
            assert not listens("127.0.0.2", used)
    assert not listens("127.0.0.1", port)
    assert events(tmp_path / "run.rrd") == [(0.0, "INFO", "started")]


def test_importing_the_package_does_not_import_the_viewer() -> None:
    program = "import sys, humanoid_bt; sys.exit('rerun' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0
