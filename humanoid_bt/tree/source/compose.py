"""Trees built in Python, of the same classes and under the same checks as those in files."""

from __future__ import annotations

import copy
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any, get_args

from py_trees.behaviour import Behaviour

from humanoid_bt.core.errors import Place, Problem, UserError, relative
from humanoid_bt.core.items import Item, item_of
from humanoid_bt.core.params import Param, params_of
from humanoid_bt.core.reading import convert
from humanoid_bt.decision.assign import keys_read
from humanoid_bt.decision.blackboard import Key, are_keys, exchanged, keys_in
from humanoid_bt.decision.overridden import not_made
from humanoid_bt.decision.skill import node_type_name
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.checks import World, check
from humanoid_bt.tree.draft import Draft
from humanoid_bt.tree.expressions.holding import expressions_of
from humanoid_bt.tree.node_type import NodeType
from humanoid_bt.tree.nodes.registry import Registry
from humanoid_bt.tree.nodes.subtree import SubTree
from humanoid_bt.tree.source.build import collect, make
from humanoid_bt.tree.source.file import check_name
from humanoid_bt.tree.source.given import plain_item
from humanoid_bt.tree.source.load import Loader
from humanoid_bt.tree.source.parameters import Parameters, declarations
from humanoid_bt.tree.source.read import Reader
from humanoid_bt.tree.source.scope import Scope
from humanoid_bt.tree.source.values import literals_of
from humanoid_bt.tree.ticking.tick import Branch
from humanoid_bt.tree.tree import Tree
from humanoid_bt.tree.write import written


def make_tree(
    root: Behaviour,
    workspace: str | PathLike[str] | Workspace | None = None,
    *,
    name: str = "tree",
    description: str = "",
    robot: str | None = None,
    scene: str | None = None,
) -> Tree:
    """Return a tree of nodes that were made in Python.

    Keys of the blackboard are one key wherever they have one name: ``Key("place")``, or ``"place"`` for a parameter
    that names one; one with an initial value has it each time the tree starts. Messages name the line that calls this
    function.

    Args:
        root: the root node, of :mod:`humanoid_bt.tree.nodes`.
        workspace: where its skills and sub-trees are from; the current one if None.
        name: what the tree is called.
        description: one line for people.
        robot, scene: what it is made for.

    Raises:
        UserError: with everything that ``check`` would find in a file.
    """
    caller = sys._getframe(1)
    place = Place(relative(Path(caller.f_code.co_filename)), caller.f_lineno, 1)
    problems: list[Problem] = []
    if not isinstance(root, Behaviour):
        given = f"the class {root.__name__}" if isinstance(root, type) else repr(root)
        hint = 'like Sequence("name", [...]), of humanoid_bt.tree.nodes'
        raise UserError(f"the root of a tree must be a node, not {given}", place, hint, "invalid-node")
    if problem := not_made(root):
        raise UserError([problem])
    _check_name(name, place, problems)
    workspace = workspace if isinstance(workspace, Workspace) else Workspace(workspace)
    header = {"name": name, "description": description, "robot": robot, "scene": scene}
    try:
        return _composed(root, workspace, header, place, problems)
    except RecursionError:
        message, hint = "the nodes of the tree are nested too deeply", "put nodes side by side, below a sequence"
        raise UserError(message, place, hint, "too-large") from None


def _composed(
    root: Behaviour, workspace: Workspace, header: dict[str, Any], place: Place, problems: list[Problem]
) -> Tree:
    registry = Registry.of(workspace)
    blackboard = _initial_values(root, place)
    scope = Scope(Parameters({}, {}, problems), declarations(blackboard, "key", problems), {}, {}, problems)
    loader = Loader(workspace, problems)
    composer = _Composer(registry, scope, loader, place, problems)
    draft = composer.draft(root)
    scope.finish()
    problems += check(draft, World.of(workspace, item_of(header, place), problems))
    _raise_if_wrong(problems)
    composer.fill()
    _raise_if_wrong(problems)
    tree = Tree(
        name=header["name"],
        description=header["description"],
        path=Path(place.file),
        robot=header["robot"],
        scene=header["scene"],
        parameters={},
        source="",
        nodes=collect(draft, header["name"], composer.made),
        keys=tuple(scope.own_keys),
        header={**header, "blackboard": blackboard.plain()},
        files=loader.files,
        workspace=workspace,
        warnings=tuple(problems),
    )
    return replace(tree, source=tree.to_yaml())


