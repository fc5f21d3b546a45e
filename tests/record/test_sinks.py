"""Bad sinks are one clear message; good ones work together."""

from __future__ import annotations

import errno
import re
import socket
import subprocess
import sys
import urllib.request
from collections.abc import Callable
from pathlib import Path
from subprocess import PIPE
from typing import NoReturn

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.record import sinks, viewers
from humanoid_bt.record.recorder import Recorder
from humanoid_bt.record.sinks import Sinks
from tests.record.helpers import events
from tests.record.relay import Relay


def test_a_missing_folder_is_named_with_the_remedy(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"(?s)folder .*nowhere.* is missing.*mkdir -p"):
        Sinks(tmp_path / "nowhere" / "run.rrd").check()


def test_a_folder_is_not_a_recording(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="is a folder"):
        Sinks(tmp_path).check()


@pytest.mark.parametrize("number", ["001", "002", "1000"])
def test_the_name_of_a_part_is_refused_for_its_recording_would_overwrite_others(tmp_path: Path, number: str) -> None:
    with pytest.raises(UserError, match=r"(?s)has the name of a part of '.*run\.rrd'.*such as run-2\.rrd"):
        Sinks(tmp_path / f"run.part{number}.rrd").check()
    Sinks(tmp_path / "run.part1.rrd").check()


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


def test_the_page_sends_a_browser_nowhere_else(record: Callable[..., Recorder]) -> None:
    port = free_pair()
    with record(sinks=Sinks(serve=port)) as recorder, urllib.request.urlopen(recorder.url) as page:
        text, policy = page.read().decode(), page.headers["Content-Security-Policy"]
    assert not re.search(r"<link[^>]*//", text)
    rules = dict(rule.split(" ", 1) for rule in policy.split("; "))
    assert rules["default-src"] == "'self'"
    assert rules["connect-src"].split()[-1] == f"http://127.0.0.1:{port + 1}"
    assert "http" not in policy.replace(f"http://127.0.0.1:{port + 1}", "")


def test_the_viewers_program_reports_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It writes down who it is about to report on before it does."""
    for variable in ("XDG_CONFIG_HOME", "XDG_DATA_HOME", "CI"):
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    assert b"re_viewer.js" in viewers.page_files()["/"][1]
    assert [path for path in tmp_path.rglob("*") if "analytics" in path.name] == []


_RUN = """
import random, sys
import rerun as rr
from humanoid_bt.record import viewers
from humanoid_bt.record.outlet import Outlet
from humanoid_bt.record.sinks import Sinks

outlet = Outlet(Sinks(serve=int(sys.argv[1])), "run", None)
letters = random.Random(0)
for _ in range(100):
    outlet.stream.log("events", rr.TextLog(letters.randbytes(100_000).hex(), level="INFO"))
outlet._watched.flush()
print("recorded", flush=True)
sys.stdin.readline()
outlet.stream.log("events", rr.TextLog("the tree ended", level="INFO"))

look = viewers._on_the_way
viewers._on_the_way = lambda port: print("waits", flush=True) or look(port)
outlet.close()
"""


@pytest.mark.trials
@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not say what is on the way to a browser")
def test_who_is_slow_gets_the_end_of_the_run_too(tmp_path: Path, request: pytest.FixtureRequest) -> None:
    """Nothing moves before the run waits for it, or is over."""
    port, received = free_pair(), tmp_path / "received.rrd"
    with subprocess.Popen([sys.executable, "-c", _RUN, str(port)], stdin=PIPE, stdout=PIPE, text=True) as run:
        request.addfinalizer(run.kill)
        assert run.stdin is not None
        assert run.stdout is not None
        assert run.stdout.readline() == "recorded\n"
        with Relay(port + 1, first=1 << 16) as relay:
            source = f"rerun+http://127.0.0.1:{relay.port}/proxy"
            options = ["--save", str(received), "--bind", "127.0.0.1", "--port", str(viewers.free_port())]
            browser = subprocess.Popen([viewers._rerun_program(), *options, source], stderr=subprocess.DEVNULL)
            request.addfinalizer(browser.kill)
            assert relay.reached.wait(30)
            print(file=run.stdin, flush=True)
            run.stdout.readline()
            relay.opened.set()
            assert browser.wait(30) == 0
    found = [text for _, _, text in events(received)]
    assert (len(found), found[-1]) == (101, "the tree ended")


TAKES_NOTHING = """
import os, resource
from pathlib import Path
from humanoid_bt.record.outlet import Outlet
from humanoid_bt.record.sinks import Sinks

outlet, waited = Outlet(Sinks(Path("run.rrd")), "run", None), []
resource.setrlimit(resource.RLIMIT_FSIZE, (1, 1))

def silent(timeout_sec):
    waited.append(timeout_sec)
    raise RuntimeError("Flush timed out - not all log messages were sent")

outlet._file._stream.flush = silent
for _ in range(3):
    outlet.settle()
print(outlet.close(), sum(waited), outlet.trouble, flush=True)
os._exit(0)  # as the recorder's process: the library waits for its threads
"""


def test_a_file_that_takes_nothing_more_is_hardly_waited_for(tmp_path: Path) -> None:
    """The library tells that it cannot write, or says nothing any more: that depends on its threads."""
    told = subprocess.check_output([sys.executable, "-c", TAKES_NOTHING], cwd=tmp_path, text=True, timeout=60)
    closed, waited, trouble = told.strip().split(" ", 2)
    assert closed == "False" and 0 < float(waited) <= 1.0
    assert trouble.endswith("files may have 1 bytes at most here (ulimit -f)")


def test_nobody_is_waited_for_who_is_not_there() -> None:
    assert viewers._on_the_way(viewers.free_port()) is None


def test_importing_the_package_does_not_import_the_viewer() -> None:
    program = "import sys, humanoid_bt; sys.exit('rerun' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0
