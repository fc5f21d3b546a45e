"""A robot in lockstep whose decision, and the way from decision to control, can be made to fail in any servo cycle."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Protocol

import numpy as np

from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.control.supervisor import Supervisor
from humanoid_bt.core.clock import DECISION_PERIOD, SERVO_PERIOD, cycles
from humanoid_bt.core.messages import Command, Mode, Percept, State, Target
from humanoid_bt.decision.robot import Robot
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.session.lockstep import Lockstep
from humanoid_bt.testing.scripted_perception import ScriptedPerception
from humanoid_bt.tree.source.load import load_tree
from humanoid_bt.tree.ticking.executor import Executor

TICK = cycles(DECISION_PERIOD)

Targets = Mapping[str, Target]
Line = Callable[[Command], Iterable[Command]]
"""What arrives at control of a command that decision sends."""


class Decision(Protocol):
    """What commands the robot."""

    def tick(self, state: State, percepts: Mapping[str, Percept]) -> Command: ...


class Scripted:
    """A decision that wants the targets which a function gives."""

    def __init__(self, targets: Callable[[State], Targets], sequence: int = 0) -> None:
        self._targets, self._sequence = targets, sequence

    def tick(self, state: State, percepts: Mapping[str, Percept]) -> Command:
        targets = dict(self._targets(state))
        self._sequence += 1
        return Command(self._sequence, state.time, targets, {resource: f"root/{resource}" for resource in targets})


def intact(command: Command) -> Iterable[Command]:
    return [command]


class Machine:
    """A robot on an empty floor, one servo cycle at a time.

    Args:
        robot: its name, or its ``robot.yaml``.

    Attributes:
        decision: what commands it; None: nothing does.
        line: what arrives of its commands.
        sees: what it sees; None when perception is dead.
        modes: (servo cycle, mode) of every change of mode.
        undo: what a fault has broken that the next reset is to mend.
        beyond: farthest that a joint was beyond its range so far [rad].
    """

    def __init__(self, robot: str = "humanoid") -> None:
        self.workspace = Workspace(builtin_root())
        self.robot, start = load_robot(Path(self.workspace.find_robot(robot)))
        self._alive = ScriptedPerception()
        scene = Scene(load_scene(self.workspace.find_scene("empty")), seed=0)
        self._begin(Lockstep(self.robot, start, scene, self._alive))

    def _begin(self, lockstep: Lockstep) -> None:
        """Have an engine, and stand at its start."""
        self._lockstep = lockstep
        limited = self.robot.model.jnt_limited[1:].astype(bool)
        self._range = np.where(limited[:, None], self.robot.model.jnt_range[1:], [-np.inf, np.inf])
        self.undo: list[Callable[[], None]] = []
        self.plant, self.controller = self._lockstep.plant, self._lockstep.controller
        self.reset()

    def reset(self) -> None:
        """Stand at the origin at time 0, with a decision that wants nothing."""
        while self.undo:
            self.undo.pop()()
        self.sees = ScriptedPerception()
        self._lockstep.reset(self.sees)
        self.beyond = 0.0
        self.decision: Decision = Scripted(lambda _: {})
        self.line: Line = intact
        self.modes: list[tuple[int, Mode]] = []
        self.last_command: Command | None = None
        self._script: list[tuple[int, Callable[[], None]]] = []
        self._mode = Mode.RUN

    @property
    def supervisor(self) -> Supervisor:
        return self.controller.supervisor

    @property
    def cycle(self) -> int:
        return self.controller.cycle

    @property
    def state(self) -> State:
        return self.controller.state()

    def follow_tree(self, name: str) -> Executor:
        """Let a built-in tree decide."""
        tree = load_tree(self.workspace.find_tree(name), self.workspace)
        executor = Executor(tree, Robot(self.robot.config, self._lockstep.clock))
        executor.setup()
        self.decision = executor
        return executor

    def release(self) -> None:
        """Let decision want nothing from now on."""
        sequence = self.last_command.sequence if self.last_command else 0
        self.decision = Scripted(lambda _: {}, sequence)

    def kill_perception(self) -> None:
        """Publish nothing from now on."""
        self._lockstep.perception = ScriptedPerception()

    def revive_perception(self) -> None:
        """Publish again."""
        self._lockstep.perception = self.sees

    def after(self, seconds: float, action: Callable[[], None]) -> None:
        """Do something before the servo cycle that begins so much later."""
        self._script.append((self.cycle + cycles(seconds), action))

    def run(self, count: int, until: Callable[[State], bool] | None = None) -> bool:
        """Run servo cycles, at most ``count``; stop at the tick at which ``until`` is true, and tell whether it was."""
        for _ in range(count):
            for entry in [entry for entry in self._script if entry[0] <= self.cycle]:
                self._script.remove(entry)
                entry[1]()
            if self.cycle % TICK == 0:
                state, percepts = self._lockstep.sense()
                self._note_joints()
                if until is not None and until(state):
                    return True
                self.last_command = self.decision.tick(state, percepts)
                for command in self.line(self.last_command):
                    self.controller.submit(command)
            self.controller.run_cycle()
            self._lockstep.clock.cycle += 1
            if self.supervisor.mode is not self._mode:
                self._mode = self.supervisor.mode
                self.modes.append((self.cycle - 1, self._mode))
        return False

    def _note_joints(self) -> None:
        angles, (low, high) = self.plant.truth().joint_positions, self._range.T
        self.beyond = max(self.beyond, float(np.maximum(low - angles, angles - high).max()))


def seconds(count: int) -> float:
    """Return servo cycles as a time [s]."""
    return count * SERVO_PERIOD


def resent(command: Command, **changes: object) -> Command:
    """Return a command as it looks after something damaged it."""
    return dataclasses.replace(command, **changes)  # type: ignore[arg-type]  # of each their own kind
