"""``check``, ``skills``, ``robots``: looking at files without running them."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from rich.console import Console
from rich.text import Text

from humanoid_bt.cli.output import columns, hanging, print_lines
from humanoid_bt.errors import Problem, UserError, nearest, relative
from humanoid_bt.params import Param
from humanoid_bt.plant.robot_config import load_robot_config
from humanoid_bt.plant.robot_model import RobotModel
from humanoid_bt.plant.scene import load_scene
from humanoid_bt.session.report import ExitCode
from humanoid_bt.skill_files import class_file
from humanoid_bt.tree.load import load_tree
from humanoid_bt.tree.registry import NodeType, Registry
from humanoid_bt.workspace import Workspace


def check(arguments: argparse.Namespace) -> int:
    """Check files; print every problem once; return the exit code."""
    files = _files(arguments)
    told: set[Problem] = set()
    failed = 0
    for path, workspace in files.items():
        problems = _check_file(path, workspace)
        for problem in problems:
            if problem not in told:
                print(f"error: {problem}", file=sys.stderr)
        told.update(problems)
        failed += bool(problems)
        if not problems:
            print(f"{relative(path)}: ok")
    if failed:
        count = "1 file has" if failed == 1 else f"{failed} files have"
        print(f"{count} mistakes, of {len(files)} checked", file=sys.stderr)
    return ExitCode.USAGE if failed else ExitCode.SUCCESS


def _files(arguments: argparse.Namespace) -> dict[Path, Workspace]:
    """Return every file to check, and the workspace in which it would run."""
    given = Workspace(arguments.workspace)
    if not arguments.paths:
        files = _files_in(given.root)
        if not files:
            raise UserError(
                f"nothing to check in {relative(given.root)!r}",
                hint="give names, files or folders, or go to a folder with trees/, skills/ or sim/",
            )
        return dict.fromkeys(files, given)
    found: dict[Path, Workspace] = {}
    for text in arguments.paths:
        path = Path(text)
        if path.is_dir():
            inside = _files_in(path)
            if not inside:
                raise UserError(f"nothing to check in {text!r}", hint="trees, scenes and robots end in .yaml")
            found |= {file.resolve(): _workspace(file, str(file), arguments.workspace) for file in inside}
        else:
            file = path if path.suffix == ".py" and path.is_file() else _named(text, given)
            found[file.resolve()] = _workspace(file, text, arguments.workspace)
    return found


def _workspace(file: Path, text: str, root: Path | None) -> Workspace:
    """Return where a file that was given as ``text`` would run: a skill beside the others of its folder."""
    if file.suffix == ".py" and root is None:
        return Workspace(file.resolve().parent.parent)
    return Workspace.of_argument(text, root)


def _named(text: str, workspace: Workspace) -> Path:
    """Return the file of a name: a tree's, else a scene's or a robot's."""
    known = {**workspace.robots(), **workspace.scenes(), **workspace.trees()}
    if text in known:
        return known[text]
    if Path(text).is_file():
        return Path(text)
    raise UserError(f"no file and no tree, scene or robot named {text!r}", hint=nearest(Path(text).stem, known))


def _files_in(folder: Path) -> list[Path]:
    """Return the files of a workspace, or all YAML and skill files of any other folder."""
    parts = [part for part in (folder / "skills", folder / "trees", folder / "sim") if part.is_dir()]
    found = [path for part in parts or [folder] for path in sorted(part.rglob("*.yaml"))]
    skill_folders = [folder] if folder.resolve().name == "skills" else [folder / "skills"]
    skills = [path for part in skill_folders for path in sorted(part.glob("*.py")) if not path.name.startswith("_")]
    return [*skills, *found]


def _check_file(path: Path, workspace: Workspace) -> tuple[Problem, ...]:
    try:
        if path.suffix == ".py":
            Registry.of(workspace)
        elif path.name == "robot.yaml":
            RobotModel(load_robot_config(path))
        elif path.parent.name == "scenes":
            load_scene(path)
        else:
            load_tree(path, workspace)
    except UserError as error:
        if path.suffix != ".py":
            return error.problems
        return tuple(problem for problem in error.problems if problem.place and problem.place.file == relative(path))
    return ()


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
