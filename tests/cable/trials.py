"""The demo, and pulled cables, with a robot behind a cable that is late, irregular and loses frames.

python -m tests.cable.trials --seeds 50 --pulls 100
"""

from __future__ import annotations

import argparse
import functools
import socket
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np

from humanoid_bt.cable.impairment import Impairment
from humanoid_bt.cable.payloads import PlantState
from humanoid_bt.cable.safe_state import SafeState
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.clock import cycles
from humanoid_bt.core.messages import Array, Mode
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.perception.interface import Perception
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.session import lockstep
from humanoid_bt.session.report import Report
from humanoid_bt.session.run import run
from humanoid_bt.testing.scripted_perception import ScriptedPerception
from tests.cable.cabled import LOSSY, CabledLockstep
from tests.safety.activities import ACTIVITIES, WALKING
from tests.safety.machine import Machine, Scripted
from tests.safety.rows import SETTLE
from tests.trees.fetch_trials import PATIENCE, fault

STOPPED_WITHIN = cycles(0.025)
"""Servo cycles from the pull until both sides have stopped: 20 ms of silence, and what was under way."""

_AFTERWARDS = cycles(0.3)
_PUSHED = ("walking straight", "turning", "standing still")
_STANDING_TAKES = 1.4  # times the force that a walking robot takes
_PLUGGED_AFTER = (0.025, 0.095)  # s: from 20 ms on control and plant stop, after 120 ms they have parted
_RECOVERS = 3.0  # s after a push in which it falls, or does not


class CabledMachine(Machine):
    """The robot of the safety trials, behind a cable.

    Args:
        safe: the plant's safe state.
        impairment: what becomes of frames.
    """

    def __init__(self, safe: SafeState, impairment: Impairment = LOSSY) -> None:
        self.workspace = Workspace(builtin_root())
        self.robot, start = load_robot(Path(self.workspace.find_robot("humanoid")))
        scene = Scene(load_scene(self.workspace.find_scene("empty")), seed=0)
        self.cabled = CabledLockstep(self.robot, start, scene, ScriptedPerception(), safe=safe, impairment=impairment)
        self._begin(self.cabled)

    def push(self, body: str, force: Array, duration: float) -> None:
        """Push a body, shape (3,), world frame [N], for a time [s]."""
        self.cabled.push(body, force, duration)


@dataclass(frozen=True)
class Pull:
    """What came of a cable that was pulled.

    Attributes:
        stopped: servo cycles from then until control had stopped the robot, None if it has not.
        safe: the same until the plant was in its safe state.
        said: whether both sides said so.
        modes: that followed.
        lost: whether each side takes the other for gone in the end.
    """

    stopped: int | None
    safe: int | None
    said: bool
    modes: tuple[Mode, ...]
    lost: bool

    @property
    def as_told(self) -> bool:
        """Whether both sides were safe in time, and said so."""
        both = (self.stopped, self.safe)
        in_time = all(count is not None and count <= STOPPED_WITHIN for count in both)
        return in_time and self.said and self.lost and self.modes == (Mode.PROTECTIVE_STOP,)


@functools.cache
def _machine(safe: SafeState, impairment: Impairment = LOSSY) -> CabledMachine:
    return CabledMachine(safe, impairment)


def pushed(seed: int, impairment: Impairment, force: float) -> bool:
    """Push the torso for 0.1 s with a force [N], more of one that stands; return whether the robot went on."""
    activity = _PUSHED[seed % len(_PUSHED)]
    machine = _machine("hold", impairment)
    rng = np.random.default_rng([seed, 77])
    plan = ACTIVITIES[activity](rng)
    machine.reset()
    machine.decision = Scripted(plan.targets)
    machine.run(cycles(round(rng.uniform(plan.earliest, plan.latest), 3)))
    angle, size = rng.uniform(0.0, 2 * np.pi), force * rng.uniform(0.8, 1.2)
    size *= 1.0 if activity in WALKING else _STANDING_TAKES
    machine.push("torso", size * np.array([np.cos(angle), np.sin(angle), 0.0]), 0.1)
    machine.run(cycles(_RECOVERS))
    return not machine.modes


