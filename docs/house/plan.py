"""The picture of the house: its floors and rooms, what is in them, and which rooms each imports."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from house.drawing import NAME, SMALL, TEXT, TITLE, WIDTH, box, line, paragraph, picture, words
from house.inside import PART_HEIGHT, Row, chip, rows
from house.rooms import PACKAGE, Floor, Room, house

_LEFT, _RIGHT = 20.0, WIDTH - 20.0
_ROOF = (20.0, 88.0)  # y of the ridge and of the eaves
_EAVES = 10.0  # how far the roof stands out
_PAD = (14.0, 9.0)  # between a wall and what is written
_WIDE = 700.0  # a room as wide as this says at its right what it imports
_IMPORTS_AT = 560.0  # from the left wall of such a room
_MOST = 0.62  # share of a floor for the one room of two with rooms inside
_TEXT_WIDTH = 196.0  # of what a room says beside its rooms
_ARROW = 14.0  # room for the arrow before what is imported
_SIGN = "v9m-3.5 -3.5l3.5 3.5l3.5 -3.5"  # that arrow


def draw() -> str:
    """Return the picture."""
    y = _ROOF[1]
    rooms: list[str] = []
    walls: list[str] = []
    for floor in house():
        placed = [_Placed(room, width) for room, width in zip(floor, _widths(floor), strict=True)]
        height = max(room.height for room in placed)
        x = _LEFT
        for room in placed:
            if x > _LEFT:
                walls.append(line(f"M{x:.1f} {y:.1f}v{height:.1f}", "door" if floor.open else "wall"))
            rooms += room.draw(x, y, height)
            x += room.width
        walls.append(line(f"M{_LEFT:g} {y:.1f}H{_RIGHT:g}", "wall"))
        y += height
    walls.append(line(f"M{_LEFT:g} {_ROOF[1]:g}V{y:.1f}H{_RIGHT:g}V{_ROOF[1]:g}", "wall"))
    return picture(f"The rooms of {PACKAGE}", y + 66, [*rooms, *walls, *_roof(), *_legend(y + 14)])


def _widths(floor: Floor) -> list[float]:
    """Return the width of each room of a floor: one with rooms inside of it needs more."""
    whole = _RIGHT - _LEFT
    full = [room for room in floor if len(room.floors) > 1]
    if len(floor.rooms) == 2 and len(full) == 1:
        return [whole * (_MOST if room in full else 1 - _MOST) for room in floor]
    return [whole / len(floor.rooms) for _ in floor]


@dataclass(frozen=True)
class _Placed:
    """A room with the width that it has on its floor, and the height that it needs then."""

    room: Room
    width: float

    @property
    def _kind(self) -> str:
        return "sober" if self.room.sober else "room"

    @property
    def _chips(self) -> Sequence[Room]:
        """The rooms inside that stand beside the name, because no contract is on them."""
        return () if len(self.room.floors) > 1 else [part for floor in self.room.floors for part in floor]

    @property
    def _rows(self) -> list[Row]:
        """The floors inside."""
        return rows(self.room.floors, self.width - _TEXT_WIDTH - 3 * _PAD[0]) if len(self.room.floors) > 1 else []

    @property
    def _beside(self) -> bool:
        """Whether what is imported stands at the right."""
        return self.width > _WIDE and len(self.room.floors) <= 1

    @property
    def _says(self) -> list[str]:
        room = self.width - 2 * _PAD[0]
        if len(self.room.floors) > 1:
            room = _TEXT_WIDTH
        elif self._beside:
            room = _IMPORTS_AT - 2 * _PAD[0]
        return TEXT.wrap(self.room.says, room)

    @property
    def _imports(self) -> list[str]:
        room = self.width - 2 * _PAD[0]
        if len(self.room.floors) > 1:
            room = _TEXT_WIDTH
        elif self._beside:
            room = self.width - _IMPORTS_AT - _PAD[0]
        return SMALL.wrap(", ".join(self.room.imports), room - _ARROW) if self.room.imports else []

    @property
    def height(self) -> float:
        """The least height of the room."""
        said, imported = NAME.line + len(self._says) * TEXT.line, len(self._imports) * SMALL.line
        text = max(said, imported) if self._beside else said + 3 + imported
        return max(text, sum(row.height for row in self._rows)) + 2 * _PAD[1]

    def draw(self, x: float, y: float, height: float) -> list[str]:
        """Return the room with its left upper corner at (x, y)."""
        left, top = x + _PAD[0], y + _PAD[1]
        parts = [box(x, y, self.width, height, kind=self._kind), words(self.room.name, left, top, NAME)]
        at = left + NAME.width(self.room.name) + 10
        for part in self._chips:
            chip_parts, width = chip(part, at, top - 1, self._kind)
            parts += chip_parts
            at += width + 6
        parts += paragraph(self._says, left, top + NAME.line, TEXT)
        if self._imports:
            below = top + NAME.line + len(self._says) * TEXT.line + 3
            at_x, at_y = (x + _IMPORTS_AT, top) if self._beside else (left, below)
            parts.append(line(f"M{at_x + 4:.1f} {at_y + 2.5:.1f}{_SIGN}", "sign"))
            parts += paragraph(self._imports, at_x + _ARROW, at_y, SMALL)
        inside = y + (height - sum(row.height for row in self._rows)) / 2
        for row in self._rows:
            parts += row.draw(left + _TEXT_WIDTH + _PAD[0], inside, self._kind)
            inside += row.height
        return parts


def _roof() -> list[str]:
    ridge, eaves = _ROOF
    middle = WIDTH / 2
    return [
        line(f"M{_LEFT - _EAVES:g} {eaves:g}L{middle:g} {ridge:g}L{_RIGHT + _EAVES:g} {eaves:g}", "wall"),
        words(PACKAGE, middle, ridge + 23, TITLE, anchor="middle"),
        words("Each room imports only from the floors below its own.", middle, ridge + 46, TEXT, anchor="middle"),
    ]


def _legend(y: float) -> list[str]:
    second, right = y + 22, WIDTH / 2
    return [
        box(_LEFT, y - 1, 16, PART_HEIGHT - 5, kind="sober sober-edge", radius=3),
        words("may know neither py_trees nor rerun, so that it works without them", _LEFT + 26, y, SMALL),
        line(f"M{_LEFT + 8:g} {second + 1:g}v13", "wall"),
        words("a wall: no imports between these rooms", _LEFT + 26, second, SMALL),
        line(f"M{right + 8:g} {y + 2.5:g}{_SIGN}", "sign"),
        words("what a room imports", right + 26, y, SMALL),
        line(f"M{right + 8:g} {second + 1:g}v13", "door"),
        words("an open wall: there may be", right + 26, second, SMALL),
    ]
