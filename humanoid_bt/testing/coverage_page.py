"""Tree coverage as a page: the source of each tree file with marks of what its nodes did, in one HTML file."""

from __future__ import annotations

import re
from html import escape
from string import Template

from humanoid_bt.core.errors import relative
from humanoid_bt.testing.coverage import TreeCoverage, never, percent
from humanoid_bt.tree.coverage import FileCoverage, NodeCoverage
from humanoid_bt.tree.show.looks import STATUS_GLYPHS

_GLYPHS = {
    "success": STATUS_GLYPHS["SUCCESS"],
    "failure": STATUS_GLYPHS["FAILURE"],
    "running": STATUS_GLYPHS["RUNNING"],
    "halted": STATUS_GLYPHS["INVALID"],
}
_COMMENT = re.compile(r"(?:^|(?<=\s))#.*$")
_KEY = re.compile(r"(^|[{\s,])([\w$]+)(:)(?=\s|$)")

_PAGE = Template("""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Tree coverage: $percent %</title>
<style>
:root {
  color-scheme: light dark;
  --paper: #ffffff; --ink: #1f2328; --faint: #656d76; --line: #d8dee4; --card: #f6f8fa;
  --good: #1a7932; --good-tint: #dff3e4; --bad: #c9251d; --bad-tint: #fdeceb; --some: #9a6700; --some-tint: #fff6d6;
  --key: #0a568c; --comment: #6e7781;
}
@media (prefers-color-scheme: dark) { :root {
  --paper: #0d1117; --ink: #e6edf3; --faint: #9198a1; --line: #30363d; --card: #151b23;
  --good: #5cce78; --good-tint: #12301c; --bad: #ff827a; --bad-tint: #351b1d; --some: #e3b341; --some-tint: #2b2410;
  --key: #79c0ff; --comment: #8b949e;
} }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 76rem; padding: 2.5rem 1.5rem 5rem; background: var(--paper); color: var(--ink);
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif; }
h1 { font-size: 1.1rem; font-weight: 600; margin: 0; }
a { color: inherit; text-decoration: none; } a:hover { text-decoration: underline; }
code, .source { font-family: ui-monospace, SFMono-Regular, Menlo, Consolas, "DejaVu Sans Mono", monospace; }
.total { display: flex; align-items: baseline; gap: 1rem; margin: .25rem 0 .75rem; }
.total b { white-space: nowrap; font-size: 3.25rem; line-height: 1.1; font-weight: 650; letter-spacing: -.03em; }
.total span, .legend, .count { color: var(--faint); }
.bar { display: block; height: .5rem; border-radius: .25rem; background: var(--bad-tint); overflow: hidden; }
.bar i { display: block; height: 100%; background: var(--good); border-radius: .25rem; }
.legend { display: flex; flex-wrap: wrap; gap: .35rem 1.5rem; margin: 1rem 0 2rem; font-size: .85rem; }
table.files { width: 100%; border-collapse: collapse; margin-bottom: 2.5rem; }
table.files td { padding: .45rem .75rem .45rem 0; border-top: 1px solid var(--line); }
table.files td:nth-child(2) { width: 35%; }
table.files td:nth-child(n+3) { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }
table.files td:last-child { padding-right: 0; font-weight: 600; }
.file { border: 1px solid var(--line); border-radius: .5rem; margin: 0 0 1.5rem; overflow: hidden; }
.file > summary { display: flex; gap: 1rem; align-items: baseline; padding: .6rem 1rem; background: var(--card);
  cursor: pointer; list-style: none; font-weight: 600; }
.file > summary::-webkit-details-marker { display: none; }
.file > summary .count { font-weight: 400; margin-left: auto; font-variant-numeric: tabular-nums; }
.file[open] > summary { border-bottom: 1px solid var(--line); }
.scroll { overflow-x: auto; }
.source { border-collapse: collapse; width: 100%; font-size: 13px; line-height: 1.6; tab-size: 4; }
.source td { padding: 0 .75rem; vertical-align: top; white-space: pre; }
.source .number { width: 1%; text-align: right; color: var(--faint); user-select: none;
  border-left: 4px solid transparent; }
.source .marks { width: 1%; padding: 0 .5rem 0 0; }
tr.all .number { border-left-color: var(--good); }
tr.some { background: var(--some-tint); } tr.some .number { border-left-color: var(--some); }
tr.none { background: var(--bad-tint); } tr.none .number { border-left-color: var(--bad); }
.comment { color: var(--comment); font-style: italic; } .key { color: var(--key); }
.node { display: grid; grid-template-columns: repeat(4, 1.15rem) auto; gap: .2rem; padding: .08rem 0; cursor: help; }
.node small { color: var(--faint); font-size: 11px; line-height: 1.15rem; }
.mark { display: inline-block; width: 1.15rem; height: 1.15rem; border-radius: .25rem; border: 1px solid transparent;
  text-align: center; font-size: .7rem; line-height: calc(1.15rem - 2px); }
.mark.seen { color: var(--good); background: var(--good-tint); }
.mark.never { color: var(--bad); border: 1px dashed var(--bad); background: var(--paper); }
.problem { color: var(--bad); white-space: pre-wrap; }
@media (max-width: 40rem) { body { padding: 1.25rem .75rem 3rem; } table.files td:nth-child(2) { display: none; } }
@media print { .file { break-inside: avoid-page; } }
</style>
</head>
<body>
<h1>Tree coverage</h1>
<p class="total"><b>$percent&thinsp;%</b><span>$seen of $possible things that nodes can do were tried</span></p>
<span class="bar"><i style="width: $share%"></i></span>
<p class="legend">$legend</p>
$problems<table class="files">
$rows
</table>
$files
</body>
</html>
""")


