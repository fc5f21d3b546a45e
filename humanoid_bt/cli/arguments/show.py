"""The arguments of ``humanoid-bt show``."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.cli.arguments.numbers import COUNT, number
from humanoid_bt.cli.arguments.parsing import Commands, add_workspace

_EXAMPLES = """\
examples:
  humanoid-bt show fetch
  humanoid-bt show tour --closed          its own nodes, none of its sub-trees'
  humanoid-bt show tour --depth 4         the first levels
  humanoid-bt show fetch -o fetch.svg     a picture
  humanoid-bt show fetch -o fetch.mmd     for a Markdown page
  humanoid-bt show --live                 the tree that runs

marks of a tree that runs:
  ▶ running   ✓ succeeded   ✗ failed   ○ neither
"""


def add_show(commands: Commands) -> None:
    """Declare ``show``."""
    show = commands.add("show", "draw a tree, also while it runs", "Draw a tree, or one that runs.", _EXAMPLES)
    show.add_argument("tree", nargs="?", metavar="TREE", help="name or file of a tree")
    show.add_argument(
        "--format",
        choices=["unicode", "svg", "dot", "mermaid"],
        metavar="F",
        help="unicode (default), svg, dot or mermaid; default: what FILE's suffix says",
    )
    show.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="write it to this .txt, .svg, .dot or .mmd file"
    )
    show.add_argument(
        "--live",
        action="store_true",
        help="instead of TREE: the tree that runs in another terminal, with the status of every node; "
        "at a terminal until Ctrl-C, else once",
    )
    show.add_argument("--depth", type=number(COUNT), metavar="N", help="only N levels; what is deeper is counted")
    show.add_argument("--closed", action="store_true", help="leave out what is in sub-trees; it is counted")
    show.add_argument("--run", metavar="ID", help="with --live: which run, if there are several")
    add_workspace(show)
