"""The engine of a run on the stage: another engine, and between it and the tree what a script does."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from py_trees.behaviour import Behaviour

from humanoid_bt.core.clock import PERCEPTION_PERIOD, cycles
from humanoid_bt.core.errors import Place
from humanoid_bt.core.messages import Array, Command, Percept, State
from humanoid_bt.decision.robot import Robot
from humanoid_bt.link.wire import Event as Notice
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import random_stream
from humanoid_bt.session.engine import Engine
from humanoid_bt.testing.claim import RunNames
from humanoid_bt.testing.course import Course, Missed, View
from humanoid_bt.testing.events import Event
from humanoid_bt.testing.fault import Fault, Known
from humanoid_bt.testing.faults import Noise
from humanoid_bt.tree.ticking.tick import Branch
from humanoid_bt.tree.tree import Tree

_AT = 1e-9  # s; engine times are sums of floats
_LOOK = cycles(PERCEPTION_PERIOD)


class InjectedError(RuntimeError):
    """What a node raises because a test says so."""


class _Lasting(NamedTuple):
    """A fault that has begun, until when it lasts [s], and its random numbers."""

    fault: Fault
    until: float
    numbers: np.random.Generator


class Staged:
    """An engine that is another one but for what a script does to it: what is not here is asked of that one.

    Args:
        engine: it.
        script: what is done.
        seed: of the faults' random numbers; each fault has its own.
        plant: what is simulated; None if no body is.

    Attributes:
        known: what the names in the script mean.
        percepts: what decision was given at the last tick.
    """

    def __init__(self, engine: Engine, script: Sequence[Event], seed: int, plant: MujocoPlant | None) -> None:
        self.engine = engine
        self.clock, self.supervisor, self.notices = engine.clock, engine.supervisor, engine.notices
        self.known: Known
        self._course: Course
        self._looks = False  # whether moments are asked of the course
        self._robot: Robot
        self.percepts: Mapping[str, Percept] = {}
        self._script = script
        self._waiting = [(event, random_stream(seed, "fault", str(number))) for number, event in enumerate(script)]
        self._sensory = any(event.fault.sensory for event in script)
        self._plant = plant
        self._lasting: list[_Lasting] = []
        self._known: Mapping[str, Percept] = {}  # what perception gives
        self._shown: dict[str, None] = {}  # what that or the script has shown, given to decision or not
        self._coming: list[tuple[float, Percept]] = []  # when it arrives [s]
        self._late: list[tuple[float, Command]] = []  # when it reaches control [s]

    def __getattr__(self, name: str) -> Any:
        return getattr(self.engine, name)

    def enter(self, known: Known, robot: Robot, lines: Sequence[str]) -> None:
        """Take what there is once a run is made ready.

        Args:
            known: what the names in the script mean.
            robot: the robot as the tree sees it, of which moments are asked.
            lines: what holds from the beginning, for people.
        """
        self.known, self._robot = known, robot
        self._course = Course(known.tree, self.engine.supervisor.stops)
        moments = [event.when for event, _ in self._waiting if event.when is not None]
        for moment in moments:
            moment.link(RunNames(self._course, known.percepts))
        self._looks = bool(moments)
        for line in lines:
            self.tell(line)

    def look(self, view: View) -> None:
        """Look at what a tick has brought: moments of the script are asked of it."""
        if self._looks:
            self._course.tick(view)

    def close_script(self) -> list[Missed]:
        """End the script with its tree; return what of it never happened."""
        waiting = {id(event) for event, _ in self._waiting}
        missed = [event for event in self._script if id(event) in waiting or _is_armed(event, self.known.tree)]
        self._waiting = []
        for event in missed:
            self.tell(f"never happened: {event}")
        return [self._missed(event) for event in missed]

    def _missed(self, event: Event) -> Missed:
        values = {} if event.when is None else event.when.values(self._robot)
        return Missed(str(event), event.place or Place(""), event.optional, values)

    def tell(self, text: str) -> None:
        """Note for people, and for the recording, what was staged."""
        self.engine.notices.append(Notice(self.engine.clock.now(), "warning", f"staged: {text}"))

    # ---- what the loop of the run asks ------------------------------------------------------------------------------

    def publish(self, _status: object, _tree: object) -> None:
        """Tell nobody: a test is no run that people look at from outside."""

    @property
    def unseen(self) -> Mapping[str, str]:
        """The percepts that decision was never given, and why."""
        kept = {name: "kept from it by the test" for name in self._shown if name not in self.percepts}
        return {**self.engine.unseen, **kept} if kept else self.engine.unseen

    def sense(self) -> tuple[State, Mapping[str, Percept]]:
        """Return the state and the latest percepts, for one tick, after what the script does before it."""
        if self._waiting or self._lasting:
            self._act(self.engine.clock.now())
        state, percepts = self.engine.sense()
        self.percepts = self._seen(state, percepts) if self._sensory else percepts
        return state, self.percepts

    def submit(self, command: Command) -> None:
        """Give the command of a tick to control, now, later or never."""
        late = max((lasting.fault.lateness for lasting in self._lasting), default=0.0)
        if late or self._late:
            self._late.append((command.stamp + late, command))
        else:
            self.engine.submit(command)

    def advance(self) -> None:
        """Let one period of decision pass."""
        if self._late:
            now = self.engine.clock.now() + _AT
            for due, command in self._late:
                if due <= now:
                    self.engine.submit(command)
            self._late = [(due, command) for due, command in self._late if now < due < math.inf]
        self.engine.advance()

    # ---- what faults act on -----------------------------------------------------------------------------------------

    def push(self, body: str, force: Array, duration: float) -> None:
        """Push a body with a force, shape (3,), world frame [N], for a time [s]."""
        self.engine.push(body, force, duration)

    def fail_sensor(self, sensor: str, how: str) -> None:
        """Let a sensor fail for good."""
        assert self._plant is not None
        self._plant.fail_sensor(sensor, how)

    def raise_estop(self, source: str, reason: str) -> None:
        """Raise the emergency stop."""
        self.engine.supervisor.raise_estop(source, reason)

    def request_reset(self, source: str) -> None:
        """Ask for a reset of a latched stop."""
        self.engine.request_reset(source)

    def raise_in(self, node: str, message: str) -> None:
        """Let a node raise an exception in the next tick that it gets."""
        _raise_once(self.known.tree.node(node).behaviour, InjectedError(message))

    def _act(self, now: float) -> None:
        """Begin what is due, and end what has lasted."""
        over = [lasting for lasting in self._lasting if lasting.until <= now + _AT]
        due = [entry for entry in self._waiting if self._is_due(entry[0], now)]
        if not over and not due:
            return
        self._lasting = [lasting for lasting in self._lasting if lasting not in over]
        self._waiting = [entry for entry in self._waiting if entry not in due]
        for lasting in over:
            self.tell(f"over: {lasting.fault}")
        for event, numbers in due:
            fault = event.fault
            self.tell(f"{fault}" + (f", for {event.when.explain()}" if event.when is not None else ""))
            fault.begin(self)
            until = math.inf if fault.duration is None else now + fault.duration
            if fault.duration != 0.0:
                self._lasting.append(_Lasting(fault, until, numbers))
        self._lasting.sort(key=lambda lasting: isinstance(lasting.fault, Noise))  # noise last: of what is seen then
        self._weaken()

    def _is_due(self, event: Event, now: float) -> bool:
        if event.at is not None:
            return event.at <= now + _AT
        assert event.when is not None
        try:
            return now > 0.0 and bool(event.when.holds(self._robot))
        except (TypeError, ArithmeticError):  # what cannot be computed is not true
            return False

    def _weaken(self) -> None:
        joints = self.known.joints
        strengths = [found for lasting in self._lasting if (found := lasting.fault.strength(joints)) is not None]
        if self._plant is not None:
            self._plant.set_strength(functools.reduce(np.multiply, strengths, np.ones(len(joints))))

    def _seen(self, state: State, percepts: Mapping[str, Percept]) -> Mapping[str, Percept]:
        """Return what decision is given in the place of percepts."""
        new = {name: percept for name, percept in percepts.items() if self._known.get(name) is not percept}
        self._known = percepts
        due = state.cycle % _LOOK == 0
        for name in dict.fromkeys([*new, *self._dictated()]):
            percept, delay = new.get(name), 0.0
            for fault, _, numbers in self._lasting:
                if percept is not None:
                    self._shown[name] = None
                percept = fault.seen(name, percept, state, due, numbers)
                delay += fault.delay if fault.concerns(name) else 0.0
            if percept is not None:
                self._coming.append((state.time + delay, percept))
        arrived = [percept for at, percept in self._coming if at <= state.time + _AT]
        self._coming = [(at, percept) for at, percept in self._coming if at > state.time + _AT]
        return _latest([*self.percepts.values(), *arrived]) if arrived else self.percepts

    def _dictated(self) -> Iterator[str]:
        """Yield the percepts that faults may bring about by themselves."""
        return (name for lasting in self._lasting if (name := getattr(lasting.fault, "percept", "")))


def _latest(percepts: Iterable[Percept]) -> dict[str, Percept]:
    """Return the latest percept of each name; of some of one moment the last."""
    latest: dict[str, Percept] = {}
    for percept in percepts:
        if percept.name not in latest or percept.stamp >= latest[percept.name].stamp:
            latest[percept.name] = percept
    return latest


def _ticked(node: Behaviour) -> str:
    """Return the method of a node that does its own work in a tick."""
    own = "update" if type(node).tick is Behaviour.tick else "tick"
    return "advance" if isinstance(node, Branch) else own


def _is_armed(event: Event, tree: Tree) -> bool:
    """Return whether a node that is to raise has not got its next tick yet."""
    if event.raise_ is None:
        return False
    node = tree.node(event.raise_.node).behaviour
    return _ticked(node) in vars(node)


def _raise_once(node: Behaviour, error: Exception) -> None:
    """Let a node raise an exception in its next tick, as if its own code did."""
    ticked = _ticked(node)

    def raising(*_: object) -> Any:
        del vars(node)[ticked]
        raise error

    vars(node)[ticked] = raising
