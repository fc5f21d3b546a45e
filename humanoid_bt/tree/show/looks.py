"""What kinds of nodes and their statuses look like, the same in every drawing and in the live view."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from py_trees.common import Status

Color = tuple[int, int, int]
"""Red, green, blue, 0 to 255."""

STATUS_COLORS: dict[str, Color] = {
    "INVALID": (92, 99, 110),
    "RUNNING": (66, 153, 245),
    "SUCCESS": (64, 180, 90),
    "FAILURE": (232, 74, 74),
}
STATUS_GLYPHS = {"INVALID": "○", "RUNNING": "▶", "SUCCESS": "✓", "FAILURE": "✗"}
MARKS = {status: STATUS_GLYPHS[status.name] for status in Status}
"""How a status is shown."""

PAPER: Color = (255, 255, 255)
DARK_PAPER: Color = (13, 17, 23)
_TINT, _DARK_TINT = 0.12, 0.2  # how much of a colour is in the fill of its nodes


class Look(NamedTuple):
    """What nodes of a kind look like.

    Attributes:
        color: of their outline.
        shape: one of the shapes that every drawing knows: box, round, cut, pill or double.
    """

    color: Color
    shape: str


NEUTRAL = Look((110, 119, 129), "box")
"""What nodes of any other kind look like."""

LOOKS: Mapping[str, Look] = {
    "composite": Look((100, 116, 139), "round"),
    "decorator": Look((191, 135, 0), "cut"),
    "condition": Look((137, 87, 229), "pill"),
    "action": Look((190, 75, 134), "box"),
    "skill": Look((14, 138, 138), "box"),
    "subtree": Look((110, 119, 129), "double"),
}
"""Looks by the kind of node, as far as they are told apart."""


def look_of(kind: str) -> Look:
    """Return what nodes of a kind look like."""
    return LOOKS.get(kind, NEUTRAL)


def tint(color: Color, paper: Color = PAPER) -> Color:
    """Return the colour of the fill of what has an outline of a colour."""
    share = _TINT if paper == PAPER else _DARK_TINT
    return mix(color, paper, share)


def mix(color: Color, other: Color, share: float) -> Color:
    """Return a mixture with this share of the first colour."""
    red, green, blue = (round(share * a + (1 - share) * b) for a, b in zip(color, other, strict=True))
    return red, green, blue


def hexadecimal(color: Color) -> str:
    """Return a colour as ``#rrggbb``."""
    return "#{:02x}{:02x}{:02x}".format(*color)
