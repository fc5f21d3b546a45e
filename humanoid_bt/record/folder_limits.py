"""How much a folder of recordings keeps, as its ``limits.yaml`` says."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from humanoid_bt.core.errors import Problem
from humanoid_bt.core.items import Item
from humanoid_bt.core.params import param
from humanoid_bt.core.reading import read
from humanoid_bt.core.sizes import VALID, read_size
from humanoid_bt.files import document

FILE = "limits.yaml"
"""Name of the file in the folder."""


@dataclass(frozen=True, kw_only=True)
class FolderLimits:
    """What a folder of recordings keeps; when a run begins, the oldest ones beyond that are removed."""

    format: int = param(1, doc="Version of this file's form: 1.", minimum=1, maximum=1)
    recordings: int = param(500, doc="Most recordings.", minimum=1)
    size: str = param("20 GB", doc="Most bytes of all of them together, such as 20 GB.")

    @property
    def bytes(self) -> int:
        """Most bytes of all recordings together."""
        return read_size(self.size) or 0

    @staticmethod
    def mistakes(item: Item, values: Mapping[str, Any]) -> Iterator[Problem]:
        """Return what is no size."""
        if "size" in values and read_size(values["size"]) is None:
            yield Problem(
                f"'size' must be {VALID}, not {values['size']!r}", item.value["size"].place, code="wrong-type"
            )


def load_limits(folder: Path) -> FolderLimits:
    """Return the limits of a folder: those of its file, or the usual ones without one.

    Raises:
        UserError: the file has mistakes.
    """
    path = folder / FILE
    if not path.exists():
        return FolderLimits()
    limits: FolderLimits = read(FolderLimits, document.load(path), "the file")
    return limits
