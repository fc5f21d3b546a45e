"""Runs whose robot is in another process, over UDP on the wall clock."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from humanoid_bt.cli import main
from humanoid_bt.core.messages import Mode
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.realtime.status import status_of
from humanoid_bt.session.report import ExitCode
from humanoid_bt.testing.check_plant import check_plant
from tests.realtime.helpers import PROGRAM, Live, command, environment, until

pytestmark = pytest.mark.realtime


class Served:
    """A plant in a process of its own."""

    def __init__(self, output: Path, *arguments: str) -> None:
        self._output = output
        with output.open("w") as file:
            self.process = subprocess.Popen(arguments, env=environment(), stdout=file, stderr=subprocess.STDOUT)

    @property
    def output(self) -> str:
        return self._output.read_text(encoding="utf-8")

    def said(self, text: str) -> None:
        until(f"{text!r} in {self.output}", lambda: text in self.output)


@pytest.fixture
def port() -> int:
    """A port that nobody listens at."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


@pytest.fixture
def serve(tmp_path: Path, port: int) -> Iterator[Callable[..., Served]]:
    """Serve a plant at the port; it ends with the test."""
    started: list[Served] = []

    def start(*options: str, program: tuple[str, ...] = (*PROGRAM, "plant", "humanoid")) -> Served:
        given = ("--listen", f"127.0.0.1:{port}", *options) if program[-1] == "humanoid" else options
        started.append(Served(tmp_path / f"plant{len(started)}.txt", *program, *given))
        return started[-1]

    yield start
    for served in started:
        served.process.kill()
        served.process.wait()


def test_a_robot_in_another_process_is_driven_and_a_pulled_cable_stops_both(
    serve: Callable[..., Served], live: Callable[..., Live], port: int
) -> None:
    plant = serve("--latency", "1ms", "--jitter", "1ms", "--loss", "1")
    plant.said("waits for a driver")
    run = live("stand", "--plant", f"udp://127.0.0.1:{port}")
    until("that the tree is ticked", lambda: status_of(run.folder, run.folder.info).tick_rate is not None)
    assert run.state.mode is Mode.RUN
    plant.process.send_signal(signal.SIGSTOP)
    run.process.wait(30)
    plant.process.send_signal(signal.SIGCONT)
    plant.said("left: the plant holds its last position")
    assert run.process.returncode == ExitCode.ERROR
    assert "the plant is silent for more than 20 ms" in run.output
    lost = f"■ the plant is lost: the plant at udp://127.0.0.1:{port} is silent"
    assert run.output.count(lost) == 1, run.output


def test_a_second_plant_at_one_port_is_refused_before_anything_is_loaded(
    port: int, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as another:
        another.bind(("127.0.0.1", port))
        assert main(("plant", "no robot of this name", "--listen", f"127.0.0.1:{port}")) == ExitCode.USAGE
    assert f"another plant, or another program, listens at udp://127.0.0.1:{port}" in capsys.readouterr().err


@pytest.mark.trials
def test_a_second_run_at_one_plant_is_refused(
    serve: Callable[..., Served], live: Callable[..., Live], port: int
) -> None:
    serve().said("waits for a driver")
    run = live("stand", "--plant", f"udp://127.0.0.1:{port}", "--duration", "60")
    second = command("run", "stand", "--plant", f"udp://127.0.0.1:{port}", "--no-record", "--no-view")
    assert second.returncode == ExitCode.USAGE
    assert "drives this plant since" in second.stderr
    assert "Traceback" not in second.stderr
    assert run.process.poll() is None
    assert "plant" not in run.state.stop_reason  # decision may be late: another run has just begun


@pytest.mark.trials
def test_control_that_dies_leaves_a_plant_in_its_safe_state(
    serve: Callable[..., Served], live: Callable[..., Live], port: int
) -> None:
    plant = serve("--safe", "damp")
    plant.said("waits for a driver")
    run = live("stand", "--plant", f"udp://127.0.0.1:{port}")
    until("that it stands", lambda: run.state.time > 0.5)
    run.kill("control", signal.SIGKILL)
    plant.said("no command for 20 ms: the plant lets go, and only brakes")
    plant.said("was silent for 100 ms")


BACK = "format: 1\nroot: {emergency_stop: {force_success: {timeout: {duration: 3 s, step_back: {distance: 32 cm}}}}}\n"
WALL = """
format: 1
name: room
objects:
  wall: {shape: box, size: [0.1, 2, 1], solid: true, position: [-0.45, 0, 0.5]}
"""


@pytest.mark.trials
def test_the_report_names_what_a_simulated_robot_bumped_into(
    serve: Callable[..., Served], live: Callable[..., Live], port: int, tmp_path: Path
) -> None:
    for name, text in {"trees/back.yaml": BACK, "sim/scenes/room.yaml": WALL}.items():
        (tmp_path / name).parent.mkdir(parents=True)
        (tmp_path / name).write_text(text)
    serve("--scene", "room", "--workspace", str(tmp_path)).said("waits for a driver")
    where = "--workspace", str(tmp_path), "--scene", "room"
    run = live("back", "--plant", f"udp://127.0.0.1:{port}", *where, wait=False)
    run.process.wait(60)
    touch = run.report["touches"][0]
    assert (touch["thing"], touch["meant"]) == ("wall", False)
    (told,) = (
        one for one in run.report["events"] if one["text"].endswith(f"{touch['link'].replace('_', ' ')} touches wall")
    )
    assert abs(told["time"] - touch["time"]) < 0.5
    assert "bumped" in run.output


@pytest.mark.trials
def test_a_robot_of_which_nobody_knows_the_truth_is_driven_too(
    serve: Callable[..., Served], live: Callable[..., Live], port: int
) -> None:
    serve(str(port), program=(sys.executable, "-m", "tests.cable.real_robot"))
    run = live("stand", "--plant", f"udp://127.0.0.1:{port}", "--scene", "ball_on_stand", "--duration", "1")
    run.process.wait(30)
    assert run.state.mode is Mode.RUN
    assert run.report["odometry"] is None
    assert "the percept source 'tracker' sees only what is simulated: a real robot needs other" in run.output


@pytest.mark.trials
def test_the_served_simulation_passes_the_conformance_test(serve: Callable[..., Served], port: int) -> None:
    plant = serve()
    plant.said("waits for a driver")
    robot = Workspace(builtin_root()).find_robot("humanoid")
    tries = (check_plant(f"udp://127.0.0.1:{port}", Path(robot)) for _ in range(5))
    assert any(check.passed for check in tries)  # a busy machine stands still for 100 ms now and then
