"""The arguments of the commands that list what a workspace has: ``trees``, ``nodes``, ``skills`` and their like."""

from __future__ import annotations

from humanoid_bt.cli.arguments.parsing import Commands, add_workspace

_LISTS = {
    "trees": ("list trees and their parameters", "List trees, or explain some."),
    "nodes": ("list node types", "List the types of nodes, built-in ones and skills, or explain some with an example."),
    "skills": ("list skills and their parameters", "List skills, or explain some."),
    "scenes": ("list scenes", "List scenes, or explain some."),
    "robots": ("list robots", "List robots, or explain some."),
    "scenarios": ("list scenarios", "List scenarios, or explain some: what they run, and what they expect."),
}


def add_lists(commands: Commands) -> None:
    """Declare the commands that list."""
    for name, (text, description) in _LISTS.items():
        command = commands.add(name, text, description)
        command.add_argument("names", nargs="*", metavar="NAME", help="explain only these")
        add_workspace(command)
