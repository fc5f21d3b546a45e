"""Realtime mode as decision sees it: the same few calls as lockstep, answered by other processes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections import deque
from collections.abc import Mapping
from pathlib import Path

import mujoco

from humanoid_bt.clock import DECISION_PERIOD
from humanoid_bt.control.supervisor import Stop
from humanoid_bt.errors import HumanoidBtError
from humanoid_bt.link.estop import EStop
from humanoid_bt.link.ring import RingReader
from humanoid_bt.link.run_folder import RunFolder, RunInfo, clean_stale
from humanoid_bt.link.wire import (
    Event,
    decode_event,
    decode_percepts,
    decode_state,
    encode_command,
    encode_event,
)
from humanoid_bt.messages import Command, Mode, Percept, State
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.robot_model import RobotModel
from humanoid_bt.plant.scene import Scene
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.channels import RunSpec
from humanoid_bt.realtime.schedule import Schedule, last_core
from humanoid_bt.realtime.timing import Timing

HOLD_TIME = 10.0
"""How long control goes on balancing the robot after decision died [s]."""

_START_TIMEOUT = 30.0  # s until the first state must be there
_SILENCE = 1.0  # s without a new state after which control counts as lost
_END_TIMEOUT = 5.0  # s that a process gets to end by itself


class StateClock:
    """The engine's clock as decision knows it: the time of the state that the tick sees."""

    def __init__(self) -> None:
        self.time = 0.0

    def now(self) -> float:
        """Return the engine's time [s]."""
        return self.time


class RemoteSupervisor:
    """What decision knows of the supervisor in the control process.

    Attributes:
        stops: every stop so far.
        rejected: commands that were refused so far, as text.
        estop: decision's end of the e-stop, once the run has started.
    """

    def __init__(self) -> None:
        self.stops: list[Stop] = []
        self.rejected: list[str] = []
        self._mode, self._reason = Mode.RUN, ""
        self._pending: deque[tuple[str, str]] = deque()
        self.estop: EStop | None = None

    def raise_estop(self, source: str, reason: str) -> None:
        """Raise the emergency stop."""
        if self.estop is not None:
            self.estop.raise_(source, reason)

    def request_stop(self, source: str, reason: str) -> None:
        """Ask for a protective stop until the end of the run."""
        self._pending.append((source, reason))

    def take_requests(self) -> list[tuple[str, str]]:
        """Return the requests that control does not know yet."""
        taken = list(self._pending)
        self._pending.clear()
        return taken

    def follow(self, state: State) -> None:
        """Note a stop that a state tells of."""
        if state.mode is not Mode.RUN and (state.mode, state.stop_reason) != (self._mode, self._reason):
            stop = Stop(state.time, state.mode, state.stop_reason, state.stop_source, dict(state.command_sources))
            self.stops.append(stop)
        self._mode, self._reason = state.mode, state.stop_reason


