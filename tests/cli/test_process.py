"""The command line as a process of its own: signals, pipes, determinism, imports."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = [sys.executable, "-m", "humanoid_bt"]


def environment(**values: str) -> dict[str, str]:
    """Return an environment without a display."""
    kept = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    return kept | {"PYTHONIOENCODING": "utf-8"} | values


@pytest.mark.trials
def test_two_processes_give_the_same_trace(project: Path, tmp_path: Path) -> None:
    hashes = []
    for number in ("1", "2"):
        file = tmp_path / f"{number}.json"
        subprocess.run(
            [*PROGRAM, "run", "fetch", "--seed", "5", "--no-record", "--duration", "1.5", "--quiet", "--report", file],
            cwd=project,
            env=environment(PYTHONHASHSEED=number),
            check=False,
            capture_output=True,
        )
        hashes.append(json.loads(file.read_text(encoding="utf-8"))["trace_hash"])
    assert hashes[0] == hashes[1]


HEARS = """
import signal, sys
number = int(sys.argv.pop(1))  # which whoever runs the tests may ignore
signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)
from humanoid_bt.__main__ import main
sys.exit(main())
"""


@pytest.mark.parametrize(
    "number",
    [signal.SIGINT, *(pytest.param(number, marks=pytest.mark.trials) for number in (signal.SIGTERM, signal.SIGHUP))],
)
def test_a_signal_brings_the_robot_to_a_stand(number: signal.Signals, project: Path, tmp_path: Path) -> None:
    report, recording = tmp_path / "report.json", tmp_path / "run.rrd"
    process = subprocess.Popen(
        [
            sys.executable,
            "-c",
            HEARS,
            str(number),
            "run",
            "walk",
            "--pace",
            "2",
            "--report",
            report,
            "--record",
            recording,
        ],
        cwd=project,
        env=environment(PYTHONUNBUFFERED="1"),
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    for line in process.stdout:
        if "▶ walk" in line:
            break
    process.send_signal(number)
    rest = process.stdout.read()
    assert process.wait() == 130
    assert "○ walk halted: the run ended" in rest
    assert "the tree ended: interrupted; the robot comes to a stand, and another Ctrl-C does not wait for it" in rest
    assert "interrupted: " in rest
    assert json.loads(report.read_text(encoding="utf-8"))["outcome"] == "interrupted"
    assert recording.stat().st_size > 0


PRESSED = """
import signal, sys
class Press:
    module = sys.argv.pop()
    def find_spec(self, name, path=None, target=None):
        if name == self.module:
            signal.raise_signal(signal.SIGINT)
signal.signal(signal.SIGINT, signal.default_int_handler)  # what a shell starts in the background ignores it
sys.meta_path.insert(0, Press())
from humanoid_bt.__main__ import main
sys.exit(main())
"""

NOHUP = """
import signal, sys
from humanoid_bt.cli import main
signal.signal(signal.SIGHUP, signal.SIG_IGN)
from humanoid_bt.session.session import Session
run = Session.run
Session.run = lambda session, **how: (signal.raise_signal(signal.SIGHUP), run(session, **how))[1]
sys.exit(main())
"""


@pytest.mark.parametrize("module", ["humanoid_bt.cli", "numpy"])
def test_ctrl_c_while_the_program_starts_shows_no_traceback(module: str, project: Path) -> None:
    command = [sys.executable, "-c", PRESSED, "run", "wait", module]
    done = subprocess.run(command, cwd=project, env=environment(), capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "interrupted\n")


@pytest.mark.trials
def test_what_nohup_ignores_stays_ignored(project: Path) -> None:
    command = [sys.executable, "-c", NOHUP, "run", "wait", "--no-record", "--quiet"]
    done = subprocess.run(command, cwd=project, env=environment(), capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert "success: pause: waited" in done.stdout


def test_a_reader_that_leaves_does_not_stop_the_robot(project: Path, tmp_path: Path) -> None:
    report = tmp_path / "report.json"
    process = subprocess.Popen(
        [*PROGRAM, "run", "wait", "--no-record", "--report", report],
        cwd=project,
        env=environment(PYTHONUNBUFFERED="1"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None and process.stderr is not None
    process.stdout.readline()
    process.stdout.close()
    errors = process.stderr.read()
    process.stderr.close()
    assert process.wait() == 0
    assert errors == ""
    assert json.loads(report.read_text(encoding="utf-8"))["outcome"] == "success"


@pytest.mark.trials
def test_a_closed_output_does_no_harm(project: Path) -> None:
    command = f'exec "{sys.executable}" -m humanoid_bt run wait --no-record >&-'
    done = subprocess.run(
        ["/bin/sh", "-c", command], check=False, cwd=project, env=environment(), capture_output=True, text=True
    )
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
def test_an_output_that_is_full_is_told(project: Path) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [*PROGRAM, "show", "wait"],
            check=False,
            cwd=project,
            env=environment(),
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
        )
    assert done.returncode == 4
    assert done.stderr.startswith("error: the output could not be written: ")


def test_importing_the_package_imports_nothing_heavy() -> None:
    code = (
        "import sys, humanoid_bt, humanoid_bt.cli; "
        "print({'mujoco', 'mink', 'rerun', 'py_trees', 'numpy', 'rich', 'yaml'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
