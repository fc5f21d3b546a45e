"""How findings look on a terminal and elsewhere."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import pytest

from humanoid_bt.cli.excerpts import excerpt
from humanoid_bt.cli.findings import counted, print_findings
from humanoid_bt.core.errors import Place, Problem


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name in ("FORCE_COLOR", "NO_COLOR", "TTY_COMPATIBLE"):
        monkeypatch.delenv(name, raising=False)
    path = Path("a.yaml")
    path.write_text("format: 1\nroot: {reech: {target: target}}\n", encoding="utf-8")
    return path


def test_one_line_then_what_would_be_valid(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    problem = Problem("unknown node 'reech'", Place("a.yaml", 2, 8), "did you mean 'reach'?", "unknown-node")
    print_findings([problem, Problem("no\nplace", severity="warning")])
    assert capsys.readouterr().out.splitlines() == [
        "a.yaml:2:8: error: unknown node 'reech' [unknown-node]",
        "    did you mean 'reach'?",
        "warning: no",
        "    place",
    ]


def test_a_terminal_shows_the_line_and_breaks_between_words(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stdout", terminal)
    monkeypatch.setenv("COLUMNS", "50")
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.setenv("TERM", "dumb")
    hint = "did you mean 'reach'? valid: approach, confident, reach, watchdog"
    print_findings([Problem("unknown node 'reech'", Place("a.yaml", 2, 8), hint, "unknown-node")])
    assert terminal.getvalue().splitlines() == [
        "a.yaml:2:8: error: unknown node 'reech'",
        "    [unknown-node]",
        "    2 | root: {reech: {target: target}}",
        "      |        ^",
        "    did you mean 'reach'? valid: approach,",
        "    confident, reach, watchdog",
    ]


@pytest.mark.parametrize("columns", [40, 50, 80])
@pytest.mark.parametrize("column", [1, 20, 60, 100, 199, 200])
def test_the_mark_stands_below_its_letter_at_any_width(columns: int, column: int, file: Path) -> None:
    letters = [chr(ord("a") + number % 26) for number in range(199)]
    letters[column - 1 : column] = "X"
    file.write_text("".join(letters), encoding="utf-8")
    line, mark = excerpt(Place("a.yaml", 1, column), columns) or ("", "")
    assert len(line) <= columns
    assert line[mark.index("^")] == "X"


def test_wide_letters_take_two_columns(file: Path) -> None:
    file.write_text("名前: x\n", encoding="utf-8")
    assert excerpt(Place("a.yaml", 1, 5), 80) == ("    1 | 名前: x", "      |       ^")


@pytest.mark.parametrize(
    "place",
    [Place("gone.yaml", 1, 1), Place("a.yaml"), Place("a.yaml", 9, 1), Place("a.yaml", 1, 99), Place("x=1")],
)
def test_what_is_not_there_is_not_shown(place: Place, file: Path) -> None:
    assert excerpt(place, 80) is None


def test_findings_are_counted_by_severity() -> None:
    error, warning = Problem("a"), Problem("b", severity="warning")
    assert counted([error]) == "1 error"
    assert counted([warning, error, warning]) == "1 error, 2 warnings"


def test_what_a_file_holds_commands_no_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    print_findings([Problem("unknown '\x1b[2J'", hint="valid: \x1b[31m")])
    assert capsys.readouterr().out == "error: unknown '\\x1b[2J'\n    valid: \\x1b[31m\n"