def page(coverage: TreeCoverage) -> str:
    """Return what was tried as an HTML page that needs nothing else."""
    problems = "".join(f'<p class="problem">{escape(problem)}</p>\n' for problem in coverage.problems)
    legend = [f"{_mark(deed, True)} {deed}" for deed in _GLYPHS]
    return _PAGE.substitute(
        percent=coverage.shown,
        share=f"{coverage.percent:.2f}",
        seen=coverage.seen,
        possible=coverage.possible,
        legend="".join(f"<span>{text}</span>" for text in [*legend, f"{_mark('failure', False)} never"]),
        problems=problems,
        rows="\n".join(_row(number, file) for number, file in enumerate(coverage.files)),
        files="\n".join(_file(number, file) for number, file in enumerate(coverage.files)),
    )


def _row(number: int, file: FileCoverage) -> str:
    share = percent(file.seen, file.possible) if file.possible else 0.0  # a file with mistakes has no nodes
    return (
        f'<tr><td><a href="#file-{number}"><code>{escape(relative(file.path))}</code></a></td>'
        f'<td><span class="bar"><i style="width: {share:.2f}%"></i></span></td>'
        f"<td>{file.seen} of {file.possible}</td><td>{int(share)}&thinsp;%</td></tr>"
    )


def _file(number: int, file: FileCoverage) -> str:
    missing = file.possible - file.seen
    count = "not read" if not file.possible else f"{missing} missing" if missing else "all tried"
    try:
        text = file.path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        text = ""
    at: dict[int, list[NodeCoverage]] = {}
    for node in file.ordered:
        at.setdefault(node.line, []).append(node)
    lines = "\n".join(_line(index, line, at.get(index, [])) for index, line in enumerate(text.splitlines(), 1))
    return (
        f'<details class="file" id="file-{number}" open><summary><code>{escape(relative(file.path))}</code>'
        f'<span class="count">{count}</span></summary>\n<div class="scroll"><table class="source">\n{lines}\n'
        "</table></div></details>"
    )


def _line(number: int, text: str, nodes: list[NodeCoverage]) -> str:
    kind = ""
    if nodes:
        tried = [not node.missing for node in nodes]
        kind = "all" if all(tried) else "some" if any(node.seen for node in nodes) else "none"
    marks = "".join(_marks(node, named=len(nodes) > 1) for node in nodes)
    cells = f'<td class="number">{number}</td><td class="marks">{marks}</td><td>{_colored(text)}</td>'
    return f'<tr class="{kind}">{cells}</tr>'


def _marks(node: NodeCoverage, named: bool) -> str:
    name = f"<small>{escape(node.name)}</small>" if named else ""
    title = f"{node.name}: {never(node) if node.missing else 'all tried'}"
    slots = [_mark(deed, deed in node.seen) if deed in node.counted else "<i></i>" for deed in _GLYPHS]
    return f'<span class="node" title="{escape(title)}">{"".join(slots)}{name}</span>'


def _mark(deed: str, seen: bool) -> str:
    return f'<span class="mark {"seen" if seen else "never"}">{_GLYPHS[deed]}</span>'


def _colored(text: str) -> str:
    """Return a line of YAML with its comment and its keys told apart."""
    comment = _COMMENT.search(text)
    code, rest = (text[: comment.start()], comment[0]) if comment else (text, "")
    keys = _KEY.sub(r'\1<span class="key">\2</span>\3', escape(code, quote=False))
    return keys + (f'<span class="comment">{escape(rest, quote=False)}</span>' if rest else "")
