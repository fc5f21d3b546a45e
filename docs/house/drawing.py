"""What both pictures of the house are drawn with: measured text, boxes, and one style for light and dark pages."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape

from humanoid_bt.tree.show.looks import DARK_PAPER, NEUTRAL, PAPER, Color, hexadecimal, mix
from humanoid_bt.tree.show.metrics import FONT, text_width, wrap

WIDTH = 900.0
"""Of a picture: about that of a page on GitHub, so that letters are shown in their size."""

COLORS: dict[str, Color] = {
    "sober": (14, 138, 138),
    "room": (99, 102, 190),
    "percept": (37, 110, 222),
    "command": (200, 90, 10),
    "other": NEUTRAL.color,
}
"""What is drawn -> its colour on a light page."""

_TINT, _DARK_TINT = 0.09, 0.19  # how much of a colour is in the fill of its boxes
_INK, _DARK_INK = (31, 35, 40), (230, 237, 243)
_MUTED, _DARK_MUTED = (87, 96, 106), (157, 167, 179)


@dataclass(frozen=True)
class Look:
    """Letters.

    Attributes:
        name: class in the style.
        size: of the letters.
        line: height of a line of them.
        bold: whether they are bold.
        muted: whether they stand back.
    """

    name: str
    size: float
    line: float
    bold: bool = False
    muted: bool = False

    def width(self, text: str) -> float:
        """Return how wide a text is."""
        return text_width(text, self.size, self.bold)

    def wrap(self, text: str, room: float) -> list[str]:
        """Break a text into lines."""
        return wrap(text, room, self.size, self.bold)


TITLE = Look("title", 17.0, 22.0, bold=True)
NAME = Look("name", 14.0, 19.0, bold=True)
PART = Look("part", 11.5, 15.0, bold=True)
TEXT = Look("text", 12.0, 16.0)
SMALL = Look("small", 11.0, 15.0, muted=True)
LOOKS = (TITLE, NAME, PART, TEXT, SMALL)


def words(text: str, x: float, y: float, look: Look, *, anchor: str = "start", kind: str = "") -> str:
    """Return a line of text whose upper side is at y, of a kind that the style knows."""
    baseline = y + look.line / 2 + 0.35 * look.size
    where = "" if anchor == "start" else f' text-anchor="{anchor}"'
    classes = " ".join(filter(None, (look.name, kind)))
    return f'<text class="{classes}" x="{x:g}" y="{baseline:.1f}"{where}>{escape(text)}</text>'


def paragraph(lines: Sequence[str], x: float, y: float, look: Look) -> list[str]:
    """Return lines of text below each other."""
    return [words(line, x, y + i * look.line, look) for i, line in enumerate(lines)]


def box(x: float, y: float, width: float, height: float, *, kind: str, radius: float = 0.0) -> str:
    """Return a box of a kind that the style knows."""
    corner = f' rx="{radius:g}"' if radius else ""
    return f'<rect class="{kind}" x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}"{corner}/>'


def line(path: str, kind: str) -> str:
    """Return a line of a kind that the style knows."""
    return f'<path class="{kind}" d="{path}"/>'


def picture(title: str, height: float, parts: Sequence[str]) -> str:
    """Return a whole picture."""
    size = f'width="{WIDTH:.0f}" height="{height:.0f}" viewBox="0 0 {WIDTH:.0f} {height:.0f}"'
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img">',
            f"<title>{escape(title)}</title>",
            f"<style>\n{_style()}</style>",
            '<rect class="paper" width="100%" height="100%" rx="8"/>',
            *parts,
            "</svg>\n",
        ]
    )


def _style() -> str:
    fonts = [
        f".{look.name} {{ font-size: {look.size:g}px{'; font-weight: bold' if look.bold else ''} }}" for look in LOOKS
    ]
    return "\n".join(
        [
            f"text {{ font-family: {FONT} }}",
            *fonts,
            ".wall, .door, .way, .back, .sign { fill: none; stroke-width: 1.5 }",
            ".wall, .door, .way, .back, .sign { stroke-linecap: round; stroke-linejoin: round }",
            ".door, .back { stroke-dasharray: 4 5 }",
            ".way, circle { stroke-width: 3 }",
            *_rules(dark=False),
            "@media (prefers-color-scheme: dark) {",
            *_rules(dark=True),
            "}\n",
        ]
    )


def _rules(dark: bool) -> list[str]:
    paper, ink, muted = (DARK_PAPER, _DARK_INK, _DARK_MUTED) if dark else (PAPER, _INK, _MUTED)
    shown = {name: mix(color, (255, 255, 255), 0.7) if dark else color for name, color in COLORS.items()}
    rules = [
        f".paper {{ fill: {hexadecimal(paper)} }}",
        f"text {{ fill: {hexadecimal(ink)} }}",
        f".{', .'.join(look.name for look in LOOKS if look.muted)} {{ fill: {hexadecimal(muted)} }}",
        f".number {{ fill: {hexadecimal(paper)} }}",
        f".wall, .door, .back {{ stroke: {hexadecimal(mix(shown['other'], paper, 0.7))} }}",
        f".sign {{ stroke: {hexadecimal(muted)} }}",
    ]
    for name, color in COLORS.items():
        fill = mix(color, paper, _DARK_TINT if dark else _TINT)
        rules.append(f".{name} {{ fill: {hexadecimal(fill)} }}")
        rules.append(f".{name}-part {{ fill: {hexadecimal(paper)} }}")
        rules.append(f".{name}-edge {{ stroke: {hexadecimal(mix(shown[name], paper, 0.5))} }}")
        rules.append(f".{name}-line {{ stroke: {hexadecimal(shown[name])} }}")
        rules.append(f".{name}-number {{ fill: {hexadecimal(shown[name])} }}")
        rules.append(f".{name}-between {{ fill: {hexadecimal(paper)} }}")
    return rules
