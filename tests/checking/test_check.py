from __future__ import annotations

from pathlib import Path

import pytest

from humanoid_bt.checking.check import checked, findings, settled
from humanoid_bt.cli import main
from humanoid_bt.core.errors import Place, Problem
from humanoid_bt.files.workspace import Workspace, builtin_root

SOUND = "format: 1\nroot: {emergency_stop: idle}"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name in ("trees", "skills", "sim/scenes", "sim/tin"):
        (tmp_path / name).mkdir(parents=True)
    return tmp_path


def write(name: str, text: str) -> Path:
    path = Path(name)
    path.write_text(text, encoding="utf-8")
    return path


def warning(file: str, line: int, code: str = "no-time-limit") -> Problem:
    return Problem("it may take for ever", Place(file, line, 1), code=code, severity="warning")


def told(problems: list[Problem]) -> list[str]:
    return [f"{problem.place}: {problem.code}" for problem in problems]


@pytest.mark.parametrize(
    ("name", "text", "code"),
    [
        ("trees/a.yaml", "format: 1\nroot: idle", "outside-emergency-stop"),
        ("sim/scenes/a.yaml", "format: 1\nname: a\nevents: [{at: 1}]", "exclusive-keys"),
        ("sim/tin/robot.yaml", "format: 1", "missing-key"),
        ("skills/a.py", "import nothing_of_this_name", "broken-skill"),
        ("trees/b.yaml", "format: [", "syntax"),
    ],
)
def test_every_kind_of_file_is_checked(folder: Path, name: str, text: str, code: str) -> None:
    problems = checked(write(name, text), Workspace(folder))
    assert code in {problem.code for problem in problems}
    assert {problem.place.file for problem in problems if problem.place} == {name}


def test_what_is_built_in_has_no_findings() -> None:
    workspace = Workspace(builtin_root())
    files = [
        *workspace.trees().values(),
        *workspace.scenes().values(),
        *workspace.robots().values(),
        *workspace.skill_files(),
    ]
    assert not [problem for path in files for problem in checked(path, workspace)]


def test_a_file_that_is_not_text_has_a_place(folder: Path) -> None:
    path = Path("trees/a.yaml")
    path.write_bytes(b"format: 1\n# \xc3\xa4 \xff\n")
    assert told(checked(path, Workspace(folder))) == ["trees/a.yaml:2:5: unreadable"]


def test_a_link_that_leads_nowhere_is_told_by_its_name(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    Path("trees/a.yaml").symlink_to(folder.parent / "gone")
    for command in (["check", "trees"], ["fmt", "--check", "trees"]):
        assert main(command) == 2
        told = capsys.readouterr()
        assert "trees/a.yaml: error: cannot be read: No such file or directory" in told.out + told.err


def test_comments_are_heard_in_every_file_of_a_load(folder: Path) -> None:
    main = write("trees/main.yaml", f"# allow no-time-limit: why\n{SOUND}\n")
    write("trees/part.yaml", "a: 1  # allow no-time-limit: why\nb: 2\n")
    found = [warning("trees/main.yaml", 2), warning("trees/part.yaml", 1), warning("trees/part.yaml", 2)]
    assert told(settled({main: found})) == ["trees/part.yaml:2:1: no-time-limit"]


def test_an_allowance_that_any_load_needs_is_used(folder: Path) -> None:
    main, part = write("trees/main.yaml", SOUND), write("trees/part.yaml", "a: 1  # allow no-time-limit: why\n")
    assert settled({main: [warning("trees/part.yaml", 1)], part: []}) == []
    assert told(settled({part: []})) == ["trees/part.yaml:1:7: unused-allow"]


def test_an_allowance_of_a_sub_tree_is_for_the_trees_that_use_it(folder: Path) -> None:
    part = write("trees/part.yaml", "format: 1\nsubtree: true\nroot: idle  # allow no-time-limit: why\n")
    assert checked(part, Workspace(folder)) == []


def test_an_allowance_is_not_called_unused_where_errors_hide_warnings(folder: Path) -> None:
    path = write("trees/a.yaml", "format: 1\nroot: idle  # allow no-time-limit: why\n")
    assert told(checked(path, Workspace(folder))) == ["trees/a.yaml:2:7: outside-emergency-stop"]


def test_findings_come_file_by_file_in_the_order_of_lines(folder: Path) -> None:
    one, two = write("trees/1.yaml", SOUND), write("trees/2.yaml", SOUND)
    found = {two: [warning("trees/2.yaml", 9), warning("trees/1.yaml", 4)], one: [warning("trees/1.yaml", 3)]}
    assert told(settled(found)) == [
        "trees/2.yaml:9:1: no-time-limit",
        "trees/1.yaml:3:1: no-time-limit",
        "trees/1.yaml:4:1: no-time-limit",
    ]


def test_a_finding_without_a_place_is_one_of_the_file(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write("trees/a.yaml", SOUND)
    monkeypatch.setattr("humanoid_bt.checking.check._load", lambda path, workspace, kinds: [Problem("odd")])
    assert [str(problem.place) for problem in findings(path, Workspace(folder))] == ["trees/a.yaml"]
