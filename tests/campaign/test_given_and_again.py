"""Campaigns from the command line: where results go, what is run again, and what is refused before a trial runs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from humanoid_bt.cli import main

SAY = """
from humanoid_bt import Skill, Status, param


class Say(Skill):
    \"\"\"Say something and fail.\"\"\"

    times: int = param(1, doc="How often.")

    def update(self) -> Status:
        \"\"\"Fail.\"\"\"
        return self.fail(f"{self.times} times")
"""
MINE = """
format: 1
parameters: {times: 3, long: 0.1, label: ""}
root: {sequence: [{wait: $long}, {log: {text: $label}}, {say: {times: $times}}]}
"""


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A workspace with a tree that fails at once."""
    for place, text in {"trees/mine.yaml": MINE, "skills/say.py": SAY}.items():
        (tmp_path / "project" / place).parent.mkdir(parents=True)
        (tmp_path / "project" / place).write_text(text)
    monkeypatch.chdir(tmp_path / "project")
    return tmp_path / "project"


def campaign(*arguments: str) -> int:
    return main(["campaign", "mine", "--dry", "--seeds", "0", "--quiet", "--recordings", "0", *arguments])


def test_a_trial_is_run_again_from_another_folder(
    project: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert campaign("--out", "runs/a") == 0
    monkeypatch.chdir(project.parent)
    capsys.readouterr()
    main(["campaign", "rerun", "project/runs/a", "0"])
    told = capsys.readouterr()
    assert "as it was, bit for bit" in told.out, told.err


def test_what_is_drawn_is_tried_before_a_trial_runs(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert campaign("--set", "times=1 .. 3", "--out", "runs/a") == 2
    assert "'times' must be a whole number" in capsys.readouterr().err
    assert not (project / "runs").exists()


def test_units_are_taken_as_run_takes_them(project: Path) -> None:
    assert campaign("--set", "long=200ms", "--out", "runs/a") == 0
    (factor,) = json.loads((project / "runs/a/campaign.json").read_text())["factors"]
    assert (factor["unit"], factor["values"]) == ("s", [0.2])


def test_text_is_taken_as_run_takes_it(project: Path) -> None:
    texts = ["12", "yes", "a: b", "[a, b]", "../a", ""]
    assert campaign(*(f"--set=label={text}" for text in texts), "--out", "runs/a") == 0
    assert campaign("--set", "label=../a", "--out", "runs/b") == 0
    for folder, tried in {"a": texts, "b": ["../a"]}.items():
        (factor,) = json.loads((project / f"runs/{folder}/campaign.json").read_text())["factors"]
        assert factor["values"] == tried


def test_results_stay_where_they_were_asked_for(project: Path, tmp_path: Path, monkeypatch: Any) -> None:
    (project / "skills/goes.py").write_text(f"import os\n\nos.chdir({str(tmp_path)!r})\n")
    assert campaign("--out", "runs/a") == 0
    assert (project / "runs/a/report.html").exists()
