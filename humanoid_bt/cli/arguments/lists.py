"""The arguments of the commands that list what a workspace has: ``trees``, ``nodes``, ``skills`` and their like."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.cli.arguments.numbers import COUNT, number
from humanoid_bt.cli.arguments.parsing import Commands, add_workspace
from humanoid_bt.session.limits import SEED

_LISTS = {
    "trees": ("list trees and their parameters", "List trees, or explain some."),
    "nodes": ("list node types", "List the types of nodes, built-in ones and skills, or explain some with an example."),
    "skills": ("list skills and their parameters", "List skills, or explain some."),
    "scenes": ("list scenes", "List scenes, or explain some."),
    "sources": ("list percept sources and their parameters", "List percept sources, or explain some."),
    "scenarios": ("list scenarios", "List scenarios, or explain some: what they run, and what they expect."),
}


_ROBOTS = """\
List robots, or explain some.

init writes a first robot.yaml for a model: it finds legs, feet, arms, head,
drives and a posture in it, and marks what it guessed.

table tries robots with some rows of bench --body, with each of their bodies,
and writes a table with their pictures into a folder.
"""

_ROBOTS_EXAMPLES = """\
examples:
  humanoid-bt robots
  humanoid-bt robots init models/my_robot.xml
  humanoid-bt check sim/my_robot/robot.yaml         does it stand, reach and walk?
  humanoid-bt robots table humanoid my_robot --trials 10 --out robots
"""


def add_lists(commands: Commands) -> None:
    """Declare the commands that list."""
    for name, (text, description) in _LISTS.items():
        command = commands.add(name, text, description)
        command.add_argument("names", nargs="*", metavar="NAME", help="explain only these")
        add_workspace(command)


def add_robots(commands: Commands) -> None:
    """Declare ``robots``."""
    robots = commands.add(
        "robots", "list robots, describe a new one, or try some side by side", _ROBOTS, _ROBOTS_EXAMPLES
    )
    robots.usage = (
        "humanoid-bt robots [-h] [--workspace DIR] [NAME ...]\n"
        "       humanoid-bt robots [-h] [--workspace DIR] init MODEL [--name NAME]\n"
        "       humanoid-bt robots [-h] [--workspace DIR] table ROBOT ... [--out DIR] [--trials N]\n"
        "                                                [--seed FIRST] [--only ROW ...] [-j N]"
    )
    robots.add_argument("names", nargs="*", metavar="NAME", help="explain only these")
    robots.add_argument("--name", metavar="NAME", help="with init: the robot's name; default: the model's")
    add_workspace(robots)
    table = robots.add_argument_group("with table")
    table.add_argument("--out", type=Path, metavar="DIR", help="folder that it is written to; default: robots")
    table.add_argument("--trials", type=number(COUNT), metavar="N", help="of each row; default 4")
    table.add_argument("--seed", type=number(SEED), metavar="FIRST", help="of the first trial; default 0")
    table.add_argument(
        "--only",
        nargs="+",
        metavar="ROW",
        help="rows of bench --body, by name or pattern; default: fetch, goals, straight, push-standing-100, "
        "push-walking-100",
    )
    table.add_argument("-j", "--workers", type=number(COUNT), metavar="N", help="trials at a time; default 1")
