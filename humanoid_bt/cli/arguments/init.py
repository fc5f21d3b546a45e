"""The arguments of ``humanoid-bt init``."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.cli.arguments.parsing import Commands

_DESCRIPTION = """\
Make a workspace that works at once: a tree, a skill and a scene of your own,
a scenario, a test and a campaign to try them, settings for VS Code, and checks
for GitHub."""

_EPILOG = """\
Files that are there are never overwritten: if one is in the way, nothing is
written.

examples:
  humanoid-bt init my_robot        in a new folder
  humanoid-bt init .               in this one
"""


def add_init(commands: Commands) -> None:
    """Declare ``init``."""
    init = commands.add("init", "make a workspace", _DESCRIPTION, _EPILOG)
    init.add_argument("folder", type=Path, metavar="DIR", help="the workspace's folder; made if it is not there")
