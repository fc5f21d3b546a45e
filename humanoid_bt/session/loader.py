"""Loading the tree of a run: at its start, and again whenever it was edited."""

from __future__ import annotations

import types
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any
from weakref import WeakSet

from py_trees.behaviour import Behaviour

from humanoid_bt.checking.check import load_checked
from humanoid_bt.core.errors import Place, Problem, UserError, relative, resolved
from humanoid_bt.files import document
from humanoid_bt.files.class_files import class_file
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.gateway.file import load_gateway
from humanoid_bt.session.options import RunOptions
from humanoid_bt.tree.tree import Tree

DEFAULT_ROBOT, DEFAULT_SCENE = "humanoid", "empty"

_taken: WeakSet[Behaviour] = WeakSet()  # roots of trees that were given as such


class TreeLoader:
    """Loads the tree of a run.

    Args:
        options: what to run.
        workspace: where names are looked up.

    Attributes:
        first: the tree as it is at the start.
        robot, scene: the files of its robot and its scene, which stay.

    Raises:
        UserError: the tree has mistakes, does not run alone, or there is no such tree, robot or scene.
    """

    def __init__(self, options: RunOptions, workspace: Workspace) -> None:
        self._options, self._workspace = options, workspace
        gateway = options.gateway
        self._others = tuple(load_gateway(workspace.find_gateway(gateway)).percepts) if gateway else ()
        self._path = None if isinstance(options.tree, Tree) else workspace.find_tree(options.tree)
        self.first = self._load()
        self.robot, self.scene = self._robot(self.first), self._scene(self.first)

    def reload(self, parameters: Mapping[str, Any] = types.MappingProxyType({})) -> Tree:
        """Load the tree as it is now, with the warnings that its files do not allow.

        Args:
            parameters: values for its parameters, before those that the run was given.

        Raises:
            UserError: it has mistakes, or is for another robot or another scene.
        """
        tree = self._load(parameters)
        problems: list[Problem] = []
        for key, find, known in (("robot", self._robot, self.robot), ("scene", self._scene, self.scene)):
            try:
                if find(tree) == known:
                    continue
                message, hint = f"the {key} cannot change during a run", "end the run and start it anew"
            except UserError as error:
                message, hint = error.problems[0].message, error.problems[0].hint
            header = document.parse(tree.source, relative(tree.path))
            problems.append(Problem(message, header.value.get(key, header).place, hint))
        before, now = self.first.perception, tree.perception
        if self._options.perception is None and (before and before.written) != (now and now.written):
            place, hint = now.place if now else Place(relative(tree.path)), "end the run and start it anew"
            problems.append(Problem("the perception cannot change during a run", place, hint))
        if problems:
            raise UserError(problems)
        return tree

    def files(self, tree: Tree) -> list[Path]:
        """Return every file that an edited version of a tree may be made of."""
        return [*tree.files, *self._workspace.tree_files(), *self._workspace.skill_files()]

    def _load(self, parameters: Mapping[str, Any] = types.MappingProxyType({})) -> Tree:
        options = self._options
        if isinstance(options.tree, Tree):
            return _once(options.tree)
        assert self._path is not None
        tree = load_checked(
            self._path,
            self._workspace,
            {**options.parameters, **parameters},
            robot=options.robot,
            scene=options.scene,
            perception=options.perception,
            others=self._others,
            arguments=options.arguments,
        )
        if tree.is_subtree:
            raise _not_alone(tree)
        return tree

    def _robot(self, tree: Tree) -> Path:
        return self._workspace.find_robot(self._options.robot or tree.robot or DEFAULT_ROBOT)

    def _scene(self, tree: Tree) -> Path:
        return self._workspace.find_scene(self._options.scene or tree.scene or DEFAULT_SCENE)


def workspace_of(tree: str | Tree, given: str | PathLike[str] | Workspace | None) -> Workspace:
    """Return where the names of a run are looked up.

    Args:
        tree: what runs.
        given: the workspace that was asked for, if any.

    Raises:
        UserError: it is no folder.
    """
    if given is None and isinstance(tree, Tree):
        return tree.workspace or Workspace()
    return Workspace.of_argument("" if isinstance(tree, Tree) else tree, given)


def _once(tree: Tree) -> Tree:
    """Return a tree that no session has had yet.

    Raises:
        UserError: one has had it: its nodes remember.
    """
    if not tree.complete:
        raise _not_alone(tree)
    if tree.root in _taken:
        hint = "give its name or file instead of it, or load or make it anew for each session"
        raise UserError(f"the tree {tree.name!r} was in a session before, and its nodes remember", hint=hint)
    _taken.add(tree.root)
    return tree


def _not_alone(tree: Tree) -> UserError:
    """Return what is said about running a tree that is made for use in other trees."""
    declared = tree.header.get("parameters") or {}
    needed = [name for name, value in declared.items() if isinstance(value, dict) and value.get("default") is None]
    given = "".join(f", {name}: ..." for name in needed)
    message = f"the tree {tree.name!r} does not run alone: it is made for use in other trees (subtree: true)"
    return UserError(message, Place(relative(tree.path)), f"in another one: subtree: {{tree: {tree.path.stem}{given}}}")


def used_files(tree: Tree) -> set[Path]:
    """Return the files that a tree is made of: tree files, and those of its skills."""
    skills = (class_file(node.type.cls) for node in tree.nodes if node.kind == "skill")
    return {resolved(path) for path in (*tree.files, *skills) if path is not None}
