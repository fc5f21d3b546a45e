"""What the realtime bench measures: the real control and perception processes, with stand-ins for decision."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from types import TracebackType
from typing import Self

from humanoid_bt.bench.stand_ins import SPOIL
from humanoid_bt.core.errors import HumanoidBtError
from humanoid_bt.core.messages import Mode, State
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.link.run_folder import RunFolder, RunInfo, clean_stale
from humanoid_bt.link.wire import decode_event, decode_percepts, decode_state
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.channels import RunSpec
from humanoid_bt.realtime.schedule import last_core
from humanoid_bt.realtime.timing import StopRecord, Timing, Wake

_ROBOT, _SCENE = "humanoid", "ball_on_stand"
_HOLD = 1.0  # s that control goes on if the bench dies
_POLL = 0.001  # s; control's own time stamps are what counts
_START_TIMEOUT, _TIMEOUT = 60.0, 10.0  # s; generous, because every core may be busy
_END_TIMEOUT = 5.0  # s that a process gets to end by itself
_STAND_TIMEOUT = 1.5  # s that the robot gets to finish its step
_COLLECT_PERIOD = 0.2  # s between two looks at the wake-ups: their ring holds 4 s


class Subject:
    """A robot under real control, whose other processes can be harmed one by one."""

    def __init__(self) -> None:
        workspace = Workspace(builtin_root())
        robot, scene = workspace.find_robot(_ROBOT), workspace.find_scene(_SCENE)
        self._spec = RunSpec(
            robot=str(robot.resolve()),
            scene=str(scene.resolve()),
            seed=0,
            core=last_core(),
            log="",
            hold=_HOLD,
            parent=os.getpid(),
        )
        self._folder: RunFolder | None = None
        self._processes: dict[str, subprocess.Popen[str]] = {}

    # ---- life -------------------------------------------------------------------------------------------------------

    def __enter__(self) -> Self:
        try:
            self._start()
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _start(self) -> None:
        clean_stale()
        folder = self._folder = RunFolder.create(RunInfo("bench", _ROBOT))
        self._spec.write(folder)
        channels.create_channels(folder)
        self._states, self._percepts = channels.reader(folder, "state"), channels.reader(folder, "percept")
        self._wakes, self._stops = channels.reader(folder, "wake"), channels.reader(folder, "stop")
        self._refusals, self._timing = channels.reader(folder, "refusal"), channels.reader(folder, "timing")
        self._notices, self._estop = channels.reader(folder, "notice"), channels.estop(folder)
        self._spawn("control", "humanoid_bt.realtime.control_process")
        self._wait(lambda: self._states.sequence > 0, _START_TIMEOUT, "control did not start")
        self.start_perception()
        self._spawn("estop", "humanoid_bt.bench.stand_ins", "estop")
        self.start_decision()

    def restart(self) -> None:
        """Begin anew, after a fall."""
        self.close()
        self._start()

    def close(self) -> None:
        """End every process and remove what they shared."""
        folder, self._folder = self._folder, None
        if folder is None:
            return
        try:
            channels.quit_flag(folder).beat()
            for role in ("estop", "decision", "perception"):
                self.kill(role)
            control = self._processes.get("control")
            if control is not None:
                with suppress(subprocess.TimeoutExpired):
                    control.wait(_END_TIMEOUT)
        finally:
            for role in list(self._processes):
                self.kill(role)
            folder.close()

    def _spawn(self, role: str, module: str, *arguments: str) -> None:
        assert self._folder is not None
        with self._folder.life(role) as life:
            process = subprocess.Popen(
                [sys.executable, "-P", "-m", module, *arguments, str(self._folder.folder)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
                env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
                pass_fds=(life,),
                start_new_session=True,
            )
        self._processes[role] = process
        self._folder.register(role, process.pid)

    # ---- harm and repair --------------------------------------------------------------------------------------------

    def kill(self, role: str) -> int:
        """Kill a process at once; return the monotonic time before [ns]."""
        process = self._processes.pop(role, None)
        began = time.monotonic_ns()
        if process is not None:
            process.kill()
            process.wait()
            for stream in (process.stdin, process.stdout):
                if stream is not None:
                    stream.close()
        return began

    def signal(self, role: str, number: signal.Signals) -> int:
        """Send a signal to a process; return the monotonic time before [ns]."""
        process = self._processes[role]
        began = time.monotonic_ns()
        process.send_signal(number)
        return began

    def start_decision(self) -> None:
        """Start a decision (the last one is gone), and wait until control follows it."""
        self._spawn("decision", "humanoid_bt.bench.stand_ins", "decision")
        self.wait_commanded()

    def start_perception(self) -> None:
        """Start perception (the last one is gone), and wait for a percept."""
        before = self._percepts.sequence
        self._spawn("perception", "humanoid_bt.realtime.perception_process")
        self._wait(lambda: self._percepts.sequence > before + 1, _START_TIMEOUT, "perception did not start")

    def raise_estop(self) -> int:
        """Let another process raise the e-stop; return the monotonic time before it did [ns]."""
        process = self._processes["estop"]
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write("\n")
        process.stdin.flush()
        answer = process.stdout.readline()
        if not answer:
            raise HumanoidBtError("the process that raises the e-stop ended")
        return int(answer)

    def reset(self) -> bool:
        """Clear the e-stop; return whether that was accepted, which it is not while the robot falls."""
        ticket = self._estop.request_reset("the bench")

        def answered() -> bool:
            self._estop.poll()
            return self._estop.answer_to(ticket) is not None

        self._wait(answered, _TIMEOUT, "control did not answer a reset")
        answer = self._estop.answer_to(ticket)
        return answer is not None and answer.accepted

    # ---- what is seen -----------------------------------------------------------------------------------------------

    @property
    def state(self) -> State:
        """The latest state."""
        latest = self._states.latest()
        assert latest is not None
        return decode_state(latest[1])

    @property
    def fifo(self) -> bool:
        """Whether control has realtime priority."""
        latest = self._timing.latest()
        return latest is not None and Timing.from_bytes(latest[1]).fifo

    @property
    def stops(self) -> int:
        """Number of stops so far, to pass to :meth:`wait_stop`."""
        return self._stops.sequence

    @property
    def refusals(self) -> int:
        """Number of commands refused so far."""
        return self._refusals.sequence

    @property
    def stalls(self) -> list[str]:
        """What control said of its own stalls, the latest ones."""
        texts = [decode_event(payload).text for _, payload in self._notices.since(0)[0]]
        return [text for text in texts if "stalled" in text]

    def wait_stop(self, mode: Mode, after: int, timeout: float = 2.0) -> StopRecord | None:
        """Wait for a stop; return None if there was none.

        Args:
            mode: the kind of stop.
            after: number of stops before.
            timeout: [s].
        """
        found: list[StopRecord] = []

        def stopped() -> bool:
            records = (StopRecord.from_bytes(payload) for _, payload in self._stops.since(after)[0])
            found.extend(record for record in records if record.mode == mode.value)
            return bool(found)

        self._wait(stopped, timeout)
        return found[0] if found else None

    def wait_commanded(self) -> None:
        """Wait until the robot follows commands that came after this call."""
        before = self.state.command_sequence

        def commanded() -> bool:
            state = self.state
            return state.mode is Mode.DAMP or (state.mode is Mode.RUN and state.command_sequence > before + 1)

        self._wait(commanded, _TIMEOUT, "control did not follow commands")

    def wait_stand(self) -> bool:
        """Wait until the robot has finished its step; return whether it stands."""
        self._wait(lambda: self.state.base_settled or self.state.mode is Mode.DAMP, _STAND_TIMEOUT)
        return self.state.mode is not Mode.DAMP

    def percept_age(self) -> float:
        """Return how old the newest percept is, as a tree would see it [s]."""
        latest = self._percepts.latest()
        stamps = [percept.stamp for percept in decode_percepts(latest[1]).percepts] if latest else []
        return self.state.time - max(stamps, default=0.0)

    def collect(self, duration: float) -> list[Wake]:
        """Return the servo's wake-ups of a time from now on [s]."""
        wakes: list[Wake] = []
        sequence, end = self._wakes.sequence, time.monotonic() + duration
        while True:
            left = end - time.monotonic()
            if left > 0:
                time.sleep(min(left, _COLLECT_PERIOD))
            entries, _ = self._wakes.since(sequence)
            if entries:
                sequence = entries[-1][0]
            wakes += [Wake.from_bytes(payload) for _, payload in entries]
            if left <= 0:
                return wakes

    def _wait(self, done: Callable[[], bool], timeout: float, problem: str = "") -> None:
        """Wait until something is so; give up after a time [s], with an error if a problem is given."""
        end = time.monotonic() + timeout
        while not done():
            control = self._processes["control"]
            if control.poll() is not None:
                raise HumanoidBtError(f"the control process ended with code {control.returncode}")
            if time.monotonic() > end:
                if problem:
                    raise HumanoidBtError(f"{problem} within {timeout:g} s")
                return
            time.sleep(_POLL)


def spoil(subject: Subject) -> int:
    """Let decision send NaN, or good commands again; return the monotonic time before [ns]."""
    return subject.signal("decision", SPOIL)
