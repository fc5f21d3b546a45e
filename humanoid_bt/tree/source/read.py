"""Reading the nodes of a tree file: from YAML items to drafts, with every mistake noted and none raised."""

from __future__ import annotations

from collections.abc import Collection
from typing import Protocol

from humanoid_bt.core.errors import Place, Problem, UserError, nearest
from humanoid_bt.core.items import Item
from humanoid_bt.tree.draft import Draft
from humanoid_bt.tree.node_type import CHILD, NodeType, placeholder
from humanoid_bt.tree.nodes import other_libraries
from humanoid_bt.tree.nodes.registry import Registry
from humanoid_bt.tree.nodes.subtree import SubTree
from humanoid_bt.tree.slots import Slot
from humanoid_bt.tree.source.file import TreeFile
from humanoid_bt.tree.source.mend import Mender
from humanoid_bt.tree.source.parameters import NodeItem, reference
from humanoid_bt.tree.source.scope import Scope
from humanoid_bt.tree.source.values import ValueReader


class SubTrees(Protocol):
    """Who reads other tree files."""

    @property
    def trees(self) -> Collection[str]:
        """The names of the trees that can be used."""

    def specialise(self, node_type: NodeType, body: Item) -> NodeType:
        """Return the type of a sub-tree node with the parameters of the tree that its body names.

        Raises:
            UserError: there is no such tree, or its file cannot be used.
        """

    def takes_one_more(self, place: Place) -> bool:
        """Count a node; note it once, and return False, if there are too many."""

    def expand(self, draft: Draft, body: Item, reader: Reader) -> None:
        """Read the nodes of a sub-tree into the draft of the node that uses it."""


