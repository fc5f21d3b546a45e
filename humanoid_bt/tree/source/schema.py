"""A JSON Schema of tree files, made from the registry: editors complete, explain and check with it.

It is a little more generous than ``check``, which knows what a schema cannot: names, units of parameters, safety.
"""

from __future__ import annotations

import dataclasses
import inspect
import re
import types
import typing
from collections.abc import Mapping
from typing import Any

from humanoid_bt.core.params import Param, params_of
from humanoid_bt.core.plain import plain
from humanoid_bt.core.sources import Sources
from humanoid_bt.core.units import UNITS, factors
from humanoid_bt.decision.blackboard import KEY_NAME, Key
from humanoid_bt.tree.expressions.fields import Fields
from humanoid_bt.tree.expressions.holding import holds_expressions
from humanoid_bt.tree.node_type import CHILD, NodeType
from humanoid_bt.tree.nodes.registry import ALIASES, Registry
from humanoid_bt.tree.nodes.subtree import SubTree
from humanoid_bt.tree.slots import Slot
from humanoid_bt.tree.source.file import PARTS, Header
from humanoid_bt.tree.source.parameters import LongForm

Schema = dict[str, Any]

DIALECT = "http://json-schema.org/draft-07/schema#"
"""The newest dialect that yaml-language-server knows well."""

_NUMBER = r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?"
_REFERENCE: Schema = {"type": "string", "pattern": r"^\$[A-Za-z_]\w*$"}
_NODE: Schema = {"$ref": "#/definitions/node"}


def tree_schema(registry: Registry, trees: Mapping[str, NodeType]) -> Schema:
    """Return the schema of a workspace's tree files.

    Args:
        registry: the node types, the workspace's skills among them.
        trees: name of a tree -> the type of a sub-tree node that uses it, for those that can be used.
    """
    header = {name: value_schema(spec) for name, spec in params_of(Header).items()}
    parts = {name: {"description": doc, **_part(name)} for name, doc in PARTS.items()}
    names = {**registry, **{alias: registry[alias] for alias in ALIASES}}
    return {
        "$schema": DIALECT,
        "title": "A behavior tree of humanoid-bt",
        "type": "object",
        "properties": {**header, **parts},
        "required": ["format", "root"],
        "additionalProperties": False,
        "definitions": {
            "node": _node(names),
            "child": {"anyOf": [{"required": [name]} for name in (*names, CHILD)] + [_pattern_key()]},
            "condition": {"anyOf": [{"type": ["string", "boolean", "number"]}, _NODE]},
            "declaration": _declaration(),
            "output": _declaration(default=False),
            **{f"type_{name}": _body(node_type, names, trees) for name, node_type in names.items()},
        },
    }


def _node(names: Mapping[str, NodeType]) -> Schema:
    """Return the schema of a node: a bare type, a node parameter, or a mapping of one type to its body."""
    bare = [name for name, node_type in names.items() if _can_be_bare(node_type)]
    return {
        "anyOf": [
            {
                "type": "object",
                "properties": _bodies(names),
                "patternProperties": {_REFERENCE["pattern"]: {"type": "null"}},
                "additionalProperties": False,
                "minProperties": 1,
                "maxProperties": 1,
            },
            {"type": "string", "enum": bare},
            _REFERENCE,
        ]
    }


def _bodies(names: Mapping[str, NodeType]) -> Schema:
    return {name: {"$ref": f"#/definitions/type_{name}", **_described(kind)} for name, kind in names.items()}


def _can_be_bare(node_type: NodeType) -> bool:
    needs_parameter = any(spec.required for spec in node_type.params.values())
    needs_branch = any(slot.required for slot in node_type.branches.values())
    return node_type.takes == "none" and not needs_parameter and not needs_branch


def _body(node_type: NodeType, names: Mapping[str, NodeType], trees: Mapping[str, NodeType]) -> Schema:
    """Return the schema of what stands behind a type's name."""
    properties: Schema = {"name": {"type": "string", "description": "What the node is called."}}
    properties |= {name: value_schema(spec) for name, spec in node_type.params.items()}
    properties |= {name: _branch(slot) for name, slot in node_type.branches.items()}
    required = [name for name, spec in node_type.params.items() if spec.required]
    required += [name for name, slot in node_type.branches.items() if slot.required]
    whole: Schema = {"type": "object", "properties": properties, "required": required, "additionalProperties": False}
    forms: list[Schema] = [whole]
    if node_type.takes == "many":
        children = {"type": "array", "items": _NODE, "minItems": 1, "description": "The nodes below it."}
        properties["children"] = children
        required.append("children")
        forms.append(children)
    elif node_type.takes == "one":
        child = {"description": "The node below it, where a parameter is called as its type.", **_NODE}
        whole["properties"] = _bodies(names) | properties | {CHILD: child}
        whole["patternProperties"] = {_REFERENCE["pattern"]: {"type": "null"}}
        whole["allOf"] = [{"$ref": "#/definitions/child"}]
        if not required:
            forms.append({"type": "string"})
    elif not required:
        forms.append({"type": "null"})
    if node_type.cls is SubTree:
        _with_arguments(whole, trees)
    if node_type.main:
        forms.append(value_schema(node_type.params[node_type.main]))
    return {**_described(node_type), "anyOf": forms} if len(forms) > 1 else {**_described(node_type), **whole}


