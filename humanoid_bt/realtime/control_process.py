"""The control process: the servo loop at 1 kHz on the wall clock, with whole-body control, supervisor and plant.

It goes on balancing the robot whatever becomes of the other processes, and imports nothing of trees or viewers.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import time
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import FrameType

from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.control.controller import Controller
from humanoid_bt.control.cycle_log import CycleLog, Layout
from humanoid_bt.control.supervisor import Stop
from humanoid_bt.core.clock import DECISION_PERIOD, ESTIMATE_PERIOD, SERVO_PERIOD, cycles
from humanoid_bt.core.errors import ControlLost, UserError
from humanoid_bt.core.messages import Gait, Mode
from humanoid_bt.link.run_folder import RunFolder
from humanoid_bt.link.table import TableWriter
from humanoid_bt.link.wire import (
    Event,
    WireError,
    decode_command,
    decode_event,
    encode_event,
    encode_state,
    encode_truth,
)
from humanoid_bt.link.wire.event import Level
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.channels import ABANDONED, RunSpec
from humanoid_bt.realtime.driven_plant import CablePlant, DrivenPlant, Simulation
from humanoid_bt.realtime.estop_follower import EStopFollower
from humanoid_bt.realtime.schedule import Schedule, claim
from humanoid_bt.realtime.timing import StopRecord, Stopwatch, Wake
from humanoid_bt.robot import mujoco_warnings

_STALL = 10  # servo cycles skipped in a row after which the others are forgiven a silence, because it was our own
_TIMING_PERIOD = 200  # servo cycles between two reports of the timing
_PARENT_PERIOD = 20  # servo cycles between two looks whether decision lives
_SETTLE = 6.0  # s that the robot gets to come to rest before control ends; it never leaves a robot that steps


class ControlProcess:
    """Runs one robot until decision ends the run, or has been dead for a while.

    Args:
        folder: the run's folder, with its channels.
    """

    def __init__(self, folder: RunFolder) -> None:
        self._folder = folder
        self._spec = spec = RunSpec.read(folder)
        robot, start = load_robot(Path(spec.robot), spec.body)
        scene = Scene(load_scene(Path(spec.scene)), spec.seed)
        self._plant: DrivenPlant = (
            CablePlant(robot, scene, spec.plant, Path(spec.key) if spec.key else None)
            if spec.plant
            else Simulation(robot, start, scene)
        )
        if not self._plant.simulated:
            channels.note_real(folder)
        self._controller = Controller(robot, self._plant, scene.start_pose, waits=False)
        tables = channels.cycle_tables(folder)
        if all(table.exists() for table in tables):
            plans, servo_cycles = map(TableWriter.open, tables)
            self._controller.log = CycleLog(plans, servo_cycles, Layout.of(robot.joint_names))
        self._commands = channels.reader(folder, "command")
        self._requests = channels.reader(folder, "request")
        self._states = channels.writer(folder, "state")
        self._truths = channels.writer(folder, "truth")
        self._notices = channels.writer(folder, "notice")
        self._refusals = channels.writer(folder, "refusal")
        self._timings = channels.writer(folder, "timing")
        self._wakes, self._stops = channels.writer(folder, "wake"), channels.writer(folder, "stop")
        self._estop = EStopFollower(channels.estop(folder), self._controller.supervisor, self._tell)
        self._quit = channels.quit_flag(folder)
        self._command_sequence = self._request_sequence = 0
        self._told_stops = 0
        self._orphaned_at: int | None = None
        self._hold = cycles(spec.hold)
        self._terminated = False
        self._leaving_since: int | None = None  # control is to end; the robot comes to rest first
        self._state_phase = cycles(ESTIMATE_PERIOD)
        self._object_phase = cycles(DECISION_PERIOD)

    def run(self) -> None:
        """Run the servo loop to its end."""
        privileges = claim(self._spec.core)
        for warning in privileges.warnings:
            self._tell("warning", warning)
        stopwatch = Stopwatch(privileges.fifo)
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # the terminal's Ctrl-C is for decision
        signal.signal(signal.SIGTERM, self._on_terminate)
        self._publish()
        schedule = Schedule(SERVO_PERIOD, spin=privileges.fifo)
        controller = self._controller
        while True:
            late, skipped = schedule.wait()
            began = time.monotonic_ns()
            if skipped >= _STALL:
                controller.supervisor.forgive_silence()
                self._tell("warning", f"control stalled for {skipped} ms")
            if self._ended():  # asked after a stall is told: it may be what ended the run
                break
            self._listen()
            if controller.cycle % self._object_phase == 0:
                self._plant.surround(controller.supervisor.targets)
            controller.run_cycle()
            self._after_cycle(stopwatch)
            busy = time.monotonic_ns() - began
            stopwatch.note(late, busy, skipped)
            self._wakes.write(Wake.pack(began, late, busy, skipped))
        self._close(stopwatch)

    # ---- in ---------------------------------------------------------------------------------------------------------

    def _listen(self) -> None:
        """Take what the other processes say: e-stop first, then requests, then commands."""
        supervisor = self._controller.supervisor
        self._estop.poll()
        if self._requests.sequence != self._request_sequence:
            entries, _ = self._requests.since(self._request_sequence)
            for self._request_sequence, payload in entries:
                source, _, reason = decode_event(payload).text.partition(": ")
                supervisor.request_stop(source, reason)
        if self._commands.sequence != self._command_sequence:
            entries, _ = self._commands.since(self._command_sequence)
            for self._command_sequence, payload in entries:
                try:
                    supervisor.submit(decode_command(payload))
                except WireError as error:
                    supervisor.rejected.append(f"command: {error}")

    @property
    def _time(self) -> float:
        """Engine time [s]."""
        return self._controller.cycle * SERVO_PERIOD

    def _on_terminate(self, _number: int, _frame: FrameType | None) -> None:
        self._terminated = True

    # ---- out --------------------------------------------------------------------------------------------------------

    def _after_cycle(self, stopwatch: Stopwatch) -> None:
        cycle, supervisor = self._controller.cycle, self._controller.supervisor
        if supervisor.stops.total > self._told_stops:  # its setpoint is out
            self._write_stops(supervisor.stops.since(self._told_stops))
        if cycle % self._state_phase == 2:  # not in the cycle that plans the whole body: that one is full
            self._publish()
        if supervisor.stops.total > self._told_stops:
            stamp = supervisor.command.stamp if supervisor.command is not None else None
            for stop in supervisor.stops.since(self._told_stops):
                text = f"{stop.mode.value}: {stop.reason} ({stop.source})"
                self._log("stop", text, commanded_by=dict(stop.resources), last_command=stamp)
            self._told_stops = supervisor.stops.total
            self._publish()
        if supervisor.rejected:
            for text in supervisor.rejected:
                self._refusals.write(text.encode(errors="backslashreplace")[:1000])
            supervisor.rejected.clear()
        if cycle % self._object_phase == 1 and (truth := self._plant.truth()) is not None:
            self._truths.write(encode_truth(truth))
        for level, text in self._plant.take_news():
            self._tell(level, text)
        for text in mujoco_warnings.taken():
            self._tell("warning", text)
        if cycle % _TIMING_PERIOD == 3:
            self._write_timing(stopwatch)
        lives = self._orphaned_at is None and self._leaving_since is None
        if cycle % _PARENT_PERIOD == 4 and lives and self._is_orphan():
            self._orphaned_at = cycle
            self._tell("error", f"decision died; control holds the robot for {self._spec.hold:g} s and ends")

    def _write_stops(self, stops: Iterable[Stop]) -> None:
        now = time.monotonic_ns()
        for stop in stops:
            resources = dict(stop.resources)
            record = StopRecord(now, stop.time, stop.mode.value, stop.reason, stop.source, resources)
            self._stops.write(record.to_bytes())

    def _publish(self) -> None:
        self._states.write(encode_state(self._controller.state()))

    def _write_timing(self, stopwatch: Stopwatch) -> None:
        self._timings.write(replace(stopwatch.timing, cable=self._plant.cable).to_bytes())

    def _tell(self, level: Level, text: str) -> None:
        self._notices.write(encode_event(Event(self._time, level, text)))
        self._log(level, text)

    def _log(self, kind: str, text: str, **more: object) -> None:
        """Note it in the file that stays. A full disk must not stop the servo."""
        if self._spec.log:
            line = json.dumps({"time": round(self._time, 3), "kind": kind, "text": text, **more})
            with suppress(OSError), Path(self._spec.log).open("a", encoding="utf-8") as file:
                file.write(line + "\n")

    # ---- the end ----------------------------------------------------------------------------------------------------

    def _ended(self) -> bool:
        """Return whether control ends now: it is to end, and the robot is at rest, or lies."""
        controller = self._controller
        supervisor, cycle = controller.supervisor, controller.cycle
        if self._plant.lost:
            return True
        if self._leaving_since is None:
            why = self._why_leave()
            if not why:
                return False
            self._leaving_since = cycle
            if not controller.settled and supervisor.mode is not Mode.DAMP:
                supervisor.request_stop("the control process", why)
        if controller.settled or supervisor.mode is Mode.DAMP:
            return True
        return cycle - self._leaving_since > cycles(_SETTLE) and controller.body.gait is Gait.STAND

    def _why_leave(self) -> str:
        """Return why control is to end, "" while it is not."""
        if self._quit.count:
            return "decision ended the run"
        if self._terminated:
            return "it was told to end (SIGTERM)"
        orphaned = self._orphaned_at is not None and self._controller.cycle - self._orphaned_at >= self._hold
        return "decision died" if orphaned else ""

    def _is_orphan(self) -> bool:
        return os.getppid() != self._spec.parent

    def _close(self, stopwatch: Stopwatch) -> None:
        self._publish()
        self._write_timing(stopwatch)
        with suppress(OSError):  # no room, or the folder is gone
            self._folder.path("result.json").write_text(json.dumps(self._plant.result()), encoding="utf-8")
        self._plant.close()
        if self._plant.lost:
            why = f"the plant is lost: {self._plant.fault}"
            if self._quit.count:  # else decision tells why control has ended
                self._tell("error", why)
            raise ControlLost(why)
        if self._orphaned_at is not None:
            self._log("end", "control ended: decision died before")
        elif self._quit.count >= ABANDONED:
            self._log("end", "control ended: decision did not wait for it")


def main() -> int:
    """Run control for the run whose folder is the first argument; if decision does not wait, clean up after it."""
    folder = channels.open_folder(sys.argv[1])
    quit_flag, parent = channels.quit_flag(folder), RunSpec.read(folder).parent
    try:
        ControlProcess(folder).run()
    except (UserError, ControlLost) as error:
        if isinstance(error, UserError):
            channels.leave_mistakes(folder, error)
        else:
            channels.note_lost(folder, str(error))
        if os.getppid() != parent:  # else decision tells it
            sys.stderr.write(f"error: {error}\n")
        return 2
    finally:
        channels.leave(folder)
        if quit_flag.count >= ABANDONED or os.getppid() != parent:
            folder.close()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
