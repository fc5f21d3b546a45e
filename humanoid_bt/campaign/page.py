"""A web page that needs nothing but itself: no scripts, no fonts, no files beside it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from humanoid_bt.campaign import plots
from humanoid_bt.core.texts import printable

_STYLE = """\
:root { color-scheme: light dark; --paper: #ffffff; --card: #f6f8fa; --ink: #1f2328; --muted: #57606a; --line: #c8d0d8;
  --good: #1f7a3d; --bad: #c0362c }
@media (prefers-color-scheme: dark) { :root { --paper: #0d1117; --card: #161b22; --ink: #e6edf3; --muted: #9da7b3;
  --line: #3d444d; --good: #57ab5a; --bad: #f47067 } }
body { background: var(--paper); color: var(--ink); font: 15px/1.5 system-ui, sans-serif; margin: 0 auto; padding: 24px;
  max-width: 1160px }
h1 { font-size: 24px; margin: 0 0 4px } h2 { font-size: 18px; margin: 32px 0 12px } p { margin: 4px 0 }
.muted { color: var(--muted) } .good { color: var(--good) } .bad { color: var(--bad) }
.big { font-size: 44px; font-weight: 650; line-height: 1.15 } .cards { display: grid; gap: 14px;
  grid-template-columns: repeat(auto-fill, minmax(340px, 1fr)) }
.card { background: var(--card); border: 1px solid var(--line); border-radius: 8px; padding: 12px 14px; min-width: 0 }
.card h3 { font-size: 14px; margin: 0 0 8px }
.scroll { overflow-x: auto } table { border-collapse: collapse; width: 100% }
th, td { text-align: left; padding: 5px 14px 5px 0; border-bottom: 1px solid var(--line); vertical-align: top }
th { color: var(--muted); font-weight: 500; white-space: nowrap } td.number { text-align: right }
code { font: 12.5px ui-monospace, monospace; background: var(--card); border: 1px solid var(--line); border-radius: 4px;
  padding: 1px 5px; overflow-wrap: anywhere } summary { cursor: pointer } details { margin: 6px 0 }
a { color: inherit }
"""


def page(title: str, parts: Iterable[str]) -> str:
    """Return a page of parts that are HTML already."""
    head = (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{safe(title)}</title>\n<style>\n{_STYLE}{plots.STYLE}</style></head>\n<body>\n"
    )
    return head + "\n".join(parts) + "\n</body></html>\n"


def safe(text: str) -> str:
    """Return a text as HTML that shows it, whatever is in it."""
    return escape(printable(text))


def code(text: str) -> str:
    """Return a text that is typed somewhere as HTML."""
    return f"<code>{safe(text)}</code>"


def card(title: str, inside: str) -> str:
    """Return a card with a title."""
    return f'<div class="card"><h3>{safe(title)}</h3>{inside}</div>'


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table of cells that are HTML already; without a head where no column has a name."""
    names = "".join(f"<th>{safe(name)}</th>" for name in head)
    body = "".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in rows)
    return f'<div class="scroll"><table>{f"<tr>{names}</tr>" if any(head) else ""}{body}</table></div>'
