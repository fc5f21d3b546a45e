"""The colours of the statuses can be read wherever they are shown (WCAG 2, level AA: 4.5 to 1)."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from py_trees.common import Status

import humanoid_bt
from humanoid_bt.cli.styles import STATUS_STYLES
from humanoid_bt.tree.show import Outline, OutlineNode, dot_tree, mermaid_tree, svg_tree
from humanoid_bt.tree.show.looks import DARK_PAPER, PAPER, STATUS_COLORS, Color, hexadecimal, tint

ENOUGH = 4.5
BLACK, WHITE = (0, 0, 0), (255, 255, 255)
OUTLINE = Outline(
    "t",
    "",
    tuple(OutlineNode(f"t/{s.name}", s.name, "act", "skill", -1 if i == 0 else 0) for i, s in enumerate(Status)),
)
STATUSES = {f"t/{status.name}": status for status in Status}


def luminance(color: Color) -> float:
    """Return the relative luminance of WCAG 2, 0 to 1."""
    shares = [v / 255 for v in color]
    red, green, blue = (s / 12.92 if s <= 0.04045 else ((s + 0.055) / 1.055) ** 2.4 for s in shares)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(one: Color, other: Color) -> float:
    """Return the contrast ratio of WCAG 2, 1 to 21."""
    dark, light = sorted(map(luminance, (one, other)))
    return (light + 0.05) / (dark + 0.05)


def test_contrast_is_that_of_the_standard() -> None:
    assert contrast(BLACK, WHITE) == pytest.approx(21)
    assert contrast((119, 119, 119), WHITE) == pytest.approx(4.48, abs=0.01)  # the grey that just fails
    assert contrast((118, 118, 118), WHITE) == pytest.approx(4.54, abs=0.01)  # and the one that just passes


@pytest.mark.parametrize("status", Status)
def test_a_status_stands_out_on_every_background(status: Status) -> None:
    shades = STATUS_COLORS[status.name]
    assert contrast(shades.light, PAPER) >= ENOUGH
    assert contrast(shades.light, tint(shades.light)) >= ENOUGH
    assert contrast(shades.dark, DARK_PAPER) >= ENOUGH
    assert contrast(shades.dark, tint(shades.dark, DARK_PAPER)) >= ENOUGH
    assert contrast(shades.dark, BLACK) >= ENOUGH
    assert min(contrast(shades.any, WHITE), contrast(shades.any, BLACK)) >= ENOUGH


def test_no_two_statuses_look_alike() -> None:
    for shade in ("light", "dark", "any"):
        assert len({getattr(shades, shade) for shades in STATUS_COLORS.values()}) == len(Status)


@pytest.mark.parametrize("draw", [dot_tree, mermaid_tree])
def test_a_drawing_without_a_theme_has_the_colours_of_light_paper(draw: Callable[..., str]) -> None:
    used = set(re.findall(r"(?<![\w&])#[0-9a-f]{6}\b", draw(OUTLINE, STATUSES)))
    light = [shades.light for shades in STATUS_COLORS.values()]
    assert used - {"#1f2328"} == {hexadecimal(color) for shade in light for color in (shade, tint(shade))}


def test_a_picture_has_the_colours_of_both_themes() -> None:
    light, dark = svg_tree(OUTLINE, STATUSES).split("@media (prefers-color-scheme: dark)")
    for status in Status:
        shades = STATUS_COLORS[status.name]
        rule = f".{status.name.lower()} .mark {{ color: %s;"
        assert rule % hexadecimal(shades.light) in light
        assert rule % hexadecimal(shades.dark) in dark


def test_a_terminal_has_the_colours_that_go_with_any_theme() -> None:
    assert {Status[name]: hexadecimal(shades.any) for name, shades in STATUS_COLORS.items()} == STATUS_STYLES


def test_nobody_else_has_colours_for_statuses() -> None:
    named = re.compile(
        r"(RUNNING|SUCCESS|FAILURE|INVALID)\"?: *\(*[\"(][^\n]*(?:green|red|cyan|yellow|blue|dim|#|\d+, \d+, \d+)"
    )
    root = Path(humanoid_bt.__file__).parent
    found = {path.relative_to(root).as_posix() for path in root.rglob("*.py") if named.search(path.read_text())}
    assert found <= {"tree/show/looks.py"}
