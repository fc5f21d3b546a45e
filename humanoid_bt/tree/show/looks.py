"""What kinds of nodes and their statuses look like, the same in every drawing and in the live view."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from py_trees.common import Status

Color = tuple[int, int, int]
"""Red, green, blue, 0 to 255."""


class Shades(NamedTuple):
    """A colour for each background it is read on, where it has a contrast of at least 4.5 to 1.

    Attributes:
        light: on white paper, and on its own tint there.
        dark: on dark paper and on black, and on its own tint there; black is readable on it.
        any: where nobody knows: on white and on black.
    """

    light: Color
    dark: Color
    any: Color


STATUS_COLORS: Mapping[str, Shades] = {
    "INVALID": Shades(light=(99, 107, 117), dark=(160, 168, 180), any=(110, 117, 129)),
    "RUNNING": Shades(light=(10, 104, 198), dark=(92, 176, 255), any=(12, 116, 219)),
    "SUCCESS": Shades(light=(26, 121, 50), dark=(92, 206, 120), any=(29, 135, 55)),
    "FAILURE": Shades(light=(201, 37, 29), dark=(255, 130, 122), any=(223, 44, 34)),
}
"""The colours of the statuses in every drawing, in the viewer and on terminals."""

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
