"""The style of SVG pictures of trees: one set of rules for light pages, one for dark ones."""

from __future__ import annotations

from humanoid_bt.tree.show.looks import DARK_PAPER, LOOKS, NEUTRAL, PAPER, STATUS_COLORS, Color, hexadecimal, mix, tint
from humanoid_bt.tree.show.metrics import FONT

_INK, _DARK_INK = (31, 35, 40), (230, 237, 243)
_MUTED, _DARK_MUTED = (87, 96, 106), (157, 167, 179)
_LINE, _DARK_LINE = (140, 149, 159), (110, 118, 129)


def _rules(paper: Color, ink: Color, muted: Color, line: Color) -> list[str]:
    dark = paper != PAPER
    rules = [
        f".paper {{ fill: {hexadecimal(paper)} }}",
        f".title, .name {{ fill: {hexadecimal(ink)} }}",
        f".small, .type, .branch {{ fill: {hexadecimal(muted)} }}",
        f".said {{ fill: {hexadecimal(ink)} }}",
        f".edge {{ stroke: {hexadecimal(line)} }}",
        f".sign {{ stroke: {hexadecimal(muted)} }}",
    ]
    colors = {kind: look.color for kind, look in LOOKS.items()} | {"other": NEUTRAL.color}
    for name, color in colors.items():
        shown = mix(color, (255, 255, 255), 0.75) if dark else color
        rules.append(f".{name} .box {{ fill: {hexadecimal(tint(color, paper))}; stroke: {hexadecimal(shown)} }}")
    statuses = {name.lower(): shades.dark if dark else shades.light for name, shades in STATUS_COLORS.items()}
    for name, color in statuses.items():
        rules.append(f".{name} .box {{ fill: {hexadecimal(tint(color, paper))}; stroke: {hexadecimal(color)} }}")
        rules.append(f".{name} .mark {{ color: {hexadecimal(color)}; stroke: currentColor }}")
    running = hexadecimal(statuses["running"])
    return [*rules, f".inner {{ stroke: {hexadecimal(line)} }}", f".edge.running {{ stroke: {running} }}"]


def _style() -> str:
    rules = [
        f"text {{ font-family: {FONT}; font-size: 11px }}",
        ".title { font-size: 16px; font-weight: bold }",
        ".name { font-size: 13px; font-weight: bold }",
        ".type, .branch { font-style: italic }",
        ".box { stroke-width: 1.5 }",
        ".edge, .sign, .mark, .inner { fill: none; stroke-width: 1.5; stroke-linecap: round; stroke-linejoin: round }",
        ".mark { stroke-width: 2.2 }",
        ".aside { stroke-dasharray: 5 4 }",
        ".running .mark { fill: currentColor }",
        ".edge.running { stroke-width: 2.5 }",
        *_rules(PAPER, _INK, _MUTED, _LINE),
        "@media (prefers-color-scheme: dark) {",
        *_rules(DARK_PAPER, _DARK_INK, _DARK_MUTED, _DARK_LINE),
        "}",
    ]
    return "\n".join(rules) + "\n"


STYLE = _style()
"""The text of the picture's ``style`` element."""
