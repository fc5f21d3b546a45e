"""A JSON Schema of scenario files: editors complete, explain and check with it."""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Iterable
from typing import Any

from humanoid_bt.core.params import Param, params_of
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.perception.source_files import load_sources
from humanoid_bt.testing.expectations import Expectations
from humanoid_bt.testing.fault import Fault
from humanoid_bt.testing.scenario import Scenario, Values
from humanoid_bt.testing.seeds import Seeds
from humanoid_bt.testing.substitution import Answer, Answered, Replacement
from humanoid_bt.tree.expressions.expression import Expression
from humanoid_bt.tree.source.schema import DIALECT, Schema, value_schema

_CLAIM: Schema = {"type": ["string", "boolean"]}
_CLAIMS: Schema = {"anyOf": [_CLAIM, {"type": "array", "items": _CLAIM, "minItems": 1}]}
_STEPS: Schema = {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}, "minItems": 2}]}
_SEED: Schema = {"anyOf": [{"type": "integer", "minimum": 0}, {"type": "string", "pattern": r"^\s*\d+[\d\s,-]*$"}]}

_KINDS: Schema = {
    "type": "object",
    "properties": {
        "never": {**_CLAIMS, "description": "True at no time: fell, or P while Q."},
        "always": {**_CLAIMS, "description": "True all the time: P, or P while Q."},
        "order": {
            **_STEPS,
            "description": "What comes one after the other: nodes that begin, claims that become true.",
        },
        "within 20 s": {**_CLAIMS, "description": "True at some time within this time, from the beginning of the run."},
    },
    "patternProperties": {r"^within\s+\S": _CLAIMS},
    "additionalProperties": False,
    "minProperties": 1,
}

_OWN: dict[type, Schema] = {
    Seeds: {"anyOf": [*_SEED["anyOf"], {"type": "array", "items": _SEED, "minItems": 1}]},
    Values: {"type": "object"},
    Expectations: {
        "anyOf": [_KINDS, {"type": "array", "items": {"anyOf": [_KINDS, _CLAIM]}, "minItems": 1}, {"type": "string"}]
    },
}
"""Of types that read themselves."""


def scenario_schema(workspace: Workspace) -> Schema:
    """Return the schema of a workspace's scenario files."""
    return file_schema(Scenario, "A scenario of humanoid-bt", workspace)


def file_schema(cls: type, title: str, workspace: Workspace) -> Schema:
    """Return the schema of files that are read into a dataclass which names tree, robot, scene and percept sources."""
    schema = _object(cls)
    names: dict[str, Iterable[str]] = {
        "tree": workspace.trees(),
        "robot": workspace.robots(),
        "scene": workspace.scenes(),
        "perception": load_sources(workspace),
    }
    for key, known in names.items():
        schema["properties"][key]["examples"] = sorted(known)
    return {"$schema": DIALECT, "title": title, **schema}


def _object(cls: type) -> Schema:
    """Return the schema of a mapping that is read into a dataclass."""
    params = params_of(cls)
    return {
        "type": "object",
        "properties": {name: _value(spec) for name, spec in params.items()},
        "required": [name for name, spec in params.items() if spec.required],
        "additionalProperties": False,
    }


def _value(spec: Param) -> Schema:
    form = _form(spec.type, spec)
    if form is None:
        return value_schema(spec, literal=True)
    unit = f" [{spec.unit}]" if spec.unit else ""
    return {**form, "description": f"{spec.doc}{unit}"}


def _form(kind: Any, spec: Param) -> Schema | None:  # noqa: PLR0911 (a table of cases)
    """Return the schema of a type that trees do not have, None if they have it."""
    origin, args = typing.get_origin(kind), typing.get_args(kind)
    if origin in (typing.Union, types.UnionType):
        inner = [arg for arg in args if arg is not type(None)]
        return _form(inner[0], spec) if len(inner) == 1 else None
    if origin is list and (item := _form(args[0], spec)) is not None:
        return {"type": "array", "items": item}
    if origin is dict and (value := _form(args[1], spec)) is not None:
        return {"type": "object", "additionalProperties": value}
    if not isinstance(kind, type):
        return None
    if issubclass(kind, Fault):
        return _fault(kind)
    if kind is Replacement:
        return _replacement()
    if kind in _OWN:
        return _OWN[kind]
    if hasattr(kind, "schema"):  # a type that says itself how it is written
        return dict(kind.schema)
    return _object(kind) if dataclasses.is_dataclass(kind) and not issubclass(kind, Expression) else None


def _fault(kind: type[Fault]) -> Schema:
    params = params_of(kind)
    if set(params) == {"values"}:  # a mapping of any names
        return {"type": "object", "minProperties": 1}
    main = [value_schema(params[kind.main], literal=True)] if kind.main else []
    empty = [] if any(spec.required for spec in params.values()) else [{"type": "null"}]
    return {"anyOf": [_object(kind), *main, *empty]}


def _replacement() -> Schema:
    status: Schema = {"enum": list(typing.get_args(Answered))}
    answer = _object(Answer)
    recorded = {"recorded": {"type": "string", "description": "A recording in which the node ran."}}
    return {
        "anyOf": [
            status,
            answer,
            {"type": "array", "items": {"anyOf": [status, answer]}, "minItems": 1},
            {"type": "object", "properties": recorded, "required": [*recorded], "additionalProperties": False},
        ]
    }