class Reader:
    """Reads the nodes of one tree file.

    Args:
        registry: the node types.
        files: the file, and before it those that use it, the outermost first.
        scope: what names mean in the file.
        subtrees: who reads other files.
        problems: takes every mistake.
    """

    def __init__(
        self,
        registry: Registry,
        files: tuple[TreeFile, ...],
        scope: Scope,
        subtrees: SubTrees,
        problems: list[Problem],
    ) -> None:
        self._registry = registry
        self._subtrees = subtrees
        self._problems = problems
        self._values = ValueReader(scope, problems)
        self._mender = Mender(registry, problems)
        self._defaults: list[str] = []  # parameters whose default is being read, the outermost first
        self.files = files
        self.scope = scope

    def inside(self, file: TreeFile, scope: Scope) -> Reader:
        """Return a reader of a file that is used in this one."""
        return Reader(self._registry, (*self.files, file), scope, self._subtrees, self._problems)

    def node(self, item: Item, where: str) -> Draft | None:
        """Read a node: ``type``, or a mapping of one key ``type: body``; None if its type is not known.

        Args:
            item: the node.
            where: what it is, for messages ("the root").
        """
        if isinstance(item.value, str):
            return self._typed(item.value, Item(None, item.place), item.place)
        if not isinstance(item.value, dict) or not item.value:
            kind = "an empty mapping" if isinstance(item.value, dict) else item.kind
            self._problem(f"{where} must be a node, not {kind}", item.place, "like idle, or idle: {...}", "not-a-node")
            return None
        return self._of_keys(item, False)[0]

    def _of_keys(self, item: Item, in_list: bool) -> list[Draft | None]:
        """Read a mapping that should be one node; what it was meant to be if it has several keys."""
        keys = list(item.value)
        if len(keys) == 1:
            return [self._typed(keys[0], item.value[keys[0]], item.key_places[keys[0]])]
        meant = self._mender.nodes(item, in_list)
        if not meant:
            hint = f"indent what belongs to {keys[0]!r} deeper than it; several nodes stand in a list, below a sequence"
            self._problem(f"a node is one key, here are {len(keys)}", item.key_places[keys[1]], hint, "not-a-node")
            return [None]
        drafts = [self._typed(*node) for node in meant]
        for draft in drafts:
            if draft:
                draft.sound = False
        return drafts

    def _typed(self, type_name: str, body: Item, place: Place) -> Draft | None:
        if type_name.startswith("$"):
            return self._given(type_name, body, place)
        try:
            trees = () if type_name in self._registry else self._subtrees.trees  # looking for them takes time
            node_type = self._registry.find(type_name, place, trees)
            if node_type.cls is SubTree:
                body = self._main(node_type, body)
                node_type = self._subtrees.specialise(node_type, body if body.value else Item({}, place))
        except UserError as error:
            self._problems += error.problems
            self.scope.suppose(body)
            return None
        if not self._subtrees.takes_one_more(place):
            self.scope.suppose(body)
            return None
        draft = Draft(node_type, place, node_type.type_name, word=type_name)
        before = len(self._problems)
        own = self._body(draft, body)
        if own is not None:
            self._values.read(draft, own, self._unknown(draft.type, own))
        draft.sound = draft.sound and len(self._problems) == before
        if own is not None:
            self._below(draft, own)
        return draft

    def _unknown(self, node_type: NodeType, body: Item) -> list[str]:
        """Return the keys of a node that are neither its own nor nodes."""
        known = {"name", *node_type.params, *node_type.branches}
        known |= {"many": {"children"}, "one": {CHILD}, "none": set()}[node_type.takes]
        others = [key for key in body.value if key not in known]
        if node_type.takes == "one":
            others = [key for key in others if key not in self._registry and not key.startswith("$")]
        return others

    def _given(self, text: str, body: Item, place: Place) -> Draft | None:
        """Read a node that stands for a parameter: in the names of whoever gave it."""
        name = text[1:]
        parameter = self.scope.parameters.find(name)
        if parameter is None or parameter.spec.type is not NodeItem:
            nodes = [f"${known}" for known in self.scope.parameters if self._is_node(known)]
            hint = nearest(text, nodes) or "the tree declares no parameter of type node"
            self._problem(f"{text!r} is no node", place, hint, "unknown-reference")
            return None
        if body.value is not None:
            self._problem(f"{text!r} is a whole node and takes nothing", body.place, f"only {text}", "not-a-node")
            return None
        if not parameter.known:
            return Draft(placeholder(text, parameter.spec.doc), place, text, sound=False)
        where = f"the parameter {name!r}"
        draft: Draft | None = None
        if parameter.given:
            draft = parameter.given.reader.node(parameter.given.value, where)
        elif name in self._defaults:
            names = " -> ".join((*self._defaults, name))
            self._problem(f"the node {text!r} would contain itself", place, names, "subtree-cycle")
        else:
            self._defaults.append(name)
            draft = self.node(parameter.value, where)
            self._defaults.pop()
        return draft

    def _is_node(self, name: str | None) -> bool:
        parameter = self.scope.parameters.find(name) if name is not None else None
        return parameter is not None and parameter.spec.type is NodeItem

    def _main(self, node_type: NodeType, body: Item) -> Item:
        """Return a body that only gives the main parameter (``wait: 2 s``) as a mapping."""
        if node_type.main and not isinstance(body.value, (dict, list, type(None))):
            return Item({node_type.main: body}, body.place, {node_type.main: body.place})
        return body

    def _body(self, draft: Draft, body: Item) -> Item | None:
        """Return the body as a mapping, its short forms written out; None if it is none."""
        node_type, name = draft.type, draft.word
        body = self._main(node_type, body)
        if body.value is None:
            return Item({}, draft.place)
        if isinstance(body.value, dict):
            return self._mender.body(name, node_type, body)
        if isinstance(body.value, list):
            if node_type.takes == "many":
                return Item({"children": body}, draft.place, {"children": body.place})
            if meant := self._mender.without_dashes(name, body):
                return self._mender.body(name, node_type, meant)
        text = body.value
        if node_type.takes == "one" and isinstance(text, str):
            return Item({text: Item(None, body.place)}, draft.place, {text: body.place})
        hint = {
            "many": f"{name}: followed by a list of children",
            "one": f"{name}: followed by its parameters and one child",
        }.get(node_type.takes, f"{name}: {{{', '.join(f'{key}: ...' for key in node_type.params)}}}")
        message = f"what {name!r} holds must be a mapping, not {body.kind}"
        self._problem(message, body.place, hint, "wrong-type")
        return None

    # ---- what stands below ---------------------------------------------------------------------------------------

    def _below(self, draft: Draft, body: Item) -> None:
        if draft.type.cls is SubTree:
            self._subtrees.expand(draft, body, self)
            return
        if draft.type.takes == "many":
            self._children(draft, body)
        elif draft.type.takes == "one":
            self._child(draft, body)
        for key, slot in draft.type.branches.items():
            self._branch(draft, key, slot, body)

    def _children(self, draft: Draft, body: Item) -> None:
        name = draft.word
        known = [*draft.type.params, *draft.type.branches, "name", "children"]
        for key in body.value:
            if key in known:
                continue
            if key in self._registry:
                message = f"{key!r} stands beside the children of {name!r}"
                hint = "children stand in a list: - first: ..."
                self._broken(draft, message, body.key_places[key], hint, "extra-child")
            else:
                self._values.unknown(draft, body, key, known, self._registry.owners(key))
        children = body.value.get("children")
        if children is None or children.value is None or children.value == []:
            place = children.place if children else draft.place
            hint = f"{name}: followed by a list of nodes"
            self._broken(draft, f"{name!r} needs at least one child", place, hint, "missing-child")
        elif not isinstance(children.value, list):
            message = f"the children of {name!r} must be a list, not {children.kind}"
            self._broken(draft, message, children.place, "- first: ...", "wrong-type")
        else:
            for item in children.value:
                for child in self._items(item, draft):
                    self._append(draft, child)

    def _items(self, item: Item, parent: Draft) -> list[Draft | None]:
        """Read one item of a list of nodes; several nodes where their dashes are missing."""
        if isinstance(item.value, dict) and len(item.value) > 1:
            return self._of_keys(item, True)
        if isinstance(item.value, dict) and (memory := item.value.get("memory")):
            hint = other_libraries.hint_for_parameter(parent.type.type_name, "memory", memory.value)
            if hint:
                self._problem("'memory' is no node", item.key_places["memory"], hint, "unknown-node")
                return [None]
        return [self.node(item, f"a child of {parent.word!r}")]

    def _child(self, draft: Draft, body: Item) -> None:
        name, known = draft.word, {"name", *draft.type.params, *draft.type.branches}
        others = [key for key in body.value if key not in known]
        unknown = self._unknown(draft.type, body)
        for key in others:
            if key == CHILD:
                self._append(draft, self.node(body.value[key], f"the child of {name!r}"))
            elif other_libraries.hint_for_parameter(draft.type.type_name, key, body.value[key].value):
                self._values.unknown(draft, body, key, [])
            elif key in unknown:
                hint = self._registry.hint(key, known)
                message = f"{key!r} is neither a parameter of {name!r} nor a node"
                self._broken(draft, message, body.key_places[key], hint, "unknown-node")
            else:
                self._append(draft, self._typed(key, body.value[key], body.key_places[key]))
        if not others:
            hint = "a node's key beside its parameters"
            self._broken(draft, f"{name!r} needs a child", draft.place, hint, "missing-child")
        elif len(draft.children) > 1:
            hint = "put them into a sequence, a selector or a parallel"
            message = f"{name!r} has one child, here are {len(draft.children)}"
            self._broken(draft, message, draft.children[1].place, hint, "extra-child")

    def _append(self, draft: Draft, child: Draft | None) -> None:
        if child is None:
            draft.sound = False
        else:
            draft.children.append(child)

    def _branch(self, draft: Draft, key: str, slot: Slot, body: Item) -> None:
        item, where = body.value.get(key), f"{key!r} of {draft.word!r}"
        if item is None:
            if slot.required:
                self._broken(draft, f"{where} is missing", draft.place, f"{key}: {slot.doc}", "missing-parameter")
        elif slot.many:
            if not isinstance(item.value, dict) or not item.value:
                kind = "an empty mapping" if isinstance(item.value, dict) else item.kind
                message = f"{where} must be a mapping of values to nodes, not {kind}"
                self._broken(draft, message, item.place, "left: {...}", "wrong-type")
                return
            found = {name: self.node(child, f"{name!r} of {where}") for name, child in item.value.items()}
            draft.branches[key] = {name: child for name, child in found.items() if child is not None}
            draft.sound = draft.sound and None not in found.values()
        else:
            branch = self._condition(item) if slot.condition else self.node(item, where)
            if branch is None:
                draft.sound = False
            else:
                draft.branches[key] = branch

    def _condition(self, item: Item) -> Draft | None:
        """Read a condition: an expression, or a node."""
        if isinstance(item.value, dict) or self._is_node(reference(item)):
            return self.node(item, "a condition")
        return self._typed("condition", item, item.place)

    def _broken(self, draft: Draft, message: str, place: Place, hint: str, code: str) -> None:
        draft.sound = False
        self._problem(message, place, hint, code)

    def _problem(self, message: str, place: Place, hint: str, code: str) -> None:
        self._problems.append(Problem(message, place, hint, code))