def _with_arguments(whole: Schema, trees: Mapping[str, NodeType]) -> None:
    """Let a sub-tree node take the parameters of the tree that it names; of a file that is not known, anything."""
    whole["properties"]["tree"] = {**whole["properties"]["tree"], "examples": sorted(trees)}
    whole["additionalProperties"] = True
    whole["allOf"] = [
        {
            "if": {"properties": {"tree": {"const": name}}},
            "then": {
                "properties": {
                    **{key: value_schema(spec) for key, spec in used.params.items() if key != "tree"},
                    **{key: _branch(slot) for key, slot in used.branches.items()},
                },
                "required": [key for key, spec in used.params.items() if spec.required]
                + [key for key, slot in used.branches.items() if slot.required],
            },
        }
        for name, used in sorted(trees.items())
    ]


def _branch(slot: Slot) -> Schema:
    description = {"description": slot.doc}
    if slot.many:
        return {**description, "type": "object", "additionalProperties": _NODE, "minProperties": 1}
    return {**description, **({"$ref": "#/definitions/condition"} if slot.condition else _NODE)}


def _described(node_type: NodeType) -> Schema:
    doc = inspect.cleandoc(vars(node_type.cls).get("__doc__") or "")
    commands = f"\n\nCommands: {', '.join(node_type.resources)}." if node_type.resources else ""
    return {"description": re.sub(r"`+", "", doc) + commands, "markdownDescription": re.sub(r"``", "`", doc) + commands}


def _pattern_key() -> Schema:
    """Return the schema of a mapping with a key that stands for a node (``$action``)."""
    return {"not": {"propertyNames": {"not": {"pattern": _REFERENCE["pattern"]}}}}


def _part(name: str) -> Schema:
    """Return the schema of a part of a tree file: the root node, or what declares names."""
    if name == "root":
        return _NODE
    declared = "output" if name == "outputs" else "declaration"
    return {"type": "object", "additionalProperties": {"$ref": f"#/definitions/{declared}"}}


def _declaration(default: bool = True) -> Schema:
    """Return the schema of a parameter or a key: its default, or its declaration in full; of an output, without one."""
    properties = {name: value_schema(spec, literal=True) for name, spec in params_of(LongForm).items()}
    properties["unit"] = {**properties["unit"], "enum": ["", *UNITS]}
    if not default:
        del properties["default"]
    full = {"type": "object", "properties": properties, "additionalProperties": False}
    return {"anyOf": [{"type": ["string", "number", "boolean", "array", "null"] if default else "null"}, full]}


def value_schema(spec: Param, literal: bool = False) -> Schema:
    """Return the schema of a parameter's value; unless ``literal`` it may also be a reference."""
    schema = _type(spec.type, spec)
    if not literal and schema and "string" not in _types(schema):
        schema = {"anyOf": [schema, _REFERENCE]}
    unit = f" [{spec.unit}]" if spec.unit else ""
    schema = {**schema, "description": f"{spec.doc}{unit}"}
    if not spec.required and spec.default is not None and not dataclasses.is_dataclass(spec.default):
        schema["default"] = plain(spec.default)
    return schema


def _types(schema: Schema) -> list[Any]:
    """Return the types of all that a schema accepts without a pattern or an enum."""
    forms = (schema, *schema.get("anyOf", ()))
    return [form.get("type") for form in forms if not {"pattern", "enum"} & form.keys()]


def _type(kind: Any, spec: Param) -> Schema:  # noqa: PLR0911 (a table of cases)
    origin, args = typing.get_origin(kind), typing.get_args(kind)
    if origin in (typing.Union, types.UnionType):
        forms = [{"type": "null"} if arg is type(None) else _type(arg, spec) for arg in args]
        return {"anyOf": forms}
    if origin is typing.Literal:
        return {"enum": list(args)}
    if origin in (list, tuple):
        inner = _type(args[0], spec) if args else {}
        return {"type": "array", "items": {"anyOf": [inner, _REFERENCE]} if inner else {}}
    if origin is dict or kind is Fields:
        return {"type": "object"}
    if kind is Key:
        return {"type": "string", "pattern": KEY_NAME.pattern}
    if kind is Sources:
        return dict(Sources.schema)
    if holds_expressions(kind):
        return {"type": ["string", "number", "boolean"]}
    if kind in (float, int):
        return _number(kind, spec)
    return {bool: {"type": "boolean"}, str: {"type": "string"}}.get(getattr(kind, "__supertype__", kind), {})


def _number(kind: Any, spec: Param) -> Schema:
    bounds = {"minimum": spec.minimum, "exclusiveMinimum": spec.above, "maximum": spec.maximum}
    number = {"type": "integer" if kind is int else "number", **{k: v for k, v in bounds.items() if v is not None}}
    units = "|".join(map(re.escape, factors(spec.unit)))
    unit = rf"\s*({units})" if units else ""
    behind = f"({unit})?" if unit else ""
    written = {"type": "string", "pattern": rf"^\s*{_NUMBER}{behind}\s*$"}
    valid = f"A number; units: {', '.join(factors(spec.unit))}." if units else "A number without a unit."
    return {"anyOf": [{**written, "patternErrorMessage": valid}, number]}
