"""``humanoid-bt check``: the mistakes in files, for people, editors and programs."""

from __future__ import annotations

import argparse
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path

from humanoid_bt.checking.check import findings, settled
from humanoid_bt.checking.codes import ALLOWABLE, CODES, find
from humanoid_bt.cli.findings import counted, print_findings
from humanoid_bt.cli.output import columns, hanging, print_lines
from humanoid_bt.cli.reports import as_json, as_sarif
from humanoid_bt.cli.wording import several
from humanoid_bt.core.errors import Place, Problem, UserError, nearest, relative
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.session.report import ExitCode


def check(arguments: argparse.Namespace) -> int:
    """Check files, all in one go; tell every finding once; return the exit code."""
    if arguments.explain is not None:
        _explain(arguments.explain)
        return ExitCode.SUCCESS
    files, missing = _files(arguments)
    found = {path: findings(path, workspace) for path, workspace in files.items()}
    problems = [*missing, *settled(found)]
    if arguments.format == "json":
        print(as_json(problems))
    elif arguments.format == "sarif":
        print(as_sarif(problems))
    else:
        _print(problems, found)
    failed = arguments.strict or any(problem.severity == "error" for problem in problems)
    return ExitCode.USAGE if problems and failed else ExitCode.SUCCESS


def _print(problems: Sequence[Problem], found: Mapping[Path, Sequence[Problem]]) -> None:
    spoiled = {problem.place.file for problem in problems if problem.place}
    for path, own in found.items():
        name = relative(path)
        if name not in spoiled and not any(problem.severity == "error" for problem in own):
            print(f"{name}: ok")
    print_findings(problems)
    if problems:
        print(f"{counted(problems)} in {several(len(found), 'file')}")


def _explain(name: str) -> None:
    """Print what a code means, or list all of them."""
    if not name:
        print_lines(columns((code.name, code.severity, code.meaning) for code in CODES.values()))
        return
    code = find(name)
    print_lines(hanging(f"{code.name}  ", f"{code.severity}. {code.meaning}"))
    for title, text in (("wrong:", code.wrong), ("right:", code.right)):
        if text:
            print(f"\n{title}\n{textwrap.indent(text, '    ')}")
    if code.name in ALLOWABLE:
        print(f"\nto allow it, on the line it is about or above it:\n    # allow {code.name}: and why")


def _files(arguments: argparse.Namespace) -> tuple[dict[Path, Workspace], list[Problem]]:
    """Return every file to check with the workspace in which it would run, and what was not found."""
    given = Workspace(arguments.workspace)
    if not arguments.paths:
        files = _files_in(given.root)
        if not files:
            raise UserError(
                f"nothing to check in {relative(given.root)!r}",
                hint="give names, files or folders, or go to a folder with trees/, skills/ or sim/",
            )
        return dict.fromkeys(files, given), []
    found: dict[Path, Workspace] = {}
    missing: list[Problem] = []
    for text in arguments.paths:
        try:
            found |= _given(text, given, arguments.workspace)
        except UserError as error:
            missing += error.problems
    return found, missing


def _given(text: str, given: Workspace, root: Path | None) -> dict[Path, Workspace]:
    """Return the files that one argument stands for.

    Raises:
        UserError: there are none.
    """
    path = Path(text)
    if path.is_dir():
        inside = _files_in(path)
        if not inside:
            hint = "trees, scenes and robots end in .yaml"
            raise UserError(f"nothing to check in {text!r}", Place(text), hint, code="no-file")
        return {file.resolve(): _workspace(file, str(file), root) for file in inside}
    file = path if path.suffix == ".py" and path.is_file() else _named(text, given)
    return {file.resolve(): _workspace(file, text, root)}


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
    hint = nearest(Path(text).stem, known)
    raise UserError(f"no file and no tree, scene or robot named {text!r}", Place(text), hint, code="no-file")


def _files_in(folder: Path) -> list[Path]:
    """Return the files of a workspace, or all YAML and skill files of any other folder."""
    parts = [part for part in (folder / "skills", folder / "trees", folder / "sim") if part.is_dir()]
    found = [path for part in parts or [folder] for path in sorted(part.rglob("*.yaml"))]
    skill_folders = [folder] if folder.resolve().name == "skills" else [folder / "skills"]
    skills = [path for part in skill_folders for path in sorted(part.glob("*.py")) if not path.name.startswith("_")]
    return [*skills, *found]
