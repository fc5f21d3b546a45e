"""What programs do with trees before they run: load them, look up skills."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from os import PathLike
from typing import Any

from py_trees.behaviour import Behaviour

from humanoid_bt.checking.check import load_checked
from humanoid_bt.core.errors import UserError
from humanoid_bt.decision.skill_files import load_skills
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.source.given import given
from humanoid_bt.tree.tree import Tree

_ARGUMENTS = ("workspace", "robot", "scene", "parameters")


def load(
    tree: str | PathLike[str],
    *,
    workspace: str | PathLike[str] | Workspace | None = None,
    robot: str | PathLike[str] | None = None,
    scene: str | PathLike[str] | None = None,
    parameters: Mapping[str, Any] | None = None,
    **values: Any,
) -> Tree:
    """Read, check and build a tree.

    Args:
        tree: its name or file.
        workspace: folder in which names are looked up; else the file's own, or the working directory.
        robot, scene: check it for these, instead of those that it names.
        parameters: values for its parameters, for names that are those of arguments too.
        values: values for its parameters: 0.45, or text as after ``--set``, "45 cm".

    Raises:
        UserError: with every mistake found, each with its place.
    """
    if not isinstance(tree, (str, os.PathLike)):
        raise UserError(f"'tree' must be the name or the file of a tree, not {tree!r}")
    name = os.fspath(tree)
    where = Workspace.of_argument(name, workspace)
    return load_checked(
        where.find_tree(name),
        where,
        given(parameters, values),
        robot=None if robot is None else os.fspath(robot),
        scene=None if scene is None else os.fspath(scene),
        arguments=_ARGUMENTS if values else (),
    )


def skills(workspace: str | PathLike[str] | Workspace | None = None) -> dict[str, Callable[..., Behaviour]]:
    """Return every skill of a workspace by its name in trees: its class, which makes a node.

    Args:
        workspace: their folder, on top of the built-in ones; the working directory if None.

    Raises:
        UserError: a skill has mistakes.
    """
    where = workspace if isinstance(workspace, Workspace) else Workspace(workspace)
    return dict(load_skills(where))
