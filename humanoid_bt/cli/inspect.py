"""``check``, ``show``, ``skills``, ``robots``: looking at files without running them."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from rich.console import Console
from rich.table import Table
from rich.text import Text

from humanoid_bt.errors import Problem, UserError, nearest, relative
from humanoid_bt.params import Param, params_of
from humanoid_bt.plant.robot_config import load_robot_config
from humanoid_bt.plant.robot_model import RobotModel
from humanoid_bt.plant.scene import load_scene
from humanoid_bt.session.report import ExitCode
from humanoid_bt.tree.load import load_tree
from humanoid_bt.tree.registry import NodeType, Registry
from humanoid_bt.tree.show import dot_tree, unicode_tree
from humanoid_bt.workspace import Workspace


def check(arguments: argparse.Namespace) -> int:
    """Check files; print every problem; return the exit code."""
    files = _files(arguments)
    failed = 0
    for path in files:
        problems = _check_file(path, arguments.workspace)
        for problem in problems:
            print(f"error: {problem}", file=sys.stderr)
        failed += bool(problems)
        if not problems:
            print(f"{relative(path)}: ok")
    if failed:
        print(f"{failed} of {len(files)} files have mistakes", file=sys.stderr)
    return ExitCode.USAGE if failed else ExitCode.SUCCESS


def _files(arguments: argparse.Namespace) -> list[Path]:
    workspace = Workspace(arguments.workspace)
    if not arguments.paths:
        files = _files_in(workspace.root)
        if not files:
            raise UserError(
                f"nothing to check below {relative(workspace.root)!r}",
                hint="give names, files or folders, or go to a folder with trees/ or sim/",
            )
        return files
    found: list[Path] = []
    for text in arguments.paths:
        path = Path(text)
        if path.is_dir():
            inside = _files_in(path)
            if not inside:
                raise UserError(f"no tree, scene or robot files in {text!r}", hint="they end in .yaml")
            found += inside
        else:
            found.append(workspace.find_tree(text))
    return list(dict.fromkeys(found))


def _files_in(folder: Path) -> list[Path]:
    """Return the files of a workspace, or all YAML files of any other folder."""
    parts = [folder / "trees", folder / "sim"]
    folders = [part for part in parts if part.is_dir()] or [folder]
    return sorted(path for part in folders for path in part.rglob("*.yaml"))


def _check_file(path: Path, root: Path | None) -> tuple[Problem, ...]:
    try:
        if path.name == "robot.yaml":
            RobotModel(load_robot_config(path))
        elif path.parent.name == "scenes":
            load_scene(path)
        else:
            load_tree(path, Workspace(root) if root else Workspace.of_tree(path))
    except UserError as error:
        return error.problems
    return ()


def show(arguments: argparse.Namespace) -> int:
    """Draw a tree."""
    workspace = Workspace(arguments.workspace)
    path = workspace.find_tree(arguments.tree)
    tree = load_tree(path, workspace if arguments.workspace else Workspace.of_tree(path))
    print(unicode_tree(tree) if arguments.format == "unicode" else dot_tree(tree))
    return ExitCode.SUCCESS


def skills(arguments: argparse.Namespace) -> int:
    """List skills, or explain some."""
    registry = Registry.of(Workspace(arguments.workspace))
    known = {name: kind for name, kind in registry.items() if kind.kind == "skill"}
    unknown = [name for name in arguments.names if name not in known]
    if unknown:
        raise UserError([Problem(f"no skill named {name!r}", None, nearest(name, known)) for name in unknown])
    console = Console(highlight=False)
    for name in arguments.names or sorted(known):
        _explain(console, known[name])
    return ExitCode.SUCCESS


def _explain(console: Console, skill: NodeType) -> None:
    console.print(Text.assemble((skill.type_name, "bold"), f"  {skill.doc}"))
    commands = ", ".join(skill.resources) or "nothing"
    console.print(Text(f"  commands {commands}", style="dim"))
    table = Table(box=None, show_header=False, padding=(0, 1), pad_edge=False)
    for spec in params_of(skill.cls).values():
        table.add_row("  " + spec.name, spec.type_name.replace("[", r"\["), _default(spec), spec.doc)
    if table.row_count:
        console.print(table)
    console.print()


def _default(spec: Param) -> str:
    if spec.required:
        return "required"
    return "" if spec.default is None else str(spec.default)


def robots(arguments: argparse.Namespace) -> int:
    """List robots."""
    console = Console(highlight=False)
    table = Table(box=None, pad_edge=False)
    for heading in ("robot", "mass", "joints", "description", "file"):
        table.add_column(heading, overflow="fold")
    problems: list[Problem] = []
    for name, path in sorted(Workspace(arguments.workspace).robots().items()):
        try:
            robot = RobotModel(load_robot_config(path))
        except UserError as error:
            problems += error.problems
            continue
        joints = str(len(robot.joint_names))
        table.add_row(name, f"{robot.mass:.1f} kg", joints, robot.config.description, relative(path))
    console.print(table)
    if problems:
        raise UserError(problems)
    return ExitCode.SUCCESS
