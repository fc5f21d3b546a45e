"""Faults that a test brings about: what is done to a robot, to what it sees, or to its tree, at a moment of a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.items import Item
from humanoid_bt.core.params import param
from humanoid_bt.core.reading import read

if TYPE_CHECKING:
    from humanoid_bt.testing.staged import Staged

_FOR_GOOD = "; for good if not given."


class Fault:
    """Base of the faults; a subclass is a frozen dataclass that declares its parameters.

    Attributes:
        main: the parameter that is meant where no mapping is written (``lose: target``), "" for none.
        physical: whether it needs a simulated body.
    """

    main: ClassVar[str] = ""
    physical: ClassVar[bool] = False

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

    def begin(self, staged: Staged) -> str:
        """Let it happen from the next tick on; return what it is, for people."""
        raise NotImplementedError


@dataclass(frozen=True, kw_only=True)
class Push(Fault):
    """Push the robot."""

    physical: ClassVar[bool] = True

    force: tuple[float, float, float] = param(
        minimum=-10_000, maximum=10_000, unit="N", doc="The force, in the world's directions, x y z."
    )
    duration: float = param(0.1, above=0, unit="s", doc="How long.")
    body: str = param("", doc="The body of the robot's model that is pushed; the torso if not given.")


@dataclass(frozen=True, kw_only=True)
class EStop(Fault):
    """Raise the emergency stop."""

    main: ClassVar[str] = "reason"

    reason: str = param("raised by the test", doc="Why.")


@dataclass(frozen=True, kw_only=True)
class Reset(Fault):
    """Ask for the reset of a latched stop."""

    main: ClassVar[str] = "source"

    source: str = param("the test", doc="Who asks.")


@dataclass(frozen=True, kw_only=True)
class Lose(Fault):
    """Let perception of a thing end: its last percept grows old."""

    main: ClassVar[str] = "percept"

    percept: str = param(doc="The percept.")
    duration: float | None = param(None, above=0, unit="s", doc="How long" + _FOR_GOOD)


@dataclass(frozen=True, kw_only=True)
class See(Fault):
    """Let the robot see a thing at a place, whatever the scene has of this name."""

    percept: str = param(doc="The percept.")
    position: tuple[float, float, float] = param(unit="m", doc="Where, x y z in the world.")
    confidence: float = param(0.95, minimum=0, maximum=1, doc="How sure perception is.")
    duration: float | None = param(None, above=0, unit="s", doc="How long" + _FOR_GOOD)


@dataclass(frozen=True, kw_only=True)
class Noise(Fault):
    """Let a percept be seen worse than it is."""

    main: ClassVar[str] = "percept"

    percept: str = param("", doc="The percept; all of them if not given.")
    sigma: float = param(0.0, minimum=0, unit="m", doc="Standard deviation of what is added to each coordinate.")
    drop_out: float = param(0.0, minimum=0, maximum=1, doc="Probability that an observation is lost.")
    confidence: float = param(1.0, minimum=0, maximum=1, doc="Factor of the confidence.")
    delay: float = param(0.0, minimum=0, unit="s", doc="How much later it arrives.")
    duration: float | None = param(None, above=0, unit="s", doc="How long" + _FOR_GOOD)


@dataclass(frozen=True, kw_only=True)
class Silence(Fault):
    """Let no command reach control, as if decision were stuck."""

    main: ClassVar[str] = "duration"

    duration: float = param(above=0, unit="s", doc="How long.")


@dataclass(frozen=True, kw_only=True)
class Delay(Fault):
    """Let every command reach control later, in whole ticks."""

    main: ClassVar[str] = "by"

    by: float = param(above=0, unit="s", doc="How much later.")
    duration: float | None = param(None, above=0, unit="s", doc="How long" + _FOR_GOOD)


@dataclass(frozen=True, kw_only=True)
class Weaken(Fault):
    """Let drives give less torque than they are asked for."""

    physical: ClassVar[bool] = True

    joints: list[str] = param(doc="Their joints, by name or pattern (left_*).")
    to: float = param(minimum=0, maximum=1, doc="What they still give, of what they are asked for and at most.")
    duration: float | None = param(None, above=0, unit="s", doc="How long" + _FOR_GOOD)


@dataclass(frozen=True, kw_only=True)
class Raise(Fault):
    """Let a node raise an exception in the next tick that it gets."""

    main: ClassVar[str] = "node"

    node: str = param(doc="Its path, or the end of it.")
    message: str = param("raised by the test", doc="The exception's text.")


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
