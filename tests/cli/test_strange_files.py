"""Files that are none, that are endless, or whose names are no names: one clear message each, at once."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from humanoid_bt.cli import main
from humanoid_bt.files.reading import MAX_BYTES


def _pipe(path: Path) -> None:
    os.mkfifo(path)


def _endless(path: Path) -> None:
    path.symlink_to("/dev/zero")


def _loop(path: Path) -> None:
    path.symlink_to(path.name)


def _nowhere(path: Path) -> None:
    path.symlink_to("gone")


def _folder(path: Path) -> None:
    path.mkdir()


def _large(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(MAX_BYTES + 1)


STRANGE: dict[str, tuple[Callable[[Path], None], str]] = {
    "pipe": (_pipe, "cannot be read: it is a pipe, not a file"),
    "endless": (_endless, "cannot be read: it is a device, not a file"),
    "loop": (_loop, "cannot be read: Too many levels of symbolic links"),
    "nowhere": (_nowhere, "cannot be read: No such file or directory"),
    "folder": (_folder, "cannot be read: Is a directory"),
    "large": (_large, "the file is too large: 4.0 MB"),
    "n\udcffm": (lambda path: path.touch(), ""),
}
FILES = ["trees/{}.yaml", "sim/scenes/{}.yaml", "skills/{}.py", "sim/{}/robot.yaml"]


@pytest.mark.parametrize("pattern", FILES)
@pytest.mark.parametrize("kind", STRANGE)
def test_a_strange_file_of_a_workspace_is_told(
    pattern: str, kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / pattern.format(kind)
    file.parent.mkdir(parents=True)
    make, said = STRANGE[kind]
    make(file)
    monkeypatch.chdir(tmp_path)
    assert main(["check"]) == (2 if said or not pattern.startswith("skills") else 0)
    told = capsys.readouterr()
    assert said in told.out and told.err == ""
    assert main(["check", "--format", "sarif"]) in (0, 2)
    for result in json.loads(capsys.readouterr().out)["runs"][0]["results"]:
        uri = result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"]
        assert uri.endswith((pattern.format(kind if said else "n%FFm"), "/gone"))  # where a link leads
    assert main(["run", "stand", "--duration", "0.02", "--no-record"]) == (2 if said and "skills" in pattern else 5)


@pytest.mark.parametrize("kind", STRANGE)
def test_a_model_that_is_no_file_is_told(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    STRANGE[kind][0](tmp_path / "model.xml")
    robot = tmp_path / "robot.yaml"
    robot.write_text("format: 1\nname: odd\nmodel: model.xml\n", encoding="utf-8")
    if kind == "large":
        os.truncate(tmp_path / "model.xml", 20_000_001)
    assert main(["check", str(robot)]) == 2
    said = capsys.readouterr().out
    assert not STRANGE[kind][1] or "cannot be read: it is" in said or "too large" in said or "is missing" in said


@pytest.mark.parametrize("text", ["x" * 5000, "x" * 5000 + ".yaml", "a\0b", "a\0b.yaml", "\udcff"])
@pytest.mark.parametrize("command", ["check", "run", "show", "trees"])
def test_a_name_that_no_file_can_have_is_told(
    text: str, command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main([command, text]) == 2
    said = "".join(capsys.readouterr())
    assert said.startswith(("error: ", "x" * 1000, "a\\x00b", "\\udcff")) and "internal" not in said
