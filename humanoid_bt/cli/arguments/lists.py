"""The arguments of the commands that list what a workspace has: ``trees``, ``nodes``, ``skills`` and their like."""

from __future__ import annotations

from humanoid_bt.cli.arguments.parsing import Commands, add_workspace

_LISTS = {
    "trees": ("list trees and their parameters", "List trees, or explain some."),
    "nodes": ("list node types", "List the types of nodes, built-in ones and skills, or explain some with an example."),
    "skills": ("list skills and their parameters", "List skills, or explain some."),
    "scenes": ("list scenes", "List scenes, or explain some."),
    "sources": ("list percept sources and their parameters", "List percept sources, or explain some."),
    "scenarios": ("list scenarios", "List scenarios, or explain some: what they run, and what they expect."),
}


_ROBOTS = """\
List robots, or explain some; or write a first robot.yaml for a model: init
finds legs, feet, arms, head, drives and a posture in it, and marks what it
guessed.
"""

_ROBOTS_EXAMPLES = """\
examples:
  humanoid-bt robots
  humanoid-bt robots init models/my_robot.xml
  humanoid-bt check sim/my_robot/robot.yaml         does it stand and walk?
"""


def add_lists(commands: Commands) -> None:
    """Declare the commands that list."""
    for name, (text, description) in _LISTS.items():
        command = commands.add(name, text, description)
        command.add_argument("names", nargs="*", metavar="NAME", help="explain only these")
        add_workspace(command)


def add_robots(commands: Commands) -> None:
    """Declare ``robots``."""
    robots = commands.add("robots", "list robots, or describe a new one", _ROBOTS, _ROBOTS_EXAMPLES)
    robots.usage = (
        "humanoid-bt robots [-h] [--workspace DIR] [NAME ...]\n"
        "       humanoid-bt robots [-h] [--workspace DIR] init MODEL [--name NAME]"
    )
    robots.add_argument("names", nargs="*", metavar="NAME", help="explain only these")
    robots.add_argument("--name", metavar="NAME", help="with init: the robot's name; default: the model's")
    add_workspace(robots)