class _Composer:
    """Turns nodes back into what a file would say about them."""

    def __init__(self, registry: Registry, scope: Scope, loader: Loader, place: Place, problems: list[Problem]) -> None:
        self._types = {node_type.cls: node_type for node_type in registry.values()}
        self._registry = registry
        self._scope = scope
        reader = _MixedReader(registry, (), scope, loader, problems)
        reader.made = self._argument
        self._subtrees = _SubTrees(registry["subtree"], reader, loader, place, problems)
        self._place = place
        self._problems = problems
        self.made: dict[int, Behaviour] = {}
        self._given: set[Behaviour] = set()  # to sub-trees
        self._drafts: list[Draft] = []  # kept alive: their ids are keys
        self._unfilled: list[tuple[SubTree, Draft]] = []

    def draft(self, behaviour: Behaviour, like: bool = False) -> Draft:
        """Return the draft of a node and those below it, with every mistake noted.

        Args:
            behaviour: the node.
            like: whether the draft is of another node that is like it, and will be made.
        """
        if isinstance(behaviour, SubTree) and not like:
            self._take_arguments(behaviour)
        subtree = self._subtrees.draft(behaviour) if isinstance(behaviour, SubTree) else None
        node_type = self._type(behaviour) if subtree is None else subtree.type
        draft = Draft(node_type, self._place, behaviour.name) if subtree is None else subtree
        self._drafts.append(draft)
        if not like and behaviour in self.made.values():
            self._stands_twice(behaviour)
            draft.sound = False
            return draft
        if not like:
            self.made[id(draft)] = behaviour
        if isinstance(behaviour, SubTree):
            if not like:
                self._unfilled.append((behaviour, draft))
            return draft
        _check_name(behaviour.name, self._place, self._problems)
        values = {name: value for name in node_type.params if (value := getattr(behaviour, name, None)) is not None}
        given = {name: item_of(value, self._place) for name, value in values.items()}
        literals = literals_of(node_type, values, given)
        for spec in node_type.params.values():
            self._parameter(draft, behaviour, spec, literals, like)
        draft.children = [self.draft(child, like) for child in _children(node_type, behaviour)]
        if node_type.takes == "many" and not draft.children:
            message = f"{node_type.type_name!r} {behaviour.name!r} needs at least one child"
            self._problem(message, "give it a list of nodes", "missing-child")
        for key, slot in node_type.branches.items():
            branch = getattr(behaviour, key + "_" if hasattr(behaviour, key + "_") else key, None)
            if slot.many and not branch and slot.required:
                message = f"{key!r} of {node_type.type_name!r} {behaviour.name!r} is empty"
                self._problem(message, f"{key}: {slot.doc}", "missing-parameter")
            elif slot.many:
                draft.branches[key] = {case: self.draft(child, like) for case, child in (branch or {}).items()}
            elif branch is not None:
                draft.branches[key] = self.draft(branch, like)
        return draft

    def fill(self) -> None:
        """Make what stands in the files of sub-trees. To be called once there are no mistakes."""
        for subtree, draft in self._unfilled:
            child = make(draft.children[0], self.made, self._problems)
            if child is not None:
                subtree.fill(child, draft.keys, draft.taken)

    def _type(self, behaviour: Behaviour) -> NodeType:
        cls = type(behaviour)
        if cls in self._types:
            return self._types[cls]
        if behaviour.children:
            ours = "humanoid_bt.tree.nodes has those that can be used"
            self._problem(f"{cls.__module__}.{cls.__name__} has children and is none of our nodes", ours)
        elif node_type_name(cls) in self._registry:
            self._problem(
                f"the class {cls.__name__} of {behaviour.name!r} is not the workspace's {node_type_name(cls)!r}",
                f'Registry.of(workspace)["{node_type_name(cls)}"].cls',
            )
        else:
            self._problem(f"the workspace has no skill {node_type_name(cls)!r}", "put its class into a file in skills/")
        return NodeType(node_type_name(cls), "skill", cls, "", {})

    def _take_arguments(self, subtree: SubTree) -> None:
        """Note which nodes a sub-tree is given: its file may use them several times, and nobody else."""
        for node in subtree.arguments.values():
            if isinstance(node, Behaviour):
                if node in self._given or node in self.made.values():
                    self._stands_twice(node)
                self._given.add(node)

    def _argument(self, behaviour: Behaviour) -> Draft:
        """Return the draft of a node that a sub-tree is given; where it is used again, of another one like it."""
        return self.draft(behaviour, like=behaviour in self.made.values())

    def _stands_twice(self, behaviour: Behaviour) -> None:
        self._problem(f"the node {behaviour.name!r} stands in the tree twice", "make one for each place")

    def _parameter(
        self, draft: Draft, behaviour: Behaviour, spec: Param, literals: Mapping[str, Sequence[Item]], like: bool
    ) -> None:
        name = spec.name
        dynamic = keys_read(behaviour).get(name)
        if dynamic is not None:
            key = self._scope.read(dynamic.name, self._place, spec)
            keys_read(behaviour)[name] = draft.values[name] = key
            draft.references[name] = dynamic.name
            if not draft.type.dynamic:
                self._problem(f"{name!r} of {behaviour.name!r} cannot be read from the blackboard", "give it a value")
            return
        value: Any = getattr(behaviour, name, None)
        if like and expressions_of(value):
            value = copy.deepcopy(value)
        try:
            value = self._value(value, spec, literals)
        except UserError as error:
            of = f" of {behaviour.name!r}"
            self._problems += [Problem(f"{p.message}{of}", p.place, p.hint, p.code) for p in error.problems]
            draft.sound = False
            return
        for expression in expressions_of(value):
            expression.place = self._place
            self._scope.add(expression)
        if not like:
            setattr(behaviour, name, value)
        draft.values[name] = value

    def _value(self, value: Any, spec: Param, literals: Mapping[str, Sequence[Item]]) -> Any:
        """Return a parameter's value as if a file had given it: text with a unit as a number, a key as the tree's own.

        Raises:
            UserError: it takes no such value.
        """
        if isinstance(value, Key):
            return self._scope.write(value.name, self._place, literals=literals.get(value.name, ()))
        if are_keys(value):
            return exchanged(value, lambda part: self._value(part, spec, literals))
        if expressions_of(value) or (value is None and not spec.required and spec.default is None):
            return value
        return convert(spec, item_of(value, self._place))

    def _problem(self, message: str, hint: str, code: str = "invalid-node") -> None:
        self._problems.append(Problem(message, self._place, hint, code))


