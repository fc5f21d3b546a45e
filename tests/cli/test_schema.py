from __future__ import annotations

import json
from pathlib import Path

import pytest

from humanoid_bt.cli import main


@pytest.fixture(autouse=True)
def in_project(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(project)


def test_it_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema"]) == 0
    schema = json.loads(capsys.readouterr().out)
    assert {"type_reach", "type_pause", "type_sequence"} <= schema["definitions"].keys()


def test_there_is_one_of_scenarios(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema", "scenarios", "-o", "new/scenario.schema.json"]) == 0
    assert capsys.readouterr().out == "new/scenario.schema.json: scenarios\n"
    schema = json.loads(Path("new/scenario.schema.json").read_text(encoding="utf-8"))
    assert schema["required"] == ["format", "tree", "expect"]
    assert {"fetch", "give_up"} <= set(schema["properties"]["tree"]["examples"])


def test_it_is_written_to_a_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema", "-o", "new/tree.schema.json"]) == 0
    assert capsys.readouterr().out.startswith("new/tree.schema.json: ")
    assert json.loads(Path("new/tree.schema.json").read_text(encoding="utf-8"))["required"] == ["format", "root"]


def test_a_file_that_cannot_be_written_is_a_mistake(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema", "-o", "trees"]) == 2
    assert "cannot be written to 'trees'" in capsys.readouterr().err
