"""Seeds as people write them: ``3``, ``0-9``, ``0-9, 20``, ``[0, 4, 7]``."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.items import Item

MOST = 1_000_000
"""Most seeds of one list, and the largest seed."""

_EXAMPLE = "like 3, 0-9, '0-9, 20' or [0, 4, 7]"
_RANGE = re.compile(r"\s*(\d{1,9})\s*(?:-\s*(\d{1,9})\s*)?")


@dataclass(frozen=True)
class Seeds:
    """Seeds, in their order, each once.

    Attributes:
        values: them.
    """

    values: tuple[int, ...] = (0,)

    described = "seeds"

    def __iter__(self) -> Iterator[int]:
        return iter(self.values)

    def __len__(self) -> int:
        return len(self.values)

    @classmethod
    def parse(cls, text: str) -> Seeds:
        """Return the seeds that a text says.

        Raises:
            UserError: it says none.
        """
        found: dict[int, None] = {}
        for part in text.split(","):
            match = _RANGE.fullmatch(part)
            first = int(match[1]) if match else 1
            last = int(match[2] or match[1]) if match else 0
            if last < first or last >= MOST:
                message = f"{text!r} are no seeds"
                raise UserError(message, hint=f"{_EXAMPLE}, each below {MOST:,}", code="wrong-type")
            found |= dict.fromkeys(range(first, last + 1))
        return cls(tuple(found))

    @classmethod
    def from_item(cls, item: Item, name: str) -> Seeds:
        """Read seeds from a YAML value: a number, a text, or a list of these; raises UserError."""
        if item.value == []:
            raise UserError(f"{name!r} has no seeds", item.place, _EXAMPLE, "wrong-length")
        parts = item.value if isinstance(item.value, list) else [item]
        found: dict[int, None] = {}
        for part in parts:
            value = part.value
            if isinstance(value, (bool, float)) or not isinstance(value, (int, str)):
                raise UserError(f"{name!r} cannot be {part.kind}", part.place, _EXAMPLE, "wrong-type")
            try:
                found |= dict.fromkeys(cls.parse(str(value)))
            except UserError as error:
                problem = error.problems[0]
                raise UserError(problem.message, part.place, problem.hint, problem.code) from error
        return cls(tuple(found))

    def __str__(self) -> str:
        """Return them as they are written shortest: ``0-9, 20``."""
        runs: list[list[int]] = []
        for seed in self.values:
            if runs and seed == runs[-1][-1] + 1:
                runs[-1].append(seed)
            else:
                runs.append([seed])
        return ", ".join(f"{run[0]}-{run[-1]}" if len(run) > 1 else str(run[0]) for run in runs)
