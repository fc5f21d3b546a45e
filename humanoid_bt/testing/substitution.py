"""Stand-ins: nodes that do what a test says in the place of a tree's own."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Literal, Self

from humanoid_bt.core.errors import Place, UserError
from humanoid_bt.core.items import Item, item_of
from humanoid_bt.core.params import param
from humanoid_bt.core.reading import read

Answered = Literal["success", "failure", "running"]


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What a stand-in does once it is started."""

    status: Answered = param(doc="What it answers in the end; running if it goes on until it is halted.")
    after: float = param(0.0, minimum=0, unit="s", doc="How long it runs before.")
    feedback: str = param("", doc="What it says then.")
    results: dict[str, Any] = param({}, doc="What it reports, by the names that the skill declares.")


@dataclass(frozen=True)
class Replacement:
    """What stands in a node's place.

    In YAML ``success``, ``failure`` or ``running``, a list of answers, or ``{recorded: FILE}``.

    Attributes:
        answers: what it does each time it is started; the last of them from then on.
        recorded: the recording in which the node did that, None if the answers say it.
    """

    answers: tuple[Answer, ...] = ()
    recorded: Path | None = None

    described: ClassVar[str] = "replacement"

    @classmethod
    def of(cls, value: Any, node: str) -> Replacement:
        """Return what a value of a test stands for.

        Raises:
            UserError: it is none.
        """
        return value if isinstance(value, Replacement) else cls.from_item(item_of(value, Place("replace")), node)

    @classmethod
    def from_item(cls, item: Item, name: str) -> Self:
        """Read a replacement from a YAML value; raises UserError."""
        value = item.value
        if isinstance(value, str) and value in ("success", "failure", "running"):
            return cls((read(Answer, Item({"status": item}, item.place), repr(name)),))
        if isinstance(value, dict) and "recorded" in value:
            return cls(recorded=Path(read(_Recorded, item, repr(name)).recorded))
        if isinstance(value, dict):
            return cls((read(Answer, item, f"the answer of {name!r}"),))
        if isinstance(value, list) and value:
            return cls(tuple(read(Answer, part, f"the answer of {name!r}") for part in value))
        hint = "success, failure, running, a list of {status, after, feedback, results}, or {recorded: FILE}"
        raise UserError(f"nothing can stand in for {name!r} like this", item.place, hint, "wrong-type")


@dataclass(frozen=True, kw_only=True)
class _Recorded:
    recorded: str = param(doc="A recording in which the node ran.")
