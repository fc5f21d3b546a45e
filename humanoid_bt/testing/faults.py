"""Faults that a test brings about: what is done to a robot, to what it sees, or to its tree, at a moment of a run."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from humanoid_bt.core.errors import Problem, UserError, nearest
from humanoid_bt.core.geometry import heading_of, rotation_matrix
from humanoid_bt.core.items import Item
from humanoid_bt.core.messages import Array, Percept, State
from humanoid_bt.core.params import param
from humanoid_bt.core.patterns import matching
from humanoid_bt.core.plain import plain
from humanoid_bt.plant.sensor_failures import SensorFailure
from humanoid_bt.session.setting import setting
from humanoid_bt.testing.fault import Acting, Fault, Known, Misnamed

__all__ = [
    "Break",
    "Delay",
    "EStop",
    "Lose",
    "Noise",
    "Push",
    "Raise",
    "Reset",
    "See",
    "Set",
    "Silence",
    "Weaken",
]

_FOR_GOOD = "; for good if not given."


# ---- the robot ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Push(Fault):
    """Push the robot."""

    physical: ClassVar[bool] = True

    force: tuple[float, float, float] = param(
        minimum=-10_000, maximum=10_000, unit="N", doc="The force, in the world's directions, x y z."
    )
    duration: float = param(0.1, above=0, unit="s", doc="How long.")
    body: str = param("", doc="The body of the robot's model that is pushed; the torso if not given.")

    def misnamed(self, known: Known) -> Iterator[Misnamed]:
        """Yield that there is no such body."""
        if self.body and self.body not in known.bodies:
            hint = nearest(self.body, known.bodies)
            problem = Problem(f"there is no body {self.body!r} to push", hint=hint, code="unknown-body")
            yield Misnamed(problem, ("body",))

    def begin(self, on: Acting) -> None:
        """Push."""
        on.push(self.body or on.known.torso, np.array(self.force), self.duration)


@dataclass(frozen=True, kw_only=True)
class Weaken(Fault):
    """Let drives give less torque than they are asked for."""

    physical: ClassVar[bool] = True

    joints: list[str] = param(doc="Their joints, by name or pattern (left_*).")
    to: float = param(minimum=0, maximum=1, doc="What they still give, of what they are asked for and at most.")
    duration: float | None = param(None, above=0, unit="s", doc="How long" + _FOR_GOOD)

    def misnamed(self, known: Known) -> Iterator[Misnamed]:
        """Yield which joints there are not."""
        for index, pattern in enumerate(self.joints):
            if not matching(known.joints, pattern):
                hint = nearest(pattern, known.joints)
                problem = Problem(f"the robot has no joint {pattern!r}", hint=hint, code="unknown-joint")
                yield Misnamed(problem, ("joints", index))

    def strength(self, joints: Sequence[str]) -> Array:
        """Return what each drive still gives."""
        weak = {name for pattern in self.joints for name in matching(joints, pattern)}
        return np.array([self.to if name in weak else 1.0 for name in joints])


@dataclass(frozen=True, kw_only=True)
class Break(Fault):
    """Let a sensor fail, for good."""

    physical: ClassVar[bool] = True
    main: ClassVar[str] = "sensor"

    sensor: str = param(
        doc="Of the IMU gyro, accelerometer, orientation, or imu for all three; a joint; or left_foot or right_foot, "
        "where there are force sensors."
    )
    how: SensorFailure = param("silent", doc="Whether it says nothing, the same for ever, or anything.")

    def misnamed(self, known: Known) -> Iterator[Misnamed]:
        """Yield that there is no such sensor."""
        if self.sensor not in known.sensors:
            hint = nearest(self.sensor, known.sensors)
            problem = Problem(f"the robot has no sensor {self.sensor!r}", hint=hint, code="unknown-sensor")
            yield Misnamed(problem, ("sensor",))

    def begin(self, on: Acting) -> None:
        """Break it."""
        on.fail_sensor(self.sensor, self.how)


@dataclass(frozen=True, kw_only=True)
class EStop(Fault):
    """Raise the emergency stop."""

    main: ClassVar[str] = "reason"

    reason: str = param("raised by the test", doc="Why.")

    def begin(self, on: Acting) -> None:
        """Raise it."""
        on.raise_estop("the test", self.reason)


@dataclass(frozen=True, kw_only=True)
class Reset(Fault):
    """Ask for the reset of a latched stop."""

    main: ClassVar[str] = "source"

    source: str = param("the test", doc="Who asks.")

    def begin(self, on: Acting) -> None:
        """Ask."""
        on.request_reset(self.source)


# ---- what it sees ---------------------------------------------------------------------------------------------------


class _Sensory(Fault):
    """Base of the faults that change what is seen."""

    sensory: ClassVar[bool] = True
    main: ClassVar[str] = "percept"

    def misnamed(self, known: Known) -> Iterator[Misnamed]:
        """Yield that nobody publishes the percept."""
        name = str(vars(self)["percept"])
        if name and known.percepts is not None and name not in known.percepts:
            hint = nearest(name, known.percepts) or "it publishes none; the event 'see' dictates one"
            problem = Problem(f"no percept source publishes {name!r}", hint=hint, code="unknown-percept")
            yield Misnamed(problem, ("percept",))


@dataclass(frozen=True, kw_only=True)
class Lose(_Sensory):
    """Let perception of a thing end: its last percept grows old."""

    percept: str = param(doc="The percept.")
    duration: float | None = param(None, above=0, unit="s", doc="How long" + _FOR_GOOD)

    def seen(
        self, name: str, percept: Percept | None, state: State, due: bool, numbers: np.random.Generator
    ) -> Percept | None:
        """Return nothing in its place."""
        return None if name == self.percept else percept


@dataclass(frozen=True, kw_only=True)
class See(_Sensory):
    """Let the robot see a thing at a place, whatever the scene has of this name."""

    main: ClassVar[str] = ""

    percept: str = param(doc="The percept.")
    position: tuple[float, float, float] = param(unit="m", doc="Where, x y z in the world.")
    size: tuple[float, float, float] | None = param(
        None, unit="m", doc="Of a solid thing: length, width, height of the box around it."
    )
    confidence: float = param(0.95, minimum=0, maximum=1, doc="How sure perception is.")
    duration: float | None = param(None, above=0, unit="s", doc="How long" + _FOR_GOOD)

    def misnamed(self, known: Known) -> Iterator[Misnamed]:
        """Yield that nobody asks for the percept, unless nobody asks for any."""
        if known.asked and self.percept not in known.asked:
            message = f"neither the tree nor the scene knows a percept {self.percept!r}"
            problem = Problem(message, hint=nearest(self.percept, known.asked), code="unknown-percept")
            yield Misnamed(problem, ("percept",))

    def seen(
        self, name: str, percept: Percept | None, state: State, due: bool, numbers: np.random.Generator
    ) -> Percept | None:
        """Return the thing where it is said to be, in the robot's base frame."""
        if name != self.percept:
            return percept
        if not due:
            return None
        turn = rotation_matrix(state.base_quaternion)
        position = turn.T @ (np.array(self.position) - state.base_position)
        size = None if self.size is None else np.array(self.size)
        return Percept(name, state.time, position, self.confidence, size, -heading_of(turn))


