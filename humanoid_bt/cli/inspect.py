"""``skills``, ``robots``: looking at files without running them."""

from __future__ import annotations

import argparse

from rich.console import Console
from rich.text import Text

from humanoid_bt.cli.output import columns, hanging, print_lines
from humanoid_bt.core.errors import Problem, UserError, nearest, relative
from humanoid_bt.core.params import Param
from humanoid_bt.decision.skill_files import class_file
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.session.report import ExitCode
from humanoid_bt.tree.node_type import NodeType
from humanoid_bt.tree.nodes.registry import Registry


def skills(arguments: argparse.Namespace) -> int:
    """List skills, or explain some."""
    registry = Registry.of(Workspace(arguments.workspace))
    known = {name: kind for name, kind in registry.items() if kind.kind == "skill"}
    unknown = [name for name in arguments.names if name not in known]
    if unknown:
        raise UserError([Problem(f"no skill named {name!r}", None, nearest(name, known)) for name in unknown])
    console = Console(highlight=False)
    for number, name in enumerate(arguments.names or sorted(known)):
        if number:
            print()
        _explain(console, known[name])
    return ExitCode.SUCCESS


def _explain(console: Console, skill: NodeType) -> None:
    _headline(console, skill.type_name, skill.doc)
    file = class_file(skill.cls)
    commands = ", ".join(skill.resources) or "nothing"
    print_lines(hanging("  ", f"commands {commands}" + (f"; from {relative(file)}" if file else "")))
    rows = [(spec.name, spec.type_name, _default(spec), spec.doc) for spec in skill.params.values()]
    rows += [(result.name, result.type_name, "result", result.doc) for result in skill.results.values()]
    print_lines(columns(rows, indent=2))


def _headline(console: Console, name: str, doc: str) -> None:
    """Print a name in bold and what it is."""
    text = Text("\n".join(hanging(f"{name}  ", doc)))
    text.stylize("bold", 0, len(name))
    console.print(text, soft_wrap=True)


def _default(spec: Param) -> str:
    if spec.required:
        return "required"
    if spec.default is None:
        return "optional"
    value = str(spec.default)
    return f"= {value.lower() if isinstance(spec.default, bool) else value}"


def robots(arguments: argparse.Namespace) -> int:
    """List robots."""
    console = Console(highlight=False)
    problems: list[Problem] = []
    for name, path in sorted(Workspace(arguments.workspace).robots().items()):
        try:
            robot = RobotModel(load_robot_config(path))
        except UserError as error:
            problems += error.problems
            continue
        _headline(console, name, robot.config.description)
        print_lines(hanging("  ", f"{robot.mass:.1f} kg, {len(robot.joint_names)} joints; {relative(path)}"))
    if problems:
        raise UserError(problems)
    return ExitCode.SUCCESS
