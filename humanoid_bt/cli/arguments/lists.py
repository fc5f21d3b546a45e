"""The arguments of the commands that list what a workspace has: ``skills``, ``robots``."""

from __future__ import annotations

from humanoid_bt.cli.arguments.parsing import Commands, add_workspace


def add_skills(commands: Commands) -> None:
    """Declare ``skills``."""
    skills = commands.add("skills", "list skills and their parameters", "List skills, or explain some.")
    skills.add_argument("names", nargs="*", metavar="NAME", help="explain only these")
    add_workspace(skills)


def add_robots(commands: Commands) -> None:
    """Declare ``robots``."""
    robots = commands.add("robots", "list robots", "List the robots of this workspace.")
    add_workspace(robots)
