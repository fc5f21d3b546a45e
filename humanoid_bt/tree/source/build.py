"""Making a tree's nodes from their drafts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from keyword import iskeyword

from py_trees.behaviour import Behaviour
from py_trees.behaviours import Dummy

from humanoid_bt.core.errors import Problem, UserError
from humanoid_bt.core.params import own
from humanoid_bt.core.texts import told
from humanoid_bt.decision.overridden import not_made
from humanoid_bt.files.class_files import class_file, place_in_file
from humanoid_bt.tree.draft import Draft
from humanoid_bt.tree.node import Node
from humanoid_bt.tree.nodes.subtree import SubTree
from humanoid_bt.tree.tree import Tree


def build(root: Draft, tree_name: str, problems: list[Problem]) -> tuple[Node, ...]:
    """Return every node of a tree, parents before children.

    Args:
        root: the tree's root.
        tree_name: the first part of every path.
        problems: takes the mistakes that only show when a node is made; the nodes are incomplete then.
    """
    made: dict[int, Behaviour] = {}
    if make(root, made, problems) is None:
        return ()
    return collect(root, tree_name, made)


def remade(tree: Tree, root: Draft) -> Tree:
    """Return a tree whose nodes are made anew, as if its file had been loaded once more.

    Args:
        tree: it; its keys are those of the new one too.
        root: its draft, or another in its place. It begins anew: nothing that other nodes left in it is found.

    Raises:
        UserError: a skill's constructor raised an exception this time.
    """
    problems: list[Problem] = []
    nodes = build(root, tree.name, problems)
    if problems:
        raise UserError(problems)
    for key in tree.keys:
        key.reset()
    root.begin_anew()
    return replace(tree, nodes=nodes)


def paths(root: Draft, tree_name: str) -> Iterator[tuple[str, Draft]]:
    """Yield every draft with the path that its node will have, parents before children."""
    waiting = [(f"{tree_name}/{root.name}", root)]
    while waiting:
        path, draft = waiting.pop()
        yield path, draft
        waiting += [(below, child) for _, below, child in _below(draft, path)]


def sketch(root: Draft, tree_name: str) -> tuple[Node, ...]:
    """Return every node of a tree that cannot be made yet, with behaviours that do nothing: to be shown, not run."""
    return collect(root, tree_name, {id(draft): Dummy(draft.name) for draft in root.iterate()})


def collect(root: Draft, tree_name: str, made: Mapping[int, Behaviour]) -> tuple[Node, ...]:
    """Return every node of a tree whose behaviours have been made, parents before children.

    Args:
        root: the tree's root.
        tree_name: the first part of every path.
        made: the behaviour of each draft, by the draft's id.
    """
    nodes: list[Node] = []
    _collect(_Step(root, f"{tree_name}/{root.name}", -1, ""), made, nodes)
    return tuple(nodes)


def make(draft: Draft, made: dict[int, Behaviour], problems: list[Problem]) -> Behaviour | None:
    """Make a node and those below it; None if a mistake is in them, but then the others have been tried.

    Args:
        draft: the node's.
        made: the nodes that are there already, by the id of their draft; takes the new ones.
        problems: takes the mistakes that only show when a node is made.
    """
    if id(draft) in made:
        return made[id(draft)]
    children = [make(child, made, problems) for child in draft.children]
    branches = {key: _make_branch(branch, made, problems) for key, branch in draft.branches.items()}
    if not draft.sound or None in children or None in branches.values():
        return None
    values = {name: own(value) for name, value in draft.values.items()}
    arguments = {key + "_" * iskeyword(key): value for key, value in {**branches, **values}.items()}
    try:
        if draft.type.takes == "many":
            behaviour = draft.type.factory(draft.name, children, **arguments)
        elif draft.type.takes == "one":
            behaviour = draft.type.factory(draft.name, children[0], **arguments)
        elif draft.type.cls is SubTree:
            behaviour = SubTree(draft.name, tree=draft.values["tree"])
            behaviour.fill(made[id(draft.children[0])], draft.keys, draft.taken)
        else:
            behaviour = draft.type.factory(name=draft.name, **arguments)
    except Exception as error:  # a skill's constructor is the user's code
        builtin = isinstance(error, ValueError) and draft.type.kind != "skill"
        what = str(error) if builtin else told(error)
        file = class_file(draft.type.cls)
        place = place_in_file(error, file) if file and not builtin else None
        hint = f"raised at {place}" if place else ""
        problems.append(Problem(f"{draft.type.type_name!r} cannot be made: {what}", draft.place, hint, "invalid-node"))
        return None
    if unmade := not_made(behaviour):
        if unmade not in problems:  # many nodes may be of one class
            problems.append(unmade)
        return None
    made[id(draft)] = behaviour
    return behaviour


def _make_branch(
    branch: Draft | dict[str, Draft], made: dict[int, Behaviour], problems: list[Problem]
) -> Behaviour | dict[str, Behaviour] | None:
    if isinstance(branch, Draft):
        return make(branch, made, problems)
    found = {name: make(child, made, problems) for name, child in branch.items()}
    whole = {name: behaviour for name, behaviour in found.items() if behaviour is not None}
    return whole if len(whole) == len(found) else None


@dataclass(frozen=True)
class _Step:
    draft: Draft
    path: str
    parent: int
    branch: str


def _collect(step: _Step, made: Mapping[int, Behaviour], nodes: list[Node]) -> None:
    draft, path = step.draft, step.path
    behaviour = made[id(draft)]
    vars(behaviour)["path"] = path  # plain behaviours know their path too
    index = len(nodes)
    nodes.append(
        Node(
            path,
            draft.name,
            draft.type,
            draft.values,
            draft.place,
            behaviour,
            step.parent,
            step.branch,
            draft.references,
            draft.arguments,
            draft.written,
            draft.unresolved,
        )
    )
    for key, below, child in _below(draft, path):
        _collect(_Step(child, below, index, key), made, nodes)


def _below(draft: Draft, path: str) -> Iterator[tuple[str, str, Draft]]:
    """Yield the key, the path and the draft of every node right below one."""
    taken: Counter[str] = Counter()
    for key, child in draft.below():
        below = f"{path}/{child.name}"
        while below in taken:
            taken[below] += 1
            below = f"{below}#{taken[below]}"
        taken[below] = 1
        yield key, below, child