class _SubTrees:
    """Reads the files of sub-trees that are used in Python, as if a file used them.

    Args:
        node_type: the type of a sub-tree's node.
        reader: reads nodes, with the names of the tree made in Python.
        loader: reads the files.
        place: where the tree is made.
        problems: takes every mistake.
    """

    def __init__(
        self, node_type: NodeType, reader: _MixedReader, loader: Loader, place: Place, problems: list[Problem]
    ) -> None:
        self._type, self._reader, self._loader = node_type, reader, loader
        self._place, self._problems = place, problems

    def draft(self, subtree: SubTree) -> Draft:
        """Return the draft of a sub-tree and of what stands in its file."""
        before = len(self._problems)
        draft = None
        try:
            draft = self._reader.node(self._item(subtree), "a sub-tree")
        except UserError as error:
            self._problems += error.problems
        for index, problem in enumerate(self._problems[before:], before):
            if problem.place == self._place:  # the one line that all of the tree has
                self._problems[index] = replace(problem, message=f"{problem.message}, in {subtree.name!r}")
        return draft or Draft(self._type, self._place, subtree.name, sound=False)

    def _item(self, subtree: SubTree) -> Item:
        """Return what a file would say."""
        place = self._place
        tree = Item({"tree": Item(subtree.tree, place)}, place)
        declared = self._loader.specialise(self._type, tree).params
        body = {name: self._argument(declared.get(name), name, value) for name, value in subtree.arguments.items()}
        body |= tree.value | {"name": Item(subtree.name, place)}
        return Item({"subtree": Item(body, place, dict.fromkeys(body, place))}, place, {"subtree": place})

    def _argument(self, spec: Param | None, name: str, value: Any) -> Item:
        writes = spec is not None and Key in get_args(spec.type)
        if isinstance(value, Behaviour):
            return Item(value, self._place)
        if isinstance(value, Key):
            return Item(value.name if writes else f"${value.name}", self._place)
        if isinstance(value, str) and value.startswith("$"):
            return Item(f"${value}", self._place)  # in a file, text that is no reference
        return plain_item(name, value, self._place)


class _MixedReader(Reader):
    """Reads nodes of files, and takes those that were made in Python."""

    made: Callable[[Behaviour], Draft]

    def node(self, item: Item, where: str) -> Draft | None:
        """Read a node, or take one that was made."""
        return self.made(item.value) if isinstance(item.value, Behaviour) else super().node(item, where)


def _initial_values(root: Behaviour, place: Place) -> Item:
    """Return the keys of a tree that have an initial value, as a file declares them.

    Raises:
        UserError: one has two, or one that no file could hold.
    """
    found: dict[str, Item] = {}
    for key in _keys(root):
        if not key.has_initial:
            continue
        default = item_of(written(plain_item(key.name, key.initial, place).plain()), place)
        item = Item({"default": default}, place, {"default": place})
        if found.setdefault(key.name, item) != item:
            message = f"the key {key.name!r} has two initial values"
            raise UserError(message, place, "give it one, or make one Key for all nodes", "taken-name")
    return Item(found, place, dict.fromkeys(found, place))


def _keys(root: Behaviour) -> Iterator[Key]:
    """Return every key that nodes are given; one may come more than once."""
    for node in root.iterate():
        values = [getattr(node, name, None) for name in params_of(type(node))]
        values += keys_read(node).values()
        values += node.arguments.values() if isinstance(node, SubTree) else ()
        for value in values:
            if isinstance(value, Behaviour):
                yield from _keys(value)
            else:
                yield from keys_in(value)


def _raise_if_wrong(problems: list[Problem]) -> None:
    if any(problem.severity == "error" for problem in problems):
        raise UserError(list(dict.fromkeys(problems)))


def _children(node_type: NodeType, behaviour: Behaviour) -> list[Behaviour]:
    if node_type.takes == "one":
        return [behaviour.decorated]  # type: ignore[attr-defined]  # a Decorator
    return list(behaviour.children) if node_type.takes == "many" or not isinstance(behaviour, Branch) else []


def _check_name(name: str, place: Place, problems: list[Problem]) -> None:
    try:
        check_name(Item(name, place))
    except UserError as error:
        problems += error.problems
