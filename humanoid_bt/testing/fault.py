"""What a fault is, and what faults act on."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import Any, ClassVar, NamedTuple, Protocol, Self

import numpy as np

from humanoid_bt.core.errors import Problem
from humanoid_bt.core.items import Item
from humanoid_bt.core.messages import Array, Percept, State
from humanoid_bt.core.params import params_of
from humanoid_bt.core.plain import plain
from humanoid_bt.core.reading import read
from humanoid_bt.core.units import readable
from humanoid_bt.tree.tree import Tree


class Known(NamedTuple):
    """What the names in a script can mean.

    Attributes:
        tree: the tree that runs.
        torso: the body that is pushed where none is named.
        joints: the robot's, in its order.
        sensors: those of the robot that can fail.
        bodies: those that can be pushed.
        percepts: those that the scene publishes or the script dictates; None if that is not known.
        asked: those that the scene publishes or the tree asks for.
        dry: whether there is no simulated body.
    """

    tree: Tree
    torso: str
    joints: Sequence[str]
    sensors: Collection[str]
    bodies: Collection[str]
    percepts: Collection[str] | None
    asked: Collection[str]
    dry: bool


class Misnamed(NamedTuple):
    """Something that a fault names and that is not there.

    Attributes:
        problem: what is wrong with it.
        keys: where in the fault it stands: keys of mappings, indices of lists.
        key: whether it is the last of these itself, and not its value.
    """

    problem: Problem
    keys: tuple[str | int, ...]
    key: bool = False


class Acting(Protocol):
    """What faults act on."""

    known: Known

    def push(self, body: str, force: Array, duration: float) -> None:
        """Push a body with a force, shape (3,), world frame [N], for a time [s]."""

    def fail_sensor(self, sensor: str, how: str) -> None:
        """Let a sensor fail for good: one of the IMU's, "imu", a foot's, or a joint's; frozen, silent or jumping."""

    def raise_estop(self, source: str, reason: str) -> None:
        """Raise the emergency stop."""

    def request_reset(self, source: str) -> None:
        """Ask for a reset of a latched stop."""

    def raise_in(self, node: str, message: str) -> None:
        """Let a node raise an exception in the next tick that it gets."""


class Fault:
    """Base of the faults; a subclass is a frozen dataclass that declares its parameters.

    Attributes:
        main: the parameter that is meant where no mapping is written (``lose: target``), "" for none.
        physical: whether it needs a simulated body.
        sensory: whether it changes what is seen.
        duration: how long it lasts [s]: 0 for what is done at once, None for good.
        delay: how much later the percepts that it concerns arrive meanwhile [s].
    """

    main: ClassVar[str] = ""
    physical: ClassVar[bool] = False
    sensory: ClassVar[bool] = False
    duration: float | None = 0.0
    delay: float = 0.0

    @classmethod
    def from_item(cls, item: Item, name: str) -> Self:
        """Read a fault from a YAML value: a mapping of its parameters, or its main one.

        Raises:
            UserError: with everything that is wrong with it.
        """
        if cls.main and not isinstance(item.value, dict):
            item = Item({cls.main: item}, item.place, {cls.main: item.place})
        fault: Self = read(cls, item, repr(name))
        return fault

    @property
    def plain(self) -> Any:
        """The fault as data for JSON, as a file would say it."""
        return plain(self)

    def misnamed(self, known: Known) -> Iterator[Misnamed]:
        """Yield what it names and is not there."""
        yield from ()

    @property
    def lateness(self) -> float:
        """How much later commands reach control meanwhile, infinity if they never do [s]."""
        return 0.0

    def begin(self, on: Acting) -> None:
        """Do what is done at once."""

    def concerns(self, name: str) -> bool:
        """Return whether its ``delay`` is about a percept."""
        return False

    def seen(
        self, name: str, percept: Percept | None, state: State, due: bool, numbers: np.random.Generator
    ) -> Percept | None:
        """Return what is seen of a thing in a tick, None if nothing new is.

        Args:
            name: of the percept.
            percept: what would be seen but for this fault.
            state: of the robot, at the tick.
            due: whether perception looks in this tick.
            numbers: random ones of this fault.
        """
        return percept

    def strength(self, joints: Sequence[str]) -> Array | None:
        """Return what each drive still gives, of what it is asked for, shape (nj,); None if nothing changes."""
        return None

    def __str__(self) -> str:
        given = {name: (spec, getattr(self, name)) for name, spec in params_of(type(self)).items()}
        told = [
            f"{name} {readable(list(value) if isinstance(value, tuple) else value, spec.unit)}"
            + (f" {spec.unit}" if isinstance(value, tuple) else "")
            for name, (spec, value) in given.items()
            if spec.required or value != spec.default
        ]
        return type(self).__name__.lower() + (f" ({', '.join(told)})" if told else "")
