"""What a run leaves when its files are taken away, or it is killed."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from humanoid_bt.cli import main

SKILLS = """
import os
import shutil

from humanoid_bt import Skill, Status, param


class Remove(Skill):
    \"\"\"Remove a folder.\"\"\"

    folder: str = param(doc="Which.")
    fails: bool = param(False, doc="Whether it fails then.")

    def update(self) -> Status:
        shutil.rmtree(self.folder)
        return self.fail("gone") if self.fails else self.succeed("gone")


class Die(Skill):
    \"\"\"Kill the program.\"\"\"

    def update(self) -> Status:
        os.kill(os.getpid(), 9)
        return self.running("dying")
"""


@pytest.fixture(autouse=True)
def workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A workspace of skills that do harm, and the working directory."""
    (tmp_path / "skills").mkdir()
    (tmp_path / "skills" / "harm.py").write_text(SKILLS, encoding="utf-8")
    (tmp_path / "trees").mkdir()
    parameters = "parameters: {folder: {type: text, default: runs}, fails: false}\n"
    for name, text in (
        ("wait", "root: {emergency_stop: {wait: 40 ms}}"),
        ("die", "root: {emergency_stop: die}"),
        ("lose", parameters + "root: {emergency_stop: {remove: {folder: $folder, fails: $fails}}}"),
    ):
        (tmp_path / "trees" / f"{name}.yaml").write_text(f"format: 1\n{text}\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_an_older_report_is_gone_while_there_is_no_new_one(tmp_path: Path) -> None:
    report = tmp_path / "report.json"
    report.write_text('{"outcome": "success"}', encoding="utf-8")
    assert main(["run", "none", "--report", str(report)]) == 2
    assert not report.exists()


def test_what_is_no_report_is_not_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tree = tmp_path / "tree.yaml"
    tree.write_text("format: 1\n", encoding="utf-8")
    assert main(["run", "wait", "--no-record", "--report", str(tree)]) == 2
    assert "which is no report" in capsys.readouterr().err
    assert tree.read_text(encoding="utf-8") == "format: 1\n"


@pytest.mark.parametrize(("fails", "code"), [("true", 1), ("false", 4)])
def test_a_report_that_cannot_be_written_masks_no_failure(
    fails: str, code: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "reports").mkdir()
    given = ["--set", "folder=reports", "--set", f"fails={fails}"]
    assert main(["run", "lose", "--no-record", *given, "--report", "reports/report.json"]) == code
    told = capsys.readouterr()
    assert "error: the report cannot be written to 'reports/report.json': No such file or directory" in told.err
    assert "gone" in told.out


def test_without_its_recording_a_run_has_its_report(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "lose", "--no-view", "--report", "report.json"]) == 0
    report = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    assert report["outcome"] == "success"
    lost, missing = [event["text"] for event in report["events"] if event["level"] == "error"]
    printed = " ".join(capsys.readouterr().out.split())
    assert lost.startswith("the recording") and lost in printed
    assert missing.endswith("are missing in the recording") and report["recording_missing"] > 0
    assert "open it" not in printed


def test_without_its_working_directory_a_run_has_its_report(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    gone, recording, report = (tmp_path / name for name in ("gone", "run.rrd", "report.json"))
    gone.mkdir()
    monkeypatch.chdir(gone)
    monkeypatch.setenv("PATH", "")  # on which no viewer is
    given = ["--workspace", str(tmp_path), "--set", f"folder={gone}", "--no-view", "--camera", "off"]
    assert main(["run", "lose", *given, "--record", str(recording), "--report", str(report)]) == 0
    assert json.loads(report.read_text(encoding="utf-8"))["outcome"] == "success"
    assert f"rerun {recording}" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(
    "command",
    [["check"], ["show", "wait"], ["run", "TREE", "--no-view"], ["coverage", "data"]],
    ids=lambda command: command[0],
)
def test_where_the_working_directory_is_gone_that_is_told(
    command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    assert main([str(tmp_path / "trees" / "wait.yaml") if word == "TREE" else word for word in command]) == 2
    assert "error: the working directory is gone" in capsys.readouterr().err


@pytest.mark.trials
def test_a_run_that_is_killed_leaves_no_report(tmp_path: Path) -> None:
    report = tmp_path / "report.json"
    report.write_text('{"outcome": "success"}', encoding="utf-8")
    command = [sys.executable, "-m", "humanoid_bt", "run", "die", "--no-record", "--report", str(report)]
    assert subprocess.run(command, check=False, capture_output=True).returncode == -signal.SIGKILL
    assert not [path for path in tmp_path.iterdir() if "report" in path.name]