def pull(safe: SafeState, activity: str, seed: int, plugged_after: float | None = None) -> tuple[Pull, CabledMachine]:
    """Pull the cable at a random moment of an activity; plug it in again after a while [s], if that is given."""
    machine = _machine(safe)
    rng = np.random.default_rng([seed, list(ACTIVITIES).index(activity)])
    plan = ACTIVITIES[activity](rng)
    machine.reset()
    machine.decision = Scripted(plan.targets)
    machine.run(int(rng.integers(cycles(plan.earliest), cycles(plan.latest))))
    cabled, begin = machine.cabled.cabled, machine.cycle
    cabled.cable.pulled = True
    stopped = at_rest = None
    for count in range(1, _AFTERWARDS):
        if plugged_after is not None and count == cycles(plugged_after):
            cabled.cable.pulled = False
        machine.run(1)
        if stopped is None and machine.supervisor.mode is Mode.PROTECTIVE_STOP:
            stopped = count
        if at_rest is None and cabled.server.state in (PlantState.HOLDS, PlantState.DAMPS):
            at_rest = count
    said = any("no command for 2" in text for _, text in cabled.told) and any(
        "plant is silent" in stop.reason for stop in machine.supervisor.stops
    )
    modes = tuple(mode for cycle, mode in machine.modes if cycle >= begin)
    lost = cabled.remote.lost and cabled.server.driver is None
    return Pull(stopped, at_rest, said, modes, lost), machine


def plugged(seed: int) -> bool:
    """Pull the cable as the robot walks and plug it in before it is given up; return whether the robot goes on."""
    gap = round(np.random.default_rng([seed, 78]).uniform(*_PLUGGED_AFTER), 3)
    _, machine = pull("hold", list(WALKING)[seed % len(WALKING)], seed, plugged_after=gap)
    machine.release()
    settled = machine.run(SETTLE, until=lambda state: state.base_settled)
    return settled and machine.supervisor.mode is Mode.RUN


@contextmanager
def behind_a_cable(impairment: Impairment, seed: int) -> Iterator[list[CabledLockstep]]:
    """Let every run in lockstep have its robot behind a cable; give the runs."""
    made: list[CabledLockstep] = []
    before = lockstep.Lockstep

    def cabled(robot: Any, start: Any, scene: Scene, perception: Perception) -> CabledLockstep:
        made.append(CabledLockstep(robot, start, scene, perception, impairment=impairment, seed=seed))
        return made[-1]

    lockstep.Lockstep = cabled  # type: ignore[assignment, misc]  # for these runs
    try:
        yield made
    finally:
        lockstep.Lockstep = before  # type: ignore[misc]  # as it was


def fetch(seed: int, impairment: Impairment) -> tuple[Report, CabledLockstep]:
    """Run the demo in ``random_target``."""
    with behind_a_cable(impairment, seed) as runs:
        report = run("fetch", scene="random_target", seed=seed, duration=PATIENCE)
    return report, runs[-1]


