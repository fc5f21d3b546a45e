"""What stands inside of a room in the picture of the house: its folders, and files that are layers of their own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from house.drawing import PART, SMALL, box, paragraph, words
from house.rooms import Floor, Room

PART_HEIGHT = 21.0
"""Of a room inside of another that says nothing below its name."""

_CHIP_HEIGHT = 18.0
_GAP = 4.0
_PAD = 9.0  # between its outline and what is written
_MOST_LINES = 2  # of what it says below its name


@dataclass(frozen=True)
class Row:
    """Rooms beside each other inside of another, each as wide as the others.

    Attributes:
        rooms: the rooms.
        width: of all of them together.
    """

    rooms: Sequence[Room]
    width: float

    @property
    def _share(self) -> float:
        return (self.width + _GAP) / len(self.rooms) - _GAP

    @property
    def _lines(self) -> int:
        """How many lines stand below the names; a room that is alone says what it is beside its name."""
        return 0 if len(self.rooms) == 1 else max(len(self._said(room)) for room in self.rooms)

    @property
    def height(self) -> float:
        """Of the row, with the space to the next."""
        return PART_HEIGHT + self._lines * (SMALL.line - 1) + (2 if self._lines else 0) + _GAP

    def draw(self, x: float, y: float, kind: str) -> list[str]:
        """Return the row with its left upper corner at (x, y), in the style of a kind of room."""
        parts: list[str] = []
        for room in self.rooms:
            parts.append(box(x, y, self._share, self.height - _GAP, kind=f"{kind}-part {kind}-edge", radius=3))
            top = y + (PART_HEIGHT - PART.line) / 2
            parts.append(words(_name(room), x + _PAD, top, PART))
            if len(self.rooms) > 1:
                parts += paragraph(self._said(room), x + _PAD, top + PART.line, SMALL)
            elif said := self._said(room):
                parts.append(words(said[0], x + _PAD + PART.width(_name(room)) + _PAD, top, SMALL))
            x += self._share + _GAP
        return parts

    def _said(self, room: Room) -> list[str]:
        """Return what a room says, or what stands before its first colon, as far as there is room for it."""
        alone = len(self.rooms) == 1
        space = self._share - 2 * _PAD - (PART.width(_name(room)) + _PAD if alone else 0.0)
        for text in (room.says, f"{room.says.partition(':')[0].rstrip('.')}."):
            lines = SMALL.wrap(text, space)
            if len(lines) <= (1 if alone else _MOST_LINES):
                return lines
        return []


def rows(floors: Sequence[Floor], width: float) -> list[Row]:
    """Return the floors inside of a room, the highest first."""
    return [Row(floor.rooms, width) for floor in floors]


def chip(room: Room, x: float, y: float, kind: str) -> tuple[list[str], float]:
    """Return a room inside that stands beside the name of the outer one, and how wide it is."""
    width = PART.width(_name(room)) + 2 * _PAD
    text = words(_name(room), x + width / 2, y + (_CHIP_HEIGHT - PART.line) / 2, PART, anchor="middle")
    return [box(x, y, width, _CHIP_HEIGHT, kind=f"{kind}-part {kind}-edge", radius=3), text], width


def _name(room: Room) -> str:
    return f"{room.name}/" if room.is_folder else room.name
