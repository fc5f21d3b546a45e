"""The arguments of ``humanoid-bt coverage``."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.cli.arguments.numbers import PERCENT, number
from humanoid_bt.cli.arguments.parsing import Commands, add_workspace

_EXAMPLES = """\
To count, give the environment variable HUMANOID_BT_TREE_COVERAGE a
folder: whatever runs trees then, commands, programs and tests, writes
a file there. pytest does so itself: pytest --tree-coverage=trees

examples:
  HUMANOID_BT_TREE_COVERAGE=counted humanoid-bt run fetch
  humanoid-bt coverage counted
  humanoid-bt coverage counted nightly.json --html coverage.html
  humanoid-bt coverage counted --tree fetch --fail-under 90

exit codes:
  0  done
  1  less than N percent were tried
  2  usage, a file that cannot be read, or a tree with mistakes
"""


def add_coverage(commands: Commands) -> None:
    """Declare ``coverage``."""
    coverage = commands.add(
        "coverage",
        "show what of trees was tried",
        "Show which nodes of tree files ever succeeded, failed, ran and\nwere halted, and the lines that never did.",
        _EXAMPLES,
    )
    coverage.add_argument("data", nargs="+", type=Path, metavar="DATA", help="what was counted: JSON files, folders")
    coverage.add_argument(
        "--tree",
        action="append",
        default=[],
        dest="trees",
        metavar="PATH",
        help="show this tree: a file, a folder, a name; default: all of the workspace; can be repeated",
    )
    coverage.add_argument("--html", type=Path, metavar="FILE", help="write the trees' source with marks")
    coverage.add_argument(
        "--json", type=Path, metavar="FILE", help="write all of it as one file, for programs and DATA"
    )
    coverage.add_argument(
        "--fail-under", type=number(PERCENT), metavar="N", help="fail if less than N percent were tried"
    )
    add_workspace(coverage)
