"""Loading tree files."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from humanoid_bt.core.errors import Place, Problem, UserError, nearest, relative, resolved
from humanoid_bt.core.items import Item
from humanoid_bt.core.params import Param
from humanoid_bt.core.sources import Sources
from humanoid_bt.decision.blackboard import Key
from humanoid_bt.files.reading import is_file
from humanoid_bt.files.workspace import Workspace, is_path
from humanoid_bt.tree.checks import World, check
from humanoid_bt.tree.draft import Draft
from humanoid_bt.tree.node import Node
from humanoid_bt.tree.node_type import NodeType
from humanoid_bt.tree.nodes.registry import Registry
from humanoid_bt.tree.slots import Slot
from humanoid_bt.tree.source.build import build, sketch
from humanoid_bt.tree.source.file import TreeFile, read_file
from humanoid_bt.tree.source.given import overrides
from humanoid_bt.tree.source.parameters import Argument, NodeItem, Parameters
from humanoid_bt.tree.source.read import Reader
from humanoid_bt.tree.source.scope import Scope
from humanoid_bt.tree.tree import Tree

MAX_NODES = 10_000
"""Most nodes of one tree, sub-trees and nodes that are parameters counted each time they are used."""


def load_tree(
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
    """Read, check and build a tree.

    Args:
        path: the tree file.
        workspace: where its skills and sub-trees are found.
        parameters: values for its parameters, or text as after ``--set``, by name.
        robot, scene: check it for these, instead of those that its header names.
        perception: check it with these percept sources, instead of those that its header or its scene names.
        others: percepts that come from elsewhere, as through a gateway.
        arguments: what else can be given beside the parameters, for hints.

    Raises:
        UserError: with every mistake found, each with its place.
    """
    found: list[Problem] = []
    tree = Loader(workspace, found).load(
        path, parameters or {}, robot, scene, perception=perception, others=others, arguments=arguments
    )
    problems = _in_file_order(found, relative(path))
    if tree is None:
        raise UserError(problems)
    return replace(tree, warnings=tuple(problems))


def subtree_types(workspace: Workspace, registry: Registry) -> dict[str, NodeType]:
    """Return for every tree of a workspace the type of a node that uses it as a sub-tree; broken ones are left out."""
    loader, node_type = Loader(workspace, []), registry["subtree"]
    found: dict[str, NodeType] = {}
    for name, path in workspace.trees().items():
        item = Item(name, Place(relative(path)))
        with suppress(UserError):
            found[name] = loader.specialise(node_type, Item({"tree": item}, item.place))
    return found


class Loader:
    """Reads one tree and every file that it uses.

    Args:
        workspace: where skills and sub-trees are found.
        problems: takes every mistake.
    """

    def __init__(self, workspace: Workspace, problems: list[Problem]) -> None:
        self._workspace = workspace
        self._files: dict[Path, TreeFile] = {}
        self._nodes = 0
        self.problems = problems

    @property
    def files(self) -> tuple[Path, ...]:
        """The files that were read."""
        return tuple(file.path for file in self._files.values())

    def load(
        self,
        path: Path,
        values: Mapping[str, Any],
        robot: str | None,
        scene: str | None,
        *,
        perception: Sources | None,
        others: Collection[str],
        arguments: Collection[str],
    ) -> Tree | None:
        """Return the tree, None if mistakes keep it from being made."""
        file = self._open(path)
        given = overrides(file.parameters, values, self.problems, arguments)
        parameters = Parameters(file.parameters, given, self.problems, complete=not file.header.get("subtree"))
        scope = Scope(parameters, file.blackboard, file.outputs, {}, self.problems)
        registry = self._registry()
        root = None
        if registry is not None:
            root = self._read(file, Reader(registry, (file,), scope, self, self.problems))
        world = World.of(self._workspace, file.item, self.problems, robot, scene, perception=perception, others=others)
        made: tuple[Node, ...] = ()
        if root is not None:
            self.problems += check(root, world, alone=bool(file.header.get("subtree")))
            made = build(root, file.name, self.problems)
        if root is None or any(problem.severity == "error" for problem in self.problems):
            return None
        return Tree(
            name=file.name,
            description=file.header.get("description", ""),
            path=path,
            robot=file.header.get("robot"),
            scene=file.header.get("scene"),
            perception=file.header.get("perception"),
            parameters=parameters.values,
            source=file.source,
            nodes=made or sketch(root, file.name),
            complete=bool(made),
            keys=tuple(scope.own_keys),
            header=file.plain_header(given),
            files=self.files,
            workspace=self._workspace,
            draft=root,
        )

    # ---- sub-trees (see SubTrees) --------------------------------------------------------------------------------

    @property
    def trees(self) -> Collection[str]:
        """The names of the workspace's trees."""
        return self._workspace.trees()

    def specialise(self, node_type: NodeType, body: Item) -> NodeType:
        """Return the type of a sub-tree node with the parameters of the tree that its body names."""
        if not isinstance(body.value, dict) or "tree" not in body.value:
            return node_type
        item = body.value["tree"]
        if not isinstance(item.value, str):
            return node_type
        file = self._open(self._find(item))
        params = {
            name: declared.spec for name, declared in file.parameters.items() if declared.spec.type is not NodeItem
        }
        nodes = {
            name: Slot(declared.spec.doc, required=declared.default is None)
            for name, declared in file.parameters.items()
            if declared.spec.type is NodeItem
        }
        outputs = {name: declared.spec for name, declared in file.outputs.items()}
        keys = {name: Param(name, Key | None, None, spec.doc) for name, spec in outputs.items()}
        return replace(node_type, params={**node_type.params, **params, **keys}, branches=nodes, outputs=outputs)

    def takes_one_more(self, place: Place) -> bool:
        """Count a node; note it once, and return False, if there are too many."""
        self._nodes += 1
        if self._nodes == MAX_NODES + 1:
            message = f"the tree has more than {MAX_NODES} nodes, its sub-trees expanded"
            self.problems.append(Problem(message, place, "use fewer or smaller sub-trees", "too-large"))
        return self._nodes <= MAX_NODES

    def expand(self, draft: Draft, body: Item, reader: Reader) -> None:
        """Read the nodes of a sub-tree into the draft of the node that uses it."""
        item = body.value.get("tree")
        if item is None or "tree" not in draft.values:
            return
        file = self._open(self._find(item))
        if file in reader.files:
            names = " -> ".join(used.name for used in (*reader.files, file))
            message = f"the tree {file.name!r} would contain itself"
            self.problems.append(Problem(message, item.place, names, "subtree-cycle"))
            draft.sound = False
            return
        arguments = self._arguments(draft, body, file, reader)
        bound = {name: draft.values[name] for name in file.outputs if isinstance(draft.values.get(name), Key)}
        missing = [name for name in file.parameters if name not in arguments and file.parameters[name].default is None]
        parameters = Parameters(file.parameters, arguments, self.problems, complete=False)
        scope = Scope(parameters, file.blackboard, file.outputs, bound, self.problems)
        root = self._read(file, reader.inside(file, scope))
        if root is None or missing:
            draft.sound = False
        if root is not None:
            draft.children.append(root)
            draft.keys = scope.own_keys

    def _arguments(self, draft: Draft, body: Item, file: TreeFile, reader: Reader) -> dict[str, Argument]:
        """Return what the sub-tree's parameters are given."""
        found: dict[str, Argument] = {}
        for name, declared in file.parameters.items():
            if declared.spec.type is NodeItem:
                if name in body.value:
                    draft.arguments[name] = body.value[name].plain()
                    found[name] = Argument(body.value[name], body.value[name].place, reader)
                elif declared.default is None:
                    message = f"the node {name!r} of 'subtree' is missing"
                    self.problems.append(
                        Problem(message, draft.place, f"{name}: {declared.spec.doc}", "missing-parameter")
                    )
            elif name in draft.values:
                value = draft.values[name]
                if isinstance(value, Key):  # in the sub-tree, a key of its own
                    own = Key(name)
                    own.spec = declared.spec
                    draft.taken[own], value = value, own
                found[name] = Argument(value, draft.value_places[name], written=draft.written.get(name))
        return found

    def _find(self, item: Item) -> Path:
        """Return the file of a sub-tree: beside the file that uses it, links followed, if a path; else by its name."""
        name: str = item.value
        if is_path(name):
            beside = resolved(Path(item.place.file)).parent / name
            if is_file(beside):
                return beside
            message = f"no tree file {name!r} beside {Path(item.place.file).name!r}"
            raise UserError(message, item.place, nearest(beside.stem, self.trees), "unknown-tree")
        try:
            return self._workspace.find_tree(name)
        except UserError as error:
            problem = error.problems[0]
            raise UserError(problem.message, item.place, problem.hint, "unknown-tree") from error

    # ---- files ---------------------------------------------------------------------------------------------------

    def _read(self, file: TreeFile, reader: Reader) -> Draft | None:
        """Read a file's nodes, and judge the names in it; what is unused, only if all else in it is right."""
        root, before = None, len(self.problems)
        if file.root is not None:
            root = reader.node(file.root, "the root")
        reader.scope.finish()
        if root is not None and not any(problem.severity == "error" for problem in self.problems[before:]):
            reader.scope.parameters.report_unused()
        return root

    def _open(self, path: Path) -> TreeFile:
        """Return a tree file; its mistakes are noted once.

        Raises:
            UserError: it cannot be read as a mapping.
        """
        key = resolved(path)
        if key not in self._files:
            self._files[key] = read_file(path, self.problems)
        return self._files[key]

    def _registry(self) -> Registry | None:
        try:
            return Registry.of(self._workspace)
        except UserError as error:
            self.problems += error.problems
            return None


def _in_file_order(problems: Sequence[Problem], first: str) -> list[Problem]:
    """Return the problems as a reader meets them: those of the first file by line, then the others."""

    def order(problem: Problem) -> tuple[bool, str, int, int]:
        place = problem.place
        if place is None:
            return (True, "", 0, 0)
        return (place.file != first, place.file, place.line, place.column)

    return sorted(dict.fromkeys(problems), key=order)
