"""Text from elsewhere on a terminal and in a pipe: it gives no commands, and does not flood."""

from __future__ import annotations

import json
import os
import pty
import re
import subprocess
import sys
from pathlib import Path

import pytest

from humanoid_bt.cli import main

TITLE = "\x1b]0;mine\x07"
NASTY = f"{TITLE}\x9b31m\u202e\r\b"
SHOWN = r"\x1b]0;mine\x07"
OURS = re.compile(r"\x1b\[[0-9;]*[mAKHJ]|\x1b\[\?25[lh]")
"""Colours, and how the progress line is drawn anew."""

SKILLS = f"""
from humanoid_bt import Skill, Status


class Nasty(Skill):
    \"\"\"Says {ascii(NASTY)[1:-1]} in its docstring.\"\"\"

    def update(self) -> Status:
        self.robot.log("log " + {NASTY!a})
        print("printed " + {NASTY!a})
        if self.feedback_message:
            raise ValueError("raised " + {NASTY!a})
        return self.running("feedback " + {NASTY!a})


class Loud(Skill):
    \"\"\"Say ten megabytes.\"\"\"

    def update(self) -> Status:
        self.robot.log("l" * 10_000_000)
        if self.feedback_message:
            raise ValueError("r" * 10_000_000)
        self.running("f" * 10_000_000)
        self.feedback_message = "f" * 10_000_000
        return Status.RUNNING
"""


@pytest.fixture
def workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A workspace whose skills, trees and file names hold what terminals obey."""
    (tmp_path / "skills").mkdir()
    (tmp_path / "skills" / "mine.py").write_text(SKILLS, encoding="utf-8")
    trees = tmp_path / "trees"
    trees.mkdir()
    for name in ("nasty", "loud"):
        text = f"format: 1\ndescription: {json.dumps(NASTY)}\nroot:\n  emergency_stop: {name}\n"
        (trees / f"{name}.yaml").write_text(text, encoding="utf-8")
    (trees / f"{TITLE}.yaml").write_text(f"format: 1\nroot: {json.dumps(NASTY)}\n", encoding="utf-8")
    (trees / "\udcff\n.yaml").write_text("format: 1\nroot: wait\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


COMMANDS = [
    (["run", "nasty", "--no-record"], 4),
    (["show", "nasty"], 0),
    (["check"], 2),
    (["check", "--format", "sarif"], 2),
    (["check", "--format", "json"], 2),
    (["skills", "nasty"], 0),
    (["trees", "nasty"], 0),
    (["run", NASTY], 2),
    (["run", "nasty", f"--{NASTY}"], 2),
]


@pytest.mark.parametrize(("arguments", "code"), COMMANDS)
def test_nothing_that_is_not_ours_is_obeyed(
    arguments: list[str], code: int, workspace: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        assert main(arguments) == code
    except SystemExit as ended:
        assert ended.code == code
    said = "".join(capsys.readouterr())
    assert not re.search("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202e]", said)
    assert SHOWN in said or r"\u001b]0;mine\u0007" in said or "%1B%5D0" in said


@pytest.mark.parametrize(
    ("arguments", "code"),
    [COMMANDS[0], *(pytest.param(*COMMANDS[number], marks=pytest.mark.trials) for number in (2, 5))],
)
def test_nor_on_a_terminal(arguments: list[str], code: int, workspace: Path) -> None:
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "humanoid_bt", *arguments]
    process = subprocess.Popen(command, cwd=workspace, stdin=theirs, stdout=theirs, stderr=theirs)
    os.close(theirs)
    said = b""
    with os.fdopen(ours, "rb", buffering=0) as terminal:
        try:
            while part := terminal.read(65536):
                said += part
        except OSError:  # the other end is closed
            pass
    assert process.wait() == code
    text = OURS.sub("", said.decode()).replace("\r\n", "\n").replace("\r", "\n")
    assert not re.search("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202e]", text)
    assert SHOWN in text.replace("\n", "")


def test_ten_megabytes_are_cut(workspace: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "loud", "--no-record", "--report", "loud.json"]) == 4
    told = capsys.readouterr()
    assert len(told.out) + len(told.err) < 40_000
    assert "f… (10,000,000 characters)" in told.out
    assert Path("loud.json").stat().st_size < 100_000
    report = json.loads(Path("loud.json").read_text(encoding="utf-8"))
    assert any(change["feedback"].endswith("f… (10,000,000 characters)") for change in report["timeline"])
    assert any(event["text"].endswith(" characters)") for event in report["events"])
    assert " characters)" in report["reason"] and " characters)" in report["traceback"]
