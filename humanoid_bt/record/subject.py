"""What a recording is told to show: the tree, and whether there are pictures of the head camera."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from humanoid_bt.tree.show.outline import Outline

Wanted = Literal["auto"] | bool
"""Whether there shall be pictures: "auto" for where they do not hold up the run."""


@dataclass(frozen=True)
class TreeView:
    """What is shown of a tree.

    Attributes:
        outline: what is drawn of it.
        source: text of the tree file.
        file: its name.
    """

    outline: Outline
    source: str = ""
    file: str = ""
