"""What a recording is told to show: the tree, and what the head camera has in the picture."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from humanoid_bt.tree.show.outline import Outline

Wanted = Literal["auto"] | bool
"""Whether there shall be pictures: "auto" for where they do not hold up the run."""

_WIDTH = 320  # pixels
_WIDEST = 2.4  # rad; a flat picture of a wider angle is all edges


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


@dataclass(frozen=True)
class View:
    """What a camera has in the picture.

    Attributes:
        body: that carries it.
        horizontal, vertical: full angles [rad].
    """

    body: str
    horizontal: float
    vertical: float

    @property
    def angle(self) -> float:
        """Angle from the top to the bottom of the picture [rad]."""
        return min(self.vertical, _WIDEST)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture [pixels]."""
        return _WIDTH, round(_WIDTH * math.tan(self.angle / 2) / math.tan(min(self.horizontal, _WIDEST) / 2))
