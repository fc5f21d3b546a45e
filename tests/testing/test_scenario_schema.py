"""The schema of scenario files: it takes what is right, and refuses what is wrong."""

from __future__ import annotations

import re
from pathlib import Path

import jsonschema
import pytest
import yaml

from humanoid_bt.core.params import params_of
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.testing.events import FAULTS
from humanoid_bt.testing.scenario import Scenario
from humanoid_bt.testing.scenario_schema import scenario_schema
from tests.testing.test_scenario import MISTAKES, WHOLE

_DOCS = Path(__file__).resolve().parents[2] / "docs" / "scenarios.md"
_SEEN = (
    "a condition",
    "a fault",
    "a kind",
    "a duration in kg",
    "no tree",
    "nothing expected",
    "a stand-in",
    "seeds of another kind",
)
"""Of the mistakes those that a schema can know."""


@pytest.fixture(scope="module")
def schema() -> jsonschema.Draft7Validator:
    made = scenario_schema(Workspace(builtin_root()))
    jsonschema.Draft7Validator.check_schema(made)
    return jsonschema.Draft7Validator(made)


def test_right_files_are_right(schema: jsonschema.Draft7Validator) -> None:
    blocks = re.findall(
        r"^<!-- file: scenarios/\w+.yaml -->\n```yaml\n(.*?)^```", _DOCS.read_text(), re.DOTALL | re.MULTILINE
    )
    files = [path.read_text() for path in builtin_root().glob("scenarios/*.yaml")]
    assert len(blocks) == 2 and len(files) >= 5
    for text in (WHOLE, *blocks, *files):
        schema.validate(yaml.safe_load(text))


@pytest.mark.parametrize("event", ["lose: target", "estop: ", "silence: 0.5 s", "set: {a: 1}", "raise: {node: reach}"])
def test_faults_have_their_short_forms(schema: jsonschema.Draft7Validator, event: str) -> None:
    text = f"{{format: 1, tree: fetch, expect: fell, script: [{{when: reach runs, {event}}}]}}"
    schema.validate(yaml.safe_load(text))


@pytest.mark.parametrize("name", _SEEN)
def test_what_it_can_know_is_refused(schema: jsonschema.Draft7Validator, name: str) -> None:
    old, new, _, _ = MISTAKES[name]
    with pytest.raises(jsonschema.ValidationError):
        schema.validate(yaml.safe_load(WHOLE.replace(old, new)))


def test_every_key_and_every_fault_is_explained(schema: jsonschema.Draft7Validator) -> None:
    properties = schema.schema["properties"]
    assert properties.keys() == params_of(Scenario).keys()
    assert all(part["description"] for part in properties.values())
    assert {"at", "when", "optional", *FAULTS} == properties["script"]["items"]["properties"].keys()