class Realtime:
    """A robot in a scene whose control and perception run in processes of their own.

    Args:
        robot: the robot.
        scene: what surrounds it.
        tree: name of the tree, for ``humanoid-bt status``.
        log: file in which control notes what happens.

    Attributes:
        clock: the engine's clock.
        model: MuJoCo's, of the whole scene.
        supervisor: what is known of the supervisor.
        notices: what happened in other processes so far: (time [s], level, text).
        external_force_max: largest external force on any body; known after :meth:`close`.
    """

    def __init__(self, robot: RobotModel, scene: Scene, tree: str, log: Path | None) -> None:
        self.robot, self.scene = robot, scene
        self.clock = StateClock()
        self.model: mujoco.MjModel = MujocoPlant(robot, scene).model
        self.supervisor = RemoteSupervisor()
        self.notices: list[Event] = []
        self.external_force_max = 0.0
        self.timing = Timing()
        self._tree, self._log = tree, log
        self._folder: RunFolder | None = None
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        self._percepts: dict[str, Percept] = {}
        self._read: dict[str, int] = dict.fromkeys(("state", "notice", "refusal", "percept"), 0)
        self._state: State | None = None
        self._state_at = 0.0

    # ---- life -------------------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Start the other processes and wait until the robot stands.

        Raises:
            HumanoidBtError: control did not come up.
        """
        clean_stale()
        config = self.robot.config
        folder = self._folder = RunFolder.create(RunInfo(self._tree, config.name))
        log = str(self._log.resolve()) if self._log else ""
        spec = RunSpec(
            str(config.path.resolve()),
            str(self.scene.config.path.resolve()),
            self.scene.seed,
            last_core(),
            log,
            HOLD_TIME,
        )
        spec.write(folder)
        channels.create_channels(folder)
        self._commands, self._requests = channels.writer(folder, "command"), channels.writer(folder, "request")
        self.supervisor.estop = channels.estop(folder)
        self._status = channels.writer(folder, "status")
        self._readers: dict[str, RingReader] = {
            name: channels.reader(folder, name) for name in ("state", "notice", "refusal", "percept", "timing")
        }
        self._spawn("control", "humanoid_bt.realtime.control_process")
        deadline = time.monotonic() + _START_TIMEOUT
        while self._readers["state"].latest() is None:
            self._check_control()
            if time.monotonic() > deadline:
                raise HumanoidBtError(f"the control process did not start within {_START_TIMEOUT:g} s")
            time.sleep(0.005)
        self._spawn("perception", "humanoid_bt.realtime.perception_process")
        self._schedule = Schedule(DECISION_PERIOD, spin=False)
        self._state_at = time.monotonic()

    def _spawn(self, role: str, module: str) -> None:
        assert self._folder is not None
        environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", module, str(self._folder.folder)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            env=environment,
            start_new_session=True,
        )
        self._processes[role] = process
        self._folder.register(role, process.pid)

    def close(self) -> None:
        """End the other processes and remove everything they shared."""
        folder = self._folder
        if folder is None:
            return
        self._folder = None
        channels.quit_flag(folder).beat()
        for process in self._processes.values():
            try:
                process.wait(_END_TIMEOUT)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self._follow_readers()
        result = folder.path("result.json")
        if result.is_file():
            self.external_force_max = json.loads(result.read_text(encoding="utf-8"))["external_force_max"]
        folder.close()

    # ---- the loop ---------------------------------------------------------------------------------------------------

    def sense(self) -> tuple[State, dict[str, Percept]]:
        """Wait for the next tick; return the latest state and percepts.

        Raises:
            HumanoidBtError: control is gone.
        """
        self._schedule.wait()
        self._follow_readers()
        self._check_control()
        perception = self._processes["perception"]
        if perception.poll() is not None and not any("perception process" in n.text for n in self.notices):
            text = f"the perception process ended ({_how(perception.returncode)})"
            self.notices.append(Event(self.clock.now(), "error", text))
        if time.monotonic() - self._state_at > _SILENCE:
            raise HumanoidBtError(f"control has been silent for more than {_SILENCE:g} s")
        assert self._state is not None
        self.clock.time = self._state.time
        return self._state, dict(self._percepts)

    def advance(self, command: Command | None) -> None:
        """Give a command to control. It counts as decision's sign of life, so it comes after a whole tick."""
        for source, reason in self.supervisor.take_requests():
            self._requests.write(encode_event(Event(self.clock.now(), "error", f"{source}: {reason}")))
        if command is not None:
            self._commands.write(encode_command(command))

    def publish(self, status: Mapping[str, object]) -> None:
        """Tell ``humanoid-bt status`` what the tree does."""
        self._status.write(json.dumps(status).encode()[:8000])

    def _follow_readers(self) -> None:
        for payload in self._new("state"):
            self._state = decode_state(payload)
            self._state_at = time.monotonic()
            self.supervisor.follow(self._state)
        for payload in self._new("percept"):
            for percept in decode_percepts(payload):
                self._percepts[percept.name] = percept
        self.notices += [decode_event(payload) for payload in self._new("notice")]
        self.supervisor.rejected += [payload.decode(errors="replace") for payload in self._new("refusal")]
        latest = self._readers["timing"].latest()
        if latest is not None:
            self.timing = Timing.from_bytes(latest[1])

    def _new(self, name: str) -> list[bytes]:
        entries, _ = self._readers[name].since(self._read[name])
        if entries:
            self._read[name] = entries[-1][0]
        return [payload for _, payload in entries]

    def _check_control(self) -> None:
        code = self._processes["control"].poll()
        if code is not None:
            raise HumanoidBtError(f"the control process ended ({_how(code)})")


def _how(code: int) -> str:
    return f"killed by signal {-code}" if code < 0 else f"exit code {code}"
