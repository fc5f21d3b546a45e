"""Lockstep mode: all loops in one process on the simulation clock, in a fixed order.

At a cycle in which several are due: perception, then decision, then control and plant. The same robot, scene, seed
and commands give the same states, bit for bit.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import Any

import mujoco

from humanoid_bt.control.controller import Controller
from humanoid_bt.control.cycle_log import CycleLog, Layout
from humanoid_bt.control.supervisor import Supervisor, reset_text
from humanoid_bt.core.clock import DECISION_PERIOD, CycleClock, cycles
from humanoid_bt.core.kept import Kept
from humanoid_bt.core.messages import Array, Command, Level, Percept, State
from humanoid_bt.link.run_folder import RunInfo
from humanoid_bt.link.segment import LinkError
from humanoid_bt.link.table import LocalTable
from humanoid_bt.link.wire import Event
from humanoid_bt.perception.interface import Perception
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene
from humanoid_bt.plant.scene_model import scene_model
from humanoid_bt.plant.touches import Touch
from humanoid_bt.realtime.lockstep_link import LockstepLink
from humanoid_bt.robot import mujoco_warnings
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.session.engine import Input
from humanoid_bt.tree.tree import Tree

_log = logging.getLogger(__name__)


class Lockstep:
    """A robot in a scene with control and perception, advanced one decision period at a time.

    Args:
        robot: the robot.
        start: configuration to start in, shape (7 + nj,).
        scene: what surrounds it.
        perception: what it sees.

    Attributes:
        plant, controller, perception: the parts.
        clock: the engine's clock.
        notices: what happened besides stops: resets.
        inputs: what came from outside.
        truth: where the robot really was when it was sensed last.
    """

    def __init__(
        self,
        robot: RobotModel,
        start: Array,
        scene: Scene,
        perception: Perception,
    ) -> None:
        self.robot, self.scene, self._start = robot, scene, start
        self.clock = CycleClock()
        self.plant = MujocoPlant(robot, scene)
        self.plant.place(start)
        self.truth = self.plant.truth()
        self.controller = Controller(robot, self.plant, scene.start_pose)
        self._look_with(perception)
        self.notices: Kept[Event] = Kept()
        self.inputs: Kept[Input] = Kept()
        self._percepts: dict[str, Percept] = {}
        self._command: Command | None = None  # given, and not yet heard of
        self._resets: deque[str] = deque()  # who asks for one, from any thread
        self._state: State | None = None
        self._info = RunInfo("", "")
        self._link: LockstepLink | None = None
        self._links = True
        self._told_touches = 0
        self._logged: tuple[LocalTable, LocalTable] | None = None
        self._decision = cycles(DECISION_PERIOD)

    @cached_property
    def model(self) -> mujoco.MjModel:
        """MuJoCo's model of the robot in its scene, for those who draw it."""
        return scene_model(self.robot, self.scene)

    @property
    def supervisor(self) -> Supervisor:
        """What may stop the robot."""
        return self.controller.supervisor

    @property
    def external_force_max(self) -> float:
        """Largest external force or torque there ever was on any body [N, Nm]."""
        return self.plant.external_force_max

    @property
    def touches(self) -> Sequence[Touch]:
        """What of the scene the robot has touched so far, besides the floor."""
        return self.plant.touches.all

    @property
    def shows_parameters(self) -> bool:
        """False: other programs look through a gateway, in realtime mode."""
        return False

    def show_parameters(self, _shown: Sequence[Mapping[str, Any]]) -> None:
        """Nothing: nobody looks."""

    def take_settings(self) -> tuple[()]:
        """Return none."""
        return ()

    @property
    def takes_orders(self) -> bool:
        """False: goals come through a gateway, in realtime mode."""
        return False

    def take_orders(self) -> tuple[()]:
        """Return none."""
        return ()

    @property
    def calls(self) -> None:
        """None: other programs are asked through a gateway, in realtime mode."""

    @property
    def hold(self) -> None:
        """None: nothing keeps the tree from its ticks."""

    @property
    def timing(self) -> None:
        """None: simulated time has nothing to be late for."""

    @property
    def unseen(self) -> Mapping[str, str]:
        """The percepts that were never published so far, and why."""
        return self.perception.unseen

    @property
    def publishes(self) -> Collection[str]:
        """The percepts that its sources publish."""
        return self.perception.names

    def start(self, info: RunInfo, log: Path | None = None) -> None:
        """Begin: perception does; nothing needs a log of its own.

        Raises:
            UserError: a percept source cannot begin.
        """
        self._info = info
        self.perception.start()

    def log_cycles(self) -> None:
        """Keep every servo cycle for :meth:`take_cycles`."""
        layout = Layout.of(self.robot.joint_names)
        self._logged = layout.local()
        self.controller.log = CycleLog(*self._logged, layout)

    @property
    def cycle_tables(self) -> None:
        """None: :meth:`take_cycles` gives them."""

    def take_cycles(self) -> tuple[Array, Array] | None:
        """Return the rows of plans and servo cycles since the last time, until the next ones; call it in every tick."""
        if self._logged is None:
            return None
        plans, servo_cycles = self._logged
        return plans.take(), servo_cycles.take()

    def close(self) -> None:
        """End perception, and what was told to others."""
        self.perception.close()
        if self._link is not None:
            self._link.close()
            self._link = None

    def abandon(self) -> str:
        """Return "": simulated time stands still, and the simulation ends with the program."""
        return ""

    def announce(self, kind: str, values: Mapping[str, object]) -> None:
        """Tell nobody: only a gateway listens, in realtime mode."""

    def publish(self, status: Mapping[str, object], tree: Tree) -> None:
        """Tell other terminals what the tree does. A run for which there is no place in memory goes on without them."""
        if not self._links or self._state is None:
            return
        try:
            if self._link is None:
                self._link = LockstepLink(self._info, self.robot.joint_names, self.supervisor, self._note)
            self._link.tell(status, self._state, tree)
        except (LinkError, OSError) as error:
            self._links = False
            _log.warning("other terminals can neither see nor stop this run: %s", error)

    def request_reset(self, source: str) -> None:
        """Reset a latched stop before the next tick, if nothing stands against it."""
        self._resets.append(source)

    def push(self, body: str, force: Array, duration: float) -> None:
        """Push a body with a force, shape (3,), world frame [N], for a time [s].

        Raises:
            UserError: there is no such body.
        """
        self.plant.push(body, force, duration)
        self.inputs.append(Input(self.clock.now(), "push", [body, force.tolist(), duration]))

    def reset(self, perception: Perception, scene: Scene | None = None) -> None:
        """Begin a new run: the robot stands at the start, time is zero, nothing was seen.

        Args:
            perception: what the robot sees now.
            scene: another one with the same things at the same places; as before if None.
        """
        if scene is not None:
            self.scene = self.plant.scene = scene
        self.clock.cycle = 0
        self.plant.place(self._start)
        self.truth = self.plant.truth()
        self.controller.reset(self.scene.start_pose)
        self._look_with(perception)
        self._percepts = {}
        self._command = self._state = None
        self._resets.clear()
        self._logged = self.controller.log = None
        self._told_touches = 0
        self.notices = Kept()
        self.inputs = Kept()

    def sense(self) -> tuple[State, dict[str, Percept]]:
        """Return the state and the latest percepts, for one tick of decision."""
        self.plant.move_objects()
        while self._resets:
            self._reset(self._resets.popleft())
        state, truth = self._state, self.truth = self.controller.state(), self.plant.truth()
        if self._link is not None:
            self._link.sensed(state)
        if self.clock.due(self._perceive):
            for percept in self.perception.observe(truth, state):
                self._percepts[percept.name] = percept
            for level, text in self.perception.take_news():
                self._note(level, text)
        return state, dict(self._percepts)

    def submit(self, command: Command) -> None:
        """Give the command of a tick to control, which hears of it when time goes on."""
        self._command = command

    def advance(self) -> None:
        """Run one decision period of servo cycles; without a command since the last one decision is silent."""
        if self._link is not None:
            held = self.supervisor.hold
            self._link.obey()
            if held and not self.supervisor.hold:
                self.inputs.append(Input(self.clock.now(), "reset_after_tick", "another terminal"))
        if self._command is not None:
            self.controller.submit(self._command)
            self._command = None
        self.plant.touches.targets = self.supervisor.targets
        try:
            self.controller.run_cycles(self._decision)
        finally:
            self.clock.cycle = self.controller.cycle
        self.plant.note_external_force()
        for touch in self.touches[self._told_touches :]:
            self._note("info", touch.text)
        self._told_touches = len(self.touches)
        for text in mujoco_warnings.taken():
            self._note("warning", text)

    def _look_with(self, perception: Perception) -> None:
        self.perception = perception
        self._perceive = cycles(perception.period)

    def _reset(self, source: str) -> None:
        """Reset a latched stop, with what other terminals raised."""
        self.inputs.append(Input(self.clock.now(), "reset", source))
        if self._link is not None:
            with suppress(LinkError):  # no room in memory: what they raised stays
                self._link.reset(source)
                return
        self._note("warning", reset_text(source, self.supervisor.reset()))

    def _note(self, level: Level, text: str) -> None:
        self.notices.append(Event(self.clock.now(), level, text))
