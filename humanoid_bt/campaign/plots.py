"""Plots as inline SVG, whose colours are those of the page that they stand on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

from humanoid_bt.campaign.statistics import Spread
from humanoid_bt.campaign.summary import Level, between, percent
from humanoid_bt.core.units import readable

_WIDTH, _HEIGHT = 360.0, 150.0
_PAD = (10.0, 8.0, 34.0, 34.0)  # left, top, right (half of a number), bottom
_BINS = 24  # at most
_ROW = 24.0  # height of a level
_NAMES = 130.0  # columns of pixels for the names of levels
_TICKS = (0.0, 0.5, 1.0)

STYLE = """\
svg { max-width: 100%; height: auto; display: block }
svg text { font: 11px system-ui, sans-serif; fill: var(--muted) }
.bar { fill: var(--good) } .axis { stroke: var(--line) } .mark { stroke: var(--ink); stroke-dasharray: 3 3 }
.range { stroke: var(--good); stroke-width: 2 } .dot { fill: var(--good) } svg .name { fill: var(--ink) }
.lost { fill: var(--bad) } .range.lost { stroke: var(--bad) } .gained { fill: var(--good) }
"""
"""Rules for what is drawn here, of the page's colours ink, muted, line, good, bad."""


def histogram(spread: Spread, unit: str, title: str) -> str:
    """Return how the values of a quantity are spread, with its median."""
    values = spread.values
    low, high = values[0], values[-1]
    bins = max(1, min(_BINS, math.ceil(math.sqrt(len(values))))) if high > low else 1
    counts = [0] * bins
    for value in values:
        counts[min(int((value - low) / (high - low) * bins), bins - 1) if high > low else 0] += 1
    left, top, right, bottom = _PAD
    width, height = _WIDTH - left - right, _HEIGHT - top - bottom
    step = width / bins
    parts = []
    for number, count in enumerate(counts):
        tall = height * count / max(counts)
        ends = [readable(low + (number + side) * (high - low) / bins, unit) for side in (0, 1)]
        parts.append(
            f'<rect class="bar" x="{left + number * step + 0.5:.1f}" y="{top + height - tall:.1f}" '
            f'width="{max(step - 1, 1):.1f}" height="{tall:.1f}"><title>{count}: {ends[0]} to {ends[1]}</title></rect>'
        )
    base = top + height
    parts.append(f'<path class="axis" d="M{left} {base}h{width:.1f}"/>')
    middle = spread.quantile(0.5)
    at = left + (width * (middle - low) / (high - low) if high > low else width / 2)
    parts.append(f'<path class="mark" d="M{at:.1f} {top}V{base}"/>')
    parts.append(_text(left, base + 14, readable(low, unit), "start"))
    if high > low:
        parts.append(_text(left + width, base + 14, readable(high, unit), "end"))
    parts.append(_text(at, base + 28, f"median {readable(middle, unit)}", _anchor(at)))
    return _svg(_WIDTH, _HEIGHT, title, parts)


def rates(levels: Sequence[Level], title: str) -> str:
    """Return the success of each level with its interval, a row each."""
    height = _ROW * len(levels) + 22
    width = _WIDTH - _NAMES - 24
    parts = []
    for share in _TICKS:
        x = _NAMES + width * share
        parts.append(f'<path class="axis" d="M{x:.1f} 2V{height - 18:.1f}"/>')
        parts.append(_text(x, height - 5, percent(share), "middle"))
    for number, level in enumerate(levels):
        y = _ROW * (number + 0.5) + 2
        name = level.text if len(level.text) <= 22 else f"…{level.text[-21:]}"
        rate = level.success
        parts.append(f'<text class="name" x="{_NAMES - 8}" y="{y + 4:.1f}" text-anchor="end">{escape(name)}</text>')
        low, high = (_NAMES + width * end for end in rate.interval)
        lost = "" if rate.count else " lost"
        parts.append(f'<path class="range{lost}" d="M{low:.1f} {y:.1f}H{high:.1f}"/>')
        told = f"{percent(rate.share)} ({between(rate.interval)}), {rate.count} of {rate.of}"
        x = _NAMES + width * rate.share
        parts.append(f'<circle class="dot{lost}" cx="{x:.1f}" cy="{y:.1f}" r="4.5"><title>{told}</title></circle>')
    return _svg(_WIDTH, height, title, parts)


def _anchor(x: float) -> str:
    return "start" if x < _WIDTH * 0.2 else "end" if x > _WIDTH * 0.75 else "middle"


def _text(x: float, y: float, text: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(text)}</text>'


def _svg(width: float, height: float, title: str, parts: Sequence[str]) -> str:
    head = f'<svg viewBox="0 0 {width:g} {height:g}" width="{width:g}" role="img" aria-label="{escape(title)}">'
    return f"{head}{''.join(parts)}</svg>"
