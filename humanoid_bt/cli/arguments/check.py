"""The arguments of ``humanoid-bt check``."""

from __future__ import annotations

from humanoid_bt.cli.arguments.parsing import Commands, add_workspace

_EXAMPLES = """\
examples:
  humanoid-bt check                       all of this folder
  humanoid-bt check fetch trees/mine.yaml skills/
  humanoid-bt check sim/mine/robot.yaml   also lets it stand, reach and walk
  humanoid-bt check --strict --format sarif > check.sarif
  humanoid-bt check --explain outside-watchdog

exit codes:
  0  no errors
  2  errors, each with its file, line and column;
     with --strict, warnings too
"""


def add_check(commands: Commands) -> None:
    """Declare ``check``."""
    check = commands.add(
        "check",
        "find mistakes in files",
        "Find mistakes without running a tree. A robot is tried: it stands, reaches and walks, in simulation.",
        _EXAMPLES,
    )
    check.add_argument(
        "paths",
        nargs="*",
        metavar="PATH",
        help="names, files or folders of trees, skills, scenes, robots, scenarios, campaigns; default: this workspace",
    )
    check.add_argument("--strict", action="store_true", help="let warnings fail as errors do")
    check.add_argument(
        "--format",
        choices=["text", "json", "sarif"],
        default="text",
        metavar="F",
        help="text (default), json, or sarif for code scanning",
    )
    check.add_argument(
        "--explain", nargs="?", const="", metavar="CODE", help="say what a code means, or list all of them"
    )
    add_workspace(check)
