"""Checking files without running them: what ``humanoid-bt check`` finds, and ``run`` before it starts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from humanoid_bt.checking import allow
from humanoid_bt.core.errors import Place, Problem, UserError, relative
from humanoid_bt.files.document import read_text
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.plant.scene_config import load_scene
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.tree.nodes.registry import Registry
from humanoid_bt.tree.source.load import load_tree


def checked(path: Path, workspace: Workspace) -> list[Problem]:
    """Return the errors and warnings of a tree, a scene, a robot or a skill file, each with its file.

    Args:
        path: the file: ``*.py`` is a skill, ``robot.yaml`` a robot, what lies in ``scenes/`` a scene, else a tree.
        workspace: where it would run.
    """
    return settled({path: findings(path, workspace)})


def findings(path: Path, workspace: Workspace) -> list[Problem]:
    """Return what checking one file finds, also in files that it needs; nothing is allowed yet."""
    try:
        found = _load(path, workspace)
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
        try:
            source = read_text(path)
        except UserError:  # a finding tells of it, or it is no file (a --set)
            continue
        problems = allow.remaining(source, file, problems, complete=complete)
    order = {file: number for number, file in enumerate(files)}

    def place(problem: Problem) -> tuple[int, int, int]:
        where = problem.place or Place("")
        return order.get(where.file, -1), where.line, where.column

    return sorted(problems, key=place)


def _load(path: Path, workspace: Workspace) -> Sequence[Problem]:
    """Load a file; return its warnings.

    Raises:
        UserError: with its errors.
    """
    if path.suffix == ".py":
        Registry.of(workspace)
    elif path.name == "robot.yaml":
        RobotModel(load_robot_config(path))
    elif path.parent.name == "scenes":
        load_scene(path)
    else:
        return load_tree(path, workspace).warnings
    return ()
