"""The rooms of the package, and the ways of a percept and of a command through them."""

from __future__ import annotations

from collections.abc import Iterable

import blocks
from house.rooms import PACKAGE, Room
from house.rooms import house as floors
from house.ways import COMMAND, PERCEPT, Step

from parts.markdown import table


def rooms() -> str:
    """Return the table of the rooms, the highest first."""
    return table(("room", "what it is"), [_row(room) for floor in floors() for room in floor])


def inner_rooms() -> str:
    """Return the table of what is inside of the rooms with layers of their own."""
    outer = [room for floor in floors() for room in floor if len(room.floors) > 1]
    rows = [_row(part) for room in outer for floor in room.floors for part in floor]
    return table(("inside", "what it is"), rows)


def percept_way() -> str:
    """Return the steps from a thing in the scene to the skill that acts on it."""
    return _way(PERCEPT)


def command_way() -> str:
    """Return the steps from a skill to the joints."""
    return _way(COMMAND)


def _row(room: Room) -> tuple[str, str]:
    inside = room.path.relative_to(blocks.ROOT / PACKAGE)
    name = f"{inside}/" if room.is_folder else str(inside)
    return f"[`{name}`](../{room.path.relative_to(blocks.ROOT)})", room.says


def _way(steps: Iterable[Step]) -> str:
    return "\n".join(
        f"{number}. [`{step.file}`](../{step.path.relative_to(blocks.ROOT)}), `{step.name}`. {step.does}"
        for number, step in enumerate(steps, 1)
    )
