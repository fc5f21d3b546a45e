"""Every finding has a code of the catalogue, and the catalogue's examples show what they say."""

from __future__ import annotations

import ast
import re
import textwrap
from collections.abc import Iterator
from pathlib import Path

import pytest

import humanoid_bt
from humanoid_bt.checking.check import checked
from humanoid_bt.checking.codes import ALLOWABLE, CODES, Code, find
from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace

PACKAGE = Path(humanoid_bt.__path__[0])
WHERE = (
    "core/*.py",
    "files/*.py",
    "checking/allow.py",
    "checking/robot*.py",
    "robot/**/*.py",
    "plant/*.py",
    "decision/*.py",
    "tree/**/*.py",
)
FILES = [file for pattern in WHERE for file in sorted(PACKAGE.glob(pattern))]
AROUND = """\
format: 1
root:
  emergency_stop:
    watchdog:
      percept: target
      max_age: 0.5 s
"""
EXAMPLES = [code for code in CODES.values() if code.wrong]


def findings_made(file: Path) -> Iterator[tuple[str, str | None, str]]:
    """Yield where a module makes findings with a message: place, code if it is a literal, severity."""
    for call in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if not isinstance(call, ast.Call) or not isinstance(call.func, ast.Name) or not call.args:
            continue
        if call.func.id not in ("Problem", "UserError") or (call.func.id == "UserError" and is_list(call.args[0])):
            continue
        given = dict(zip(("message", "place", "hint", "code", "severity"), call.args, strict=False))
        given |= {word.arg: word.value for word in call.keywords if word.arg}
        severity = given.get("severity")
        kind = str(severity.value) if isinstance(severity, ast.Constant) else "error"
        code = given.get("code")
        where = f"{file.relative_to(PACKAGE)}:{call.lineno}"
        yield where, ("" if code is None else code.value if isinstance(code, ast.Constant) else None), kind


def is_list(node: ast.expr) -> bool:
    """Return whether an argument is a list of problems, not a message."""
    return not isinstance(node, (ast.Constant, ast.JoinedStr)) and "message" not in ast.unparse(node)


@pytest.mark.parametrize("file", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_every_finding_has_a_code_and_its_severity(file: Path) -> None:
    for where, code, severity in findings_made(file):
        if code is None:
            continue  # it is computed
        assert code in CODES, where
        assert CODES[code].severity == severity, where


def test_findings_are_seen_by_the_test_above() -> None:
    assert len(list(findings_made(PACKAGE / "files" / "document.py"))) > 10


def test_computed_codes_are_in_the_catalogue() -> None:
    for noun in ("parameter", "key"):
        assert {f"unknown-{noun}", f"missing-{noun}"} <= set(CODES)
    assert {f"unknown-{what}" for what in ("tree", "scene", "robot")} <= set(CODES)


@pytest.mark.parametrize("code", CODES.values(), ids=lambda code: code.name)
def test_codes_are_readable(code: Code) -> None:
    assert re.fullmatch(r"[a-z]+(-[a-z]+)*", code.name)
    assert code.meaning.endswith(".") and len(code.meaning) <= 100
    assert bool(code.wrong) == bool(code.right)


def test_only_warnings_can_be_allowed_but_for_those_about_allowing() -> None:
    warnings = {code.name for code in CODES.values() if code.severity == "warning"}
    assert warnings - ALLOWABLE == {"unknown-code", "unused-allow"}


@pytest.fixture
def found(tmp_path: Path) -> Finder:
    return Finder(tmp_path)


class Finder:
    """Checks a part of a tree file, or a whole one."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def codes(self, text: str) -> set[str]:
        path = self.folder / "example.yaml"
        path.write_text(text if text.startswith("format:") else AROUND + textwrap.indent(text, "      "), "utf-8")
        return {problem.code for problem in checked(path, Workspace(self.folder))}


@pytest.mark.parametrize("code", EXAMPLES, ids=lambda code: code.name)
def test_a_wrong_example_has_its_finding(code: Code, found: Finder) -> None:
    assert code.name in found.codes(code.wrong)


@pytest.mark.parametrize("code", EXAMPLES, ids=lambda code: code.name)
def test_a_right_example_is_right(code: Code, found: Finder) -> None:
    codes = found.codes(code.right)
    assert code.name not in codes
    assert not [name for name in codes if name not in CODES or CODES[name].severity == "error"]


def test_an_unknown_code_gets_the_nearest() -> None:
    with pytest.raises(UserError, match="did you mean 'unreachable'"):
        find("unreacheable")
