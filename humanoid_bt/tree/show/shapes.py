"""The outlines, signs and marks of nodes in SVG pictures: drawn, so that no font can lack them."""

from __future__ import annotations

_ARROW = "h10m-4 -4l4 4l-4 4"

_SEQUENCE, _SELECTOR = f"M-5 0{_ARROW}", "M-3 -3a3 3 0 1 1 4.5 2.6q-1.5 .8 -1.5 2.4m0 2.6v1"

SIGNS = {
    **dict.fromkeys(("sequence", "reactive_sequence"), _SEQUENCE),
    **dict.fromkeys(("selector", "reactive_selector"), _SELECTOR),
    "parallel": f"M-5 -3{_ARROW.replace('4', '3')}M-5 4{_ARROW.replace('4', '3')}",
}
"""Node type -> what is drawn around the origin before its name: the field's signs for these types."""

MARKS = {
    "success": "M-5 0l3.5 4l6 -8",
    "failure": "M-4 -4l8 8m0 -8l-8 8",
    "running": "M-3 -5l8 5l-8 5z",
    "invalid": "M-3.5 0a3.5 3.5 0 1 0 7 0a3.5 3.5 0 1 0 -7 0",
}
"""Status -> what is drawn around the origin behind a node's name."""

_CUT = 7.0
_ROUND, _PILL = 8.0, 16.0
_INSET = 3.0


def outline(shape: str, width: float, height: float) -> list[str]:
    """Return the elements of an outline whose left upper corner is at the origin.

    Args:
        shape: box, round, cut, pill or double.
        width, height: its size.
    """
    if shape == "cut":
        right, bottom = width - 2 * _CUT, height - 2 * _CUT
        sides = f"h{right:.1f}l{_CUT:g} {_CUT:g}v{bottom:.1f}l-{_CUT:g} {_CUT:g}h-{right:.1f}l-{_CUT:g} -{_CUT:g}"
        return [f'<path class="box" d="M{_CUT:g} 0{sides}v-{bottom:.1f}z"/>']
    radius = {"round": _ROUND, "pill": min(_PILL, height / 2)}.get(shape, 2.0)
    parts = [f'<rect class="box" width="{width:.1f}" height="{height:.1f}" rx="{radius:g}"/>']
    if shape == "double":
        inner = f'width="{width - 2 * _INSET:.1f}" height="{height - 2 * _INSET:.1f}"'
        parts.append(f'<rect class="inner" x="{_INSET:g}" y="{_INSET:g}" {inner} rx="1"/>')
    return parts
