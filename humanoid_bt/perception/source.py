"""The base class of a percept source.

A source is one file in a workspace's ``perception/`` folder:

    class DoorSign(PerceptSource):
        \"\"\"Read the sign on the door.\"\"\"

        rate = 5.0
        needs = ("camera",)
        door: PerceptName = param("door", doc="Percept that it publishes.")

        def look(self, now: Moment) -> Iterable[Percept]: ...

Its name in scenes and trees is the class name in snake_case.
"""

from __future__ import annotations

import abc
import typing
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from humanoid_bt.core.messages import Percept, State, Truth
from humanoid_bt.core.params import PerceptName, own, params_of
from humanoid_bt.core.texts import snake_case
from humanoid_bt.perception.picture import Picture
from humanoid_bt.plant.scene import Scene

Need = Literal["state", "camera", "scene"]
"""What a source can need."""

NEEDS: tuple[Need, ...] = typing.get_args(Need)
"""All of it."""


@dataclass(frozen=True)
class Moment:
    """What a source is given to look at.

    Attributes:
        time: engine time [s]; the stamp of what is seen now.
        state: what control believes of the robot; None unless the source needs ``state``.
        picture: what the head camera sees; None unless it needs ``camera``.
        truth: where the simulated robot really is; None unless it needs ``scene``, as a simulated sensor does.
    """

    time: float
    state: State | None = None
    picture: Picture | None = None
    truth: Truth | None = None


class PerceptSource(abc.ABC):
    """Something that sees: it publishes percepts, at a rate of its own.

    Subclasses declare parameters with :func:`~humanoid_bt.core.params.param`; instances have their values as
    attributes. Parameters of the type ``PerceptName`` name the percepts that it publishes.

    Args:
        values: parameter values, already of their declared types.

    Attributes:
        rate: how often it looks [Hz]: 50 divided by a whole number.
        needs: what it is given to look at: ``state``, ``camera``, ``scene``.
        patience: how long a look may take on the wall clock until the source counts as blocked [s].
        names: the percepts that it publishes in this run; there from :meth:`setup` on.
        random: random numbers of its own, from the run's seed; there from :meth:`setup` on.
        scene: what surrounds the robot, if it needs ``scene``; there from :meth:`setup` on.
    """

    rate: ClassVar[float] = 10.0
    needs: ClassVar[tuple[Need, ...]] = ()
    patience: ClassVar[float] = 2.0
    names: Collection[str] = ()
    random: np.random.Generator
    scene: Scene

    def __init__(self, **values: Any) -> None:
        declared = params_of(type(self))
        for name, spec in declared.items():
            if name not in values and spec.required:
                raise TypeError(f"{source_name(type(self))} needs the parameter {name!r}")
            setattr(self, name, own(values.get(name, spec.default)))

    @classmethod
    def publishes(cls, values: Mapping[str, Any]) -> Collection[str]:
        """Return the names of the percepts that it publishes with these parameter values.

        Those that its parameters of type ``PerceptName`` give. Checks ask it before the run.

        Args:
            values: every parameter by name, defaults put in.
        """
        return list(dict.fromkeys(name for parameter in names_percepts(cls) for name in _texts(values[parameter])))

    def setup(self) -> None:  # noqa: B027 (most have nothing to load)
        """Load what it takes to look, once, before the first look. It may take a minute."""

    @abc.abstractmethod
    def look(self, now: Moment) -> Iterable[Percept]:
        """Return what is seen now, positions in the robot's base frame."""

    def why_unseen(self, name: str) -> str:
        """Return why it has never published a percept, in a few words for people."""
        return f"{source_name(type(self))} has not found it"


def source_name(cls: type) -> str:
    """Return the name of a source in scenes and trees: snake_case, or its ``source_name`` if it has one."""
    named = vars(cls).get("source_name")
    return named if isinstance(named, str) else snake_case(cls.__name__)


def names_percepts(cls: type) -> list[str]:
    """Return the parameters of a class that name percepts."""
    return [
        name
        for name, spec in params_of(cls).items()
        if spec.type is PerceptName or PerceptName in typing.get_args(spec.type)
    ]


def _texts(value: Any) -> Iterable[str]:
    return [value] if isinstance(value, str) else value or ()