@dataclass(frozen=True, kw_only=True)
class Noise(_Sensory):
    """Let a percept be seen worse than it is."""

    main: ClassVar[str] = ""

    percept: str = param("", doc="The percept; all of them if not given.")
    sigma: float = param(0.0, minimum=0, unit="m", doc="Standard deviation of what is added to each coordinate.")
    drop_out: float = param(0.0, minimum=0, maximum=1, doc="Probability that an observation is lost.")
    confidence: float = param(1.0, minimum=0, maximum=1, doc="Factor of the confidence.")
    delay: float = param(0.0, minimum=0, unit="s", doc="How much later it arrives, in whole ticks.")
    duration: float | None = param(None, above=0, unit="s", doc="How long" + _FOR_GOOD)

    def concerns(self, name: str) -> bool:
        """Return whether it is about a percept."""
        return self.percept in ("", name)

    def seen(
        self, name: str, percept: Percept | None, state: State, due: bool, numbers: np.random.Generator
    ) -> Percept | None:
        """Return it moved and doubted, or not at all."""
        if percept is None or not self.concerns(name):
            return percept
        dropped, offset = numbers.random() < self.drop_out, self.sigma * numbers.standard_normal(3)
        if dropped:
            return None
        return replace(percept, position=percept.position + offset, confidence=percept.confidence * self.confidence)


# ---- what it is told ------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Silence(Fault):
    """Let no command reach control, as if decision were stuck."""

    main: ClassVar[str] = "duration"

    duration: float = param(above=0, unit="s", doc="How long.")

    @property
    def lateness(self) -> float:
        """Infinity: they never do."""
        return math.inf


@dataclass(frozen=True, kw_only=True)
class Delay(Fault):
    """Let every command reach control later, in whole ticks."""

    main: ClassVar[str] = "by"

    by: float = param(above=0, unit="s", doc="How much later.")
    duration: float | None = param(None, above=0, unit="s", doc="How long" + _FOR_GOOD)

    @property
    def lateness(self) -> float:
        """How much later [s]."""
        return self.by


# ---- its tree -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Raise(Fault):
    """Let a node raise an exception in the next tick that it gets."""

    main: ClassVar[str] = "node"

    node: str = param(doc="Its path, or the end of it.")
    message: str = param("raised by the test", doc="The exception's text.")

    def misnamed(self, known: Known) -> Iterator[Misnamed]:
        """Yield that there is no such node."""
        try:
            known.tree.node(self.node)
        except UserError as error:
            yield from (Misnamed(problem, ("node",)) for problem in error.problems)

    def begin(self, on: Acting) -> None:
        """Let it raise."""
        on.raise_in(self.node, self.message)


@dataclass(frozen=True, kw_only=True)
class Set(Fault):
    """Give keys of the blackboard, or parameters of nodes, a value."""

    values: Mapping[str, Any] = param(doc="Value by name: KEY, or NODE.PARAMETER.")

    @classmethod
    def from_item(cls, item: Item, name: str) -> Self:
        """Read a mapping of names to values; raises UserError."""
        if not isinstance(item.value, dict) or not item.value:
            hint = "like {attempts: 3}"
            raise UserError(f"{name!r} must be a mapping of names to values", item.place, hint, "wrong-type")
        return cls(values=item.plain())

    @property
    def plain(self) -> Any:
        """The fault as data for JSON, as a file would say it."""
        return plain(self.values)

    def misnamed(self, known: Known) -> Iterator[Misnamed]:
        """Yield what cannot be set so."""
        for name, value in self.values.items():
            try:
                setting(known.tree, name, value)
            except UserError as error:
                for problem in error.problems:
                    yield Misnamed(problem, (name,), key=problem.code.startswith("unknown-"))

    def begin(self, on: Acting) -> None:
        """Set them."""
        for name, value in self.values.items():
            setting(on.known.tree, name, value).apply()

    def __str__(self) -> str:
        return f"set ({', '.join(f'{name} = {value}' for name, value in self.values.items())})"
