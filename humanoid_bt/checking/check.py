"""Checking files: what ``humanoid-bt check`` finds, and ``run`` before it starts."""

from __future__ import annotations

import types
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any

from humanoid_bt.checking import allow
from humanoid_bt.checking.robot import robot_problems
from humanoid_bt.core.errors import Place, Problem, UserError, nearest, relative, resolved
from humanoid_bt.core.sources import Sources
from humanoid_bt.files.reading import followed, is_file, is_folder, read_text
from humanoid_bt.files.workspace import Workspace, source_files, yaml_files
from humanoid_bt.perception.choice import choose
from humanoid_bt.perception.source_files import load_sources
from humanoid_bt.plant.scene_config import load_scene
from humanoid_bt.robot.policy.policy import load_policy
from humanoid_bt.tree.nodes.registry import Registry
from humanoid_bt.tree.source.file import read_file
from humanoid_bt.tree.source.load import load_tree
from humanoid_bt.tree.tree import Tree

_Reader = Callable[[Path, Workspace], object]
Kinds = Mapping[str, _Reader]
"""Kinds of files that rooms above bring along: name of their folder -> what reads one, and raises its UserError."""


def checked(path: Path, workspace: Workspace, kinds: Kinds = types.MappingProxyType({})) -> list[Problem]:
    """Return the errors and warnings of a tree, a scene, a robot or a skill file, each with its file.

    Args:
        path: the file: ``*.py`` is a percept source in ``perception/``, else a skill; ``robot.yaml`` a robot;
            ``*.policy.yaml`` a learned walker; what lies in ``scenes/`` a scene, else a tree.
        workspace: where it would run.
        kinds: other kinds of files.
    """
    return settled({path: findings(path, workspace, kinds)})


def load_checked(
    path: Path,
    workspace: Workspace,
    parameters: Mapping[str, Any] | None = None,
    *,
    robot: str | None = None,
    scene: str | None = None,
    perception: Sources | None = None,
    others: Collection[str] = (),
    arguments: Collection[str] = (),
) -> Tree:
    """Load a tree, with the warnings that its files do not allow; arguments as of ``load_tree``.

    Raises:
        UserError: it has mistakes, or a comment in its file allows what it cannot allow or gives no reason.
    """
    tree = load_tree(
        path,
        workspace,
        parameters,
        robot=robot,
        scene=scene,
        perception=perception,
        others=others,
        arguments=arguments,
    )
    problems = settled({tree.path: tree.warnings})
    if errors := [problem for problem in problems if problem.severity == "error"]:
        raise UserError(errors)
    return replace(tree, warnings=tuple(problems))


def findings(path: Path, workspace: Workspace, kinds: Kinds = types.MappingProxyType({})) -> list[Problem]:
    """Return what checking one file finds, also in files that it needs; nothing is allowed yet."""
    try:
        found = _load(path, workspace, kinds)
    except UserError as error:
        found = error.problems
    name = relative(path)
    if path.suffix == ".py":  # the other skills of its folder are loaded with it, and told of by themselves
        return [problem for problem in found if problem.place and problem.place.file == name]
    return [problem if problem.place else replace(problem, place=Place(name)) for problem in found]


def settled(found: Mapping[Path, Sequence[Problem]]) -> list[Problem]:
    """Return what remains when the comments of the files have been heard, file by file in the order of lines.

    Args:
        found: the files that were checked, with what :func:`findings` gave for each.
    """
    problems = list(dict.fromkeys(problem for own in found.values() for problem in own))
    own = {relative(path): path for path in found}
    files = dict.fromkeys((*own, *(problem.place.file for problem in problems if problem.place)))
    for file in files:
        path = own.get(file, Path(file))
        complete = path in found and not any(problem.severity == "error" for problem in found[path])
        complete = complete and not _is_subtree(path)
        try:
            source = read_text(path)
        except UserError:  # a finding tells of it, or it is no file (a value that was set)
            continue
        problems = allow.remaining(source, file, problems, complete=complete)
    order = {file: number for number, file in enumerate(files)}

    def place(problem: Problem) -> tuple[int, int, int]:
        where = problem.place or Place("")
        return order.get(where.file, -1), where.line, where.column

    return sorted(problems, key=place)


def _is_subtree(path: Path) -> bool:
    """Return whether a file is a tree that is made for use in others: some warnings only come of these."""
    try:
        return path.suffix != ".py" and bool(read_file(path, []).header.get("subtree"))
    except UserError:
        return False


