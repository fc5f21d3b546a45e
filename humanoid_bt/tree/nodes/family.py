"""Children that a node made in Python is given: each mistake is one message, in the words of these nodes."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping

from py_trees.behaviour import Behaviour

from humanoid_bt.core.errors import UserError
from humanoid_bt.decision.overridden import not_made

_CODE = "invalid-node"


def children_of(parent: type, name: object, children: object) -> list[Behaviour]:
    """Return the children of a node that is being made.

    Raises:
        UserError: they are no list of nodes, or one of them stands somewhere already.
    """
    what = _called(parent, name)
    if not isinstance(children, Iterable) or isinstance(children, (str, bytes, Behaviour)):
        hint = f'{parent.__name__}("name", [...])'
        raise UserError(f"the children of {what} must be a list of nodes, not {_kind(children)}", None, hint, _CODE)
    found: list[Behaviour] = []
    for child in children:
        node = _node(child, f"a child of {what}")
        if node.parent is not None or any(node is other for other in found):
            message = f"the node {node.name!r} is given to {what}, and stands in a tree already"
            raise UserError(message, None, "make one for each place", _CODE)
        found.append(node)
    return found


def child_of(parent: type, name: object, child: object, what: str = "child") -> Behaviour:
    """Return the child of a decorator that is being made, or another node that it needs.

    Args:
        parent, name: the decorator's type and name.
        child: what it is given.
        what: what this is for it, for messages.

    Raises:
        UserError: it is no node.
    """
    return _node(child, f"the {what} of {_called(parent, name)}")


def cases_of(parent: type, name: object, cases: object) -> dict[str, Behaviour]:
    """Return the cases of a node that is being made, as a file would write their values: ``true``, ``2``.

    Raises:
        UserError: they are no mapping of values to nodes.
    """
    what = _called(parent, name)
    if not isinstance(cases, Mapping):
        hint = f'{parent.__name__}("name", {{value: node}}, value="...")'
        message = f"the cases of {what} must be a mapping of values to nodes, not {_kind(cases)}"
        raise UserError(message, None, hint, _CODE)
    found: dict[str, Behaviour] = {}
    for case, node in cases.items():
        if not isinstance(case, (str, bool, int, float)):
            hint = "a text, a boolean or a number"
            raise UserError(f"{_kind(case)} cannot be a case of {what}", None, hint, _CODE)
        written = case if isinstance(case, str) else json.dumps(case)
        if written in found:
            raise UserError(f"two cases of {what} are {written}", None, "one node for each value", _CODE)
        found[written] = node
    return found


def _called(parent: type, name: object) -> str:
    if not isinstance(name, str):
        message = f"{parent.__name__} needs a name, and {_kind(name)} stands where it is expected"
        raise UserError(message, None, f'{parent.__name__}("name", ...)', _CODE)
    return f"{parent.__name__} {name!r}"


def _node(child: object, what: str) -> Behaviour:
    if isinstance(child, Behaviour):
        if problem := not_made(child):
            raise UserError([problem])
        return child
    hint = f'an instance of it: {child.__name__}("name", ...)' if isinstance(child, type) else "a node that was made"
    raise UserError(f"{what} must be a node, not {_kind(child)}", None, hint, _CODE)


def _kind(value: object) -> str:
    if value is None:
        return "None"
    if isinstance(value, type):
        return f"the class {value.__name__}"
    if isinstance(value, Behaviour):
        return f"the node {value.name!r}"
    words: dict[type, str] = {list: "a list", tuple: "a tuple", str: "text"}
    return words.get(type(value), repr(value))