@contextmanager
def served(impairment: Impairment) -> Iterator[str]:
    """Serve the robot in ``random_target`` in a process of its own; give its address."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{free.getsockname()[1]}"
    worse = [f"--latency={impairment.latency}", f"--jitter={impairment.jitter}", f"--loss={impairment.loss * 100}"]
    command = [sys.executable, "-m", "humanoid_bt", "plant", "humanoid", "--scene", "random_target", *worse]
    process = subprocess.Popen([*command, "--listen", address], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    try:
        while "waits for a driver" not in process.stdout.readline():
            assert process.poll() is None
        Thread(target=process.stdout.read, daemon=True).start()
        yield f"udp://{address}"
    finally:
        process.terminate()
        process.wait()


def fetch_in_realtime(seed: int, address: str) -> tuple[str, str]:
    """Run the demo over UDP on the wall clock; return what was wrong with it, and what the cable was like."""
    report = run(
        "fetch", scene="random_target", seed=seed, duration=PATIENCE, mode="realtime", plant=address, on_estop="end"
    )
    told = [event["text"] for event in report.events if event["text"].startswith(("the cable", "the servo"))]
    stops = Counter(f"{stop['mode']}: {stop['reason']}" for stop in report.stops)
    return fault(report), f"{'; '.join(told)}; stops: {dict(stops)}"


def main(arguments: list[str] | None = None) -> int:
    """Run them; return 0 if the ball was touched in 96 % of the runs, and every pulled cable was as told."""
    parser = argparse.ArgumentParser(prog="python -m tests.cable.trials", description="A robot behind a cable.")
    parser.add_argument("--seeds", type=int, default=50, help="runs of the demo (default: %(default)s)")
    parser.add_argument("--first", type=int, default=0, help="seed of the first (default: %(default)s)")
    parser.add_argument("--pulls", type=int, default=100, help="pulled cables (default: %(default)s)")
    parser.add_argument("--plugs", type=int, default=0, help="cables plugged in again (default: %(default)s)")
    parser.add_argument("--pushes", type=int, default=0, help="pushed robots (default: %(default)s)")
    parser.add_argument("--force", type=float, default=100.0, help="with which, on average [N] (default: %(default)s)")
    parser.add_argument("--latency", type=float, default=LOSSY.latency, help="[s] (default: %(default)s)")
    parser.add_argument("--jitter", type=float, default=LOSSY.jitter, help="[s] (default: %(default)s)")
    parser.add_argument("--loss", type=float, default=LOSSY.loss, help="share (default: %(default)s)")
    parser.add_argument("--realtime", type=int, default=0, help="runs on the wall clock (default: %(default)s)")
    options = parser.parse_args(arguments)
    impairment = Impairment(options.latency, options.jitter, options.loss)
    if options.realtime:
        with served(impairment) as address:
            for seed in range(options.first, options.first + options.realtime):
                why, cable = fetch_in_realtime(seed, address)
                sys.stdout.write(f"  realtime, seed {seed}: {why or 'touched'}; {cable}\n")
                sys.stdout.flush()
    touched = 0
    for seed in range(options.first, options.first + options.seeds):
        report, engine = fetch(seed, impairment)
        why = fault(report)
        touched += not why
        cable = engine.cabled.remote.figures
        sys.stdout.write(f"  seed {seed}: {why or 'touched'} after {report.sim_time:.1f} s; {cable}\n")
        sys.stdout.flush()
    sys.stdout.write(f"random_target: touched {touched} of {options.seeds}\n")
    if options.pushes:
        went_on = sum(pushed(seed, impairment, options.force) for seed in range(options.pushes))
        sys.stdout.write(f"pushed: {went_on} of {options.pushes} went on\n")
    if options.plugs:
        went_on = sum(plugged(seed) for seed in range(options.plugs))
        sys.stdout.write(f"plugged in again: {went_on} of {options.plugs} went on\n")
    pulls: list[Pull] = []
    for seed in range(options.pulls):
        activity = list(WALKING)[seed // 2 % len(WALKING)]
        one, _ = pull("damp" if seed % 2 else "hold", activity, seed)
        pulls.append(one)
        if not one.as_told:
            sys.stdout.write(f"  pull {seed} ({activity}): {one}\n")
    good = sum(one.as_told for one in pulls)
    sys.stdout.write(f"cable pulled in mid-walk: as told {good} of {options.pulls}\n")
    if pulls:
        latest = [max(one.stopped or 0 for one in pulls), max(one.safe or 0 for one in pulls)]
        sys.stdout.write(f"control stopped after at most {latest[0]} ms, the plant was safe after {latest[1]} ms\n")
    return int(touched < 0.96 * options.seeds or good < options.pulls)


if __name__ == "__main__":
    raise SystemExit(main())
