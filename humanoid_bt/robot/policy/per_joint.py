"""Numbers for joints as they are written: one for all, a list, by names, or the key under which the model has them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from humanoid_bt.core.errors import Problem, UserError, nearest
from humanoid_bt.core.items import Item
from humanoid_bt.core.messages import Array
from humanoid_bt.core.params import Param
from humanoid_bt.core.patterns import matches, matching
from humanoid_bt.core.reading import convert
from humanoid_bt.robot.overruled import overruled
from humanoid_bt.robot.policy.network import Metadata

_KEY = "metadata"


@dataclass(frozen=True)
class FromModel:
    """The key of the model's metadata that holds a value.

    Attributes:
        key: it.
        item: where it is written.
    """

    key: str
    item: Item

    @classmethod
    def of(cls, item: Item) -> Self | None:
        """Return what ``{metadata: KEY}`` stands for, None if that is not what is written."""
        if isinstance(item.value, dict) and set(item.value) == {_KEY} and isinstance(item.value[_KEY].value, str):
            return cls(item.value[_KEY].value, item.value[_KEY])
        return None

    def read(self, metadata: Metadata) -> Any:
        """Return the value.

        Raises:
            UserError: the model's metadata has no such key.
        """
        if self.key not in metadata:
            message = f"the model's metadata has no {self.key!r}"
            hint = nearest(self.key, metadata) or "it has no metadata at all: write the value here"
            raise UserError(message, self.item.place, hint, code="policy")
        return metadata[self.key]


@dataclass(frozen=True)
class Joints:
    """Joints by name: a list, or the key under which the model has it."""

    value: list[str] | FromModel
    item: Item
    described: ClassVar[str] = "list of names or {metadata: KEY}"

    @classmethod
    def from_item(cls, item: Item, name: str) -> Self:
        """Read it.

        Raises:
            UserError: it is neither.
        """
        return cls(FromModel.of(item) or convert(Param(name, list[str], doc=cls.described), item), item)

    def names(self, metadata: Metadata) -> list[str]:
        """Return the names.

        Raises:
            UserError: the model does not have them.
        """
        found = self.value.read(metadata) if isinstance(self.value, FromModel) else self.value
        names = [found] if isinstance(found, str) else found
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            message = f"the model's metadata has no list of names there, but {found!r}"
            raise UserError(message, self.item.place, code="policy")
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise UserError(f"the joint {twice[0]!r} is there twice", self.item.place, code="policy")
        return names


@dataclass(frozen=True)
class PerJoint:
    """A number for each joint."""

    value: float | list[float] | dict[str, float] | FromModel
    item: Item
    unit: ClassVar[str] = ""
    described: ClassVar[str] = "number, list, mapping of joint patterns to numbers, or {metadata: KEY}"

    @classmethod
    def from_item(cls, item: Item, name: str) -> Self:
        """Read it.

        Raises:
            UserError: it is none of these.
        """
        if found := FromModel.of(item):
            return cls(found, item)
        kinds: dict[type, Any] = {dict: dict[str, float], list: list[float]}
        spec = Param(name, kinds.get(type(item.value), float), doc=cls.described, unit=cls.unit)
        return cls(convert(spec, item), item)

    def values(
        self,
        names: Sequence[str],
        metadata: Metadata,
        others: float | None = None,
        known: Sequence[str] | None = None,
    ) -> Array:
        """Return the number of each joint, shape (len(names),).

        Args:
            names: of the joints, in their order.
            metadata: of the model.
            others: of a joint that no pattern names; None if each must be named.
            known: all joints of the policy, of which metadata may have the numbers; these if None.

        Raises:
            UserError: there is not one for each joint.
        """
        known = known or names
        value, source, everyone = self.value, "", names
        if isinstance(value, FromModel):
            everyone, source = known, f" in {value.key!r} of the model's metadata"
            value = value.read(metadata)
        if isinstance(value, dict):
            whose = "of the policy" if len(everyone) == len(known) else "that the policy moves"
            numbers = self._named(value, names, everyone, whose, source, others)
        else:
            numbers = self._listed(value, source)
            if numbers.size == 1 and numbers.ndim <= 1:
                numbers = np.full(len(names), numbers.item())
            elif numbers.shape == (len(everyone),):
                numbers = numbers[[everyone.index(name) for name in names]]
        if numbers.shape != (len(names),):
            there = numbers.size if numbers.ndim <= 1 else f"a list of lists of {numbers.shape[-1]}"
            message = f"there must be {len(names)} numbers, one for each joint, not {there}{source}"
            raise UserError(message, self.item.place, f"in this order: {', '.join(names)}", code="policy")
        if not np.isfinite(numbers).all():
            raise UserError(f"a number is not finite{source}", self.item.place, code="policy")
        return numbers

    def _listed(self, value: Any, source: str) -> Array:
        try:
            return np.asarray(value, dtype=float)
        except (TypeError, ValueError):
            message = f"there must be numbers, not {value!r}{source}"
            raise UserError(message, self.item.place, code="policy") from None

    def _named(
        self,
        value: dict[str, Any],
        names: Sequence[str],
        everyone: Sequence[str],
        whose: str,
        source: str,
        others: float | None,
    ) -> Array:
        problems: list[Problem] = []
        found: list[float] = []
        places = self.item.key_places
        for pattern in value:
            if not matching(everyone, pattern):
                where = places.get(pattern, self.item.place)
                hint = nearest(pattern, everyone)
                message = f"no joint {whose} matches {pattern!r}{source}"
                problems.append(Problem(message, where, hint, "unknown-joint"))
        problems += overruled(((one, one, places.get(one, self.item.place)) for one in value), everyone, source)
        for name in names:
            key = next((one for one in value if matches(name, one)), None)
            if key is None and others is None:
                problems.append(
                    Problem(f"nothing here matches the joint {name!r}{source}", self.item.place, code="policy")
                )
            found.append(others or 0.0 if key is None else value[key])
        if problems:
            raise UserError(problems)
        return self._listed(found, source)


class Angles(PerJoint):
    """An angle for each joint."""

    unit: ClassVar[str] = "rad"


def from_model(key: str, item: Item) -> Item:
    """Return what ``{metadata: KEY}`` would be in the place of what is not written, as an item."""
    return replace(item, value={_KEY: Item(key, item.place)}, key_places={})