def _load(path: Path, workspace: Workspace, kinds: Kinds) -> Sequence[Problem]:
    """Load a file; return its warnings.

    Raises:
        UserError: with its errors.
    """
    if path.suffix == ".py" and resolved(path).parent.name == "perception":
        load_sources(workspace)
    elif path.suffix == ".py":
        Registry.of(workspace)
    elif path.name == "robot.yaml":
        return robot_problems(path)
    elif path.name.endswith(".policy.yaml"):
        return load_policy(path).warnings
    elif path.parent.name == "scenes":
        scene = load_scene(path)
        choose(scene.perception, workspace, scene)
    elif (read := _reader(path, workspace, kinds)) is not None:
        read(path, workspace)
    else:
        return load_tree(path, workspace).warnings
    return ()


def _reader(path: Path, workspace: Workspace, kinds: Kinds) -> _Reader | None:
    """Return what reads a file of a kind that a room above brings along, None if it is of none."""
    file = resolved(path)
    if file.is_relative_to(workspace.root) and (read := kinds.get(file.relative_to(workspace.root).parts[0])):
        return read
    return kinds.get(file.parent.name)


def collect(
    paths: Sequence[str], root: str | PathLike[str] | Workspace | None
) -> tuple[dict[Path, Workspace], list[Problem]]:
    """Return every file to check with the workspace in which it would run, and what was not found.

    Args:
        paths: names, files or folders; the whole workspace if there are none.
        root: the workspace that was asked for, if any.

    Raises:
        UserError: there is nothing to check.
    """
    given = root if isinstance(root, Workspace) else Workspace(root)
    if not paths:
        files = _files_in(given.root)
        if not files:
            raise UserError(
                f"nothing to check in {relative(given.root)!r}",
                hint="give names, files or folders, or go to a workspace: a folder with trees/, skills/ or the like",
            )
        return dict.fromkeys(files, given), []
    found: dict[Path, Workspace] = {}
    missing: list[Problem] = []
    for text in paths:
        try:
            found |= _given(text, given, given if root is not None else None)
        except UserError as error:
            missing += error.problems
    return found, missing


def _given(text: str, given: Workspace, root: Workspace | None) -> dict[Path, Workspace]:
    """Return the files that one argument stands for.

    Raises:
        UserError: there are none.
    """
    path = Path(text)
    if is_folder(path):
        inside = _files_in(path)
        if not inside:
            hint = "trees, scenes, robots, scenarios and campaigns end in .yaml"
            raise UserError(f"nothing to check in {text!r}", Place(text), hint, code="no-file")
        return {followed(file): _workspace(file, str(file), root) for file in inside}
    file = path if path.suffix == ".py" and is_file(path) else _named(text, given)
    return {followed(file): _workspace(file, text, root)}


def _workspace(file: Path, text: str, root: Workspace | None) -> Workspace:
    """Return where a file that was given as ``text`` would run: a skill beside the others of its folder."""
    if file.suffix == ".py" and root is None:
        return Workspace(resolved(file).parent.parent)
    return Workspace.of_argument(text, root)


def _named(text: str, workspace: Workspace) -> Path:
    """Return the file of a name: a tree's, else a scene's, a robot's, a scenario's, a campaign's or that of skills."""
    classes = {file.stem: file for file in (*workspace.perception_files(), *workspace.skill_files())}
    known = {
        **classes,
        **workspace.campaigns(),
        **workspace.scenarios(),
        **workspace.robots(),
        **workspace.scenes(),
        **workspace.trees(),
    }
    if text in known:
        return known[text]
    if is_file(Path(text)):
        return Path(text)
    hint = nearest(Path(text).stem, known)
    message = f"no file and no tree, scene, robot, scenario, campaign, skill or percept source named {text!r}"
    raise UserError(message, Place(text), hint, code="no-file")


def _files_in(folder: Path) -> list[Path]:
    """Return the skills, percept sources, trees, scenes, robots, scenarios and campaigns of a folder."""
    own = resolved(folder).name
    skill_folder = folder if own == "skills" else folder / "skills"
    skills = [path for path in sorted(skill_folder.glob("*.py")) if not path.name.startswith("_")]
    sources = source_files(folder if own == "perception" else folder / "perception")
    return [*skills, *sources, *yaml_files(folder)]
