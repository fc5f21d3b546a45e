"""The arguments of ``humanoid-bt fmt``."""

from __future__ import annotations

from humanoid_bt.cli.arguments.parsing import Commands, add_workspace

_DESCRIPTION = """\
Bring trees, scenes, robots, scenarios and campaigns into one form. Only
indentation, blanks and empty lines change: values, their order and every comment stay."""

_EXAMPLES = """\
examples:
  humanoid-bt fmt                         all trees, scenarios and campaigns of this folder
  humanoid-bt fmt trees/mine.yaml sim     a file, and all scenes and robots
  humanoid-bt fmt --check                 before a commit, or in CI

exit codes:
  0  all files have this form now
  1  with --check or --diff: some would change
  2  mistakes in files, which are left as they are
"""


def add_fmt(commands: Commands) -> None:
    """Declare ``fmt``."""
    fmt = commands.add("fmt", "format files", _DESCRIPTION, _EXAMPLES)
    fmt.add_argument(
        "paths",
        nargs="*",
        metavar="PATH",
        help="names, files or folders of trees, scenes, robots, scenarios, campaigns; default: all but scenes, robots",
    )
    fmt.add_argument("--check", action="store_true", help="change nothing, name the files that would change")
    fmt.add_argument("--diff", action="store_true", help="change nothing, show what would change")
    add_workspace(fmt)
