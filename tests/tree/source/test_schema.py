"""The JSON Schema accepts every good tree, and refuses what an editor should mark."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml

from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.tree.nodes.examples import EXAMPLES
from humanoid_bt.tree.nodes.registry import Registry
from humanoid_bt.tree.source.load import subtree_types
from humanoid_bt.tree.source.schema import tree_schema
from tests.tree.helpers import make_workspace

BUILTIN = Workspace(builtin_root())
MANY = """\
from collections.abc import Sequence
import py_trees
class Many(py_trees.behaviours.Success):
    def __init__(self, name, numbers: Sequence[float] = (), how: py_trees.common.Access = py_trees.common.Access.READ):
        super().__init__(name)
"""


def schema_of(workspace: Workspace) -> dict[str, Any]:
    registry = Registry.of(workspace)
    return tree_schema(registry, subtree_types(workspace, registry))


@pytest.fixture(scope="module")
def schema() -> dict[str, Any]:
    return schema_of(BUILTIN)


def mistakes(schema: Mapping[str, Any], document: object) -> list[str]:
    return [error.message for error in jsonschema.Draft7Validator(schema).iter_errors(document)]


def test_it_is_a_schema(schema: dict[str, Any]) -> None:
    jsonschema.Draft7Validator.check_schema(schema)


def test_a_behaviour_of_py_trees_may_take_anything(tmp_path: Path) -> None:
    (tmp_path / "skills").mkdir()
    (tmp_path / "skills" / "many.py").write_text(MANY)
    schema = schema_of(Workspace(tmp_path))
    jsonschema.Draft7Validator.check_schema(json.loads(json.dumps(schema)))
    assert not mistakes(schema, {"format": 1, "root": {"many": {"numbers": [1, 2], "how": 3}}})


@pytest.mark.parametrize("name", BUILTIN.trees())
def test_built_in_trees_are_valid(schema: dict[str, Any], name: str) -> None:
    assert not mistakes(schema, yaml.safe_load(BUILTIN.trees()[name].read_text(encoding="utf-8")))


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_example_of_every_node_type_is_valid(schema: dict[str, Any], name: str) -> None:
    document = yaml.safe_load(EXAMPLES[name])
    if "root" not in document:
        document = {"format": 1, "root": document}
    assert not mistakes(schema, document)


@pytest.mark.parametrize(
    "text",
    [
        "{root: idle}",
        "{format: 2, root: idle}",
        "{format: 1, root: idel}",
        "{format: 1, rot: idle, root: idle}",
        "{format: 1, parameters: {x: {unit: parsec}}, root: idle}",
        "{format: 1, outputs: {x: 1}, root: {set_blackboard: {key: x, value: 1}}}",
        "{format: 1, outputs: {x: {default: 1}}, root: {set_blackboard: {key: x, value: 1}}}",
        "{format: 1, root: {sequence: []}}",
        "{format: 1, root: {sequence: [idel]}}",
        "{format: 1, root: {sequence: [idle], selector: [idle]}}",
        "{format: 1, root: {timeout: {idle: }}}",
        "{format: 1, root: {inverter: {child: idel}}}",
        "{format: 1, root: {timeout: {duration: 3 s}}}",
        "{format: 1, root: {timeout: {duration: 3 m, idle: }}}",
        "{format: 1, root: {retry: {attempts: -2, idle: }}}",
        "{format: 1, root: {wait: soon}}",
        "{format: 1, root: {reach: {target: x, hand: up}}}",
        "{format: 1, root: {reach: {target: x, hnd: left}}}",
        "{format: 1, root: {if: {condition: state.standing}}}",
        "{format: 1, root: {set_blackboard: {key: a b, value: 1}}}",
    ],
)
def test_what_is_wrong_is_marked(schema: dict[str, Any], text: str) -> None:
    assert mistakes(schema, yaml.safe_load(text))


@pytest.mark.parametrize(
    "text",
    [
        "{format: 1, root: {wait: 500 ms}}",
        "{format: 1, root: {wait: 1e-3}}",
        "{format: 1, root: {wait: $time}}",
        "{format: 1, outputs: {x: {type: number, unit: m}, y: }, root: {set_blackboard: {key: x, value: 1}}}",
        "{format: 1, root: {set_blackboard: {key: $k, value: 1}}}",
        "{format: 1, root: $action}",
        "{format: 1, root: {retry: {attempts: $n, $action: }}}",
        "{format: 1, root: {emergency_stop: idle}}",
        "{format: 1, root: {inverter: {name: x, child: {delay: {duration: 0, child: {wait: 1}}}}}}",
        "{format: 1, root: {fallback: [idle, {if: {condition: x < 1 m, then: idle, else: {wait: 1}}}]}}",
        "{format: 1, parameters: {x: 3 s, y: {type: node}, z: }, root: {subtree: ./other.yaml}}",
    ],
)
def test_what_is_right_is_not_marked(schema: dict[str, Any], text: str) -> None:
    assert not mistakes(schema, yaml.safe_load(text))


def test_the_workspaces_own_skills_and_sub_trees_are_in_it(tmp_path: Path) -> None:
    workspace = make_workspace(tmp_path / "project")
    (workspace.root / "trees" / "tried.yaml").write_text(
        "format: 1\nsubtree: true\nparameters: {attempts: {default: 2, doc: How often.}, action: {type: node}}\n"
        "root: {retry: {attempts: $attempts, $action: }}"
    )
    (workspace.root / "trees" / "broken.yaml").write_text("format: 1\nparameters: [")
    schema = schema_of(workspace)
    assert not mistakes(schema, {"format": 1, "root": {"act": {"script": "s"}}})
    assert mistakes(schema, {"format": 1, "root": {"act": {"scrip": "s"}}})
    assert not mistakes(schema, {"format": 1, "root": {"subtree": {"tree": "tried", "attempts": 3, "action": "act"}}})
    assert mistakes(schema, {"format": 1, "root": {"subtree": {"tree": "tried", "attempts": "often", "action": "act"}}})
    assert mistakes(schema, {"format": 1, "root": {"subtree": {"tree": "tried", "attempts": 3}}})


def test_every_type_and_parameter_is_explained(schema: dict[str, Any]) -> None:
    for name, node_type in Registry.of(BUILTIN).items():
        body = schema["definitions"][f"type_{name}"]
        assert node_type.doc.replace("`", "") in body["description"]
        whole = body["anyOf"][0] if "anyOf" in body else body
        for parameter, spec in node_type.params.items():
            assert spec.doc in whole["properties"][parameter]["description"]
