"""``skills``, ``robots``, what ``show`` prints, and the help."""

from __future__ import annotations

from pathlib import Path

import pytest

from humanoid_bt.cli import main
from humanoid_bt.cli.arguments import parser
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.nodes.registry import Registry


@pytest.fixture(autouse=True)
def in_project(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(project)
    monkeypatch.setenv("COLUMNS", "80")


def code_of(arguments: list[str]) -> int:
    """Return the exit code, also where the parser exits."""
    try:
        return main(arguments)
    except SystemExit as exit:
        return int(exit.code or 0)


def test_show_draws_a_tree(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["show", "fetch"]) == 0
    drawn = capsys.readouterr().out.splitlines()
    assert drawn[1] == "└─ emergency_stop"
    assert any(line.endswith("approach  target: target, distance: 0.4 m") for line in drawn)


def test_show_writes_dot(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["show", "fetch", "--format", "dot"]) == 0
    text = capsys.readouterr().out
    assert text.startswith('digraph "fetch" {')
    assert text.endswith("}\n")


@pytest.mark.parametrize("columns", [40, 50, 80, 120])
def test_skills_fit_the_terminal(
    columns: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    assert main(["skills", "approach", "walk"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert max(len(line) for line in lines if "/" not in line) <= max(columns, 48)
    assert [line for line in lines if line != line.rstrip()] == []
    text = " ".join(" ".join(lines).split())
    assert "angle_tolerance number [rad] = 0.12" in text
    assert "commands base; from skills/mine.py" in text


def test_an_unknown_skill_gets_the_valid_names(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["skills", "aproach"]) == 2
    assert "did you mean 'approach'?" in capsys.readouterr().err


def test_robots_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robots"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("humanoid  ")
    assert "31 joints" in out


def test_a_robots_joints_are_listed_in_their_order(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robots", "humanoid"]) == 0
    assert "  joints  left_hip_yaw, left_hip_roll, left_hip_pitch, left_knee," in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "required: COMMAND\n    see: humanoid-bt --help"),
        (["rum"], "unknown command 'rum': did you mean 'run'?"),
        (["run"], "required: TREE\n    see: humanoid-bt run --help"),
        (["run", "fetch", "--sed", "3"], "unknown argument '--sed'"),
        (["run", "fetch", "--robto=x"], "unknown argument '--robto=x'; did you mean '--robot'?"),
        (["run", "fetch", "--seed", "x"], "argument --seed: must be a whole number, 0 or more, not 'x'"),
        (["run", "fetch", "--seed", "-1"], "must be a whole number, 0 or more"),
        (["run", "fetch", "--duration", "0"], "must be a number above 0, in s or with a unit (ms, min), not '0'"),
        (["run", "fetch", "--serve", "99999"], "must be a port from 1 to 65534"),
        (["run", "fetch", "--mode", "fast"], "unknown --mode 'fast': valid: lockstep"),
        (["run", "fetch", "--view", "--no-view"], "not allowed with argument --view"),
        (["robots", "humanod"], "no robot named 'humanod'"),
        (["nodes", "wachdog"], "no node named 'wachdog'"),
    ],
)
def test_wrong_arguments_get_two_lines(arguments: list[str], says: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert code_of(arguments) == 2
    err = capsys.readouterr().err
    assert says in err
    assert len(err.splitlines()) == 2


@pytest.mark.parametrize("written", ["90", "90s", "1.5 min", "90000 ms"])
def test_durations_may_have_a_unit(written: str) -> None:
    assert parser().parse_args(["run", "fetch", "--duration", written]).duration == pytest.approx(90.0)


def test_trees_tell_their_parameters(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["trees", "fetch"]) == 0
    out = " ".join(capsys.readouterr().out.split())  # however long the path is and where it is wrapped
    assert out.startswith("fetch Walk to the target")
    assert "scene ball_on_stand; from " in out
    assert "stop_distance number [m] = 0.4 m" in out


def test_scenes_tell_what_is_in_them(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["scenes", "ball_on_stand"]) == 0
    lines = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    assert "object ball orange ball on a stand at [1.9, 0.5, 0.85] m" in lines
    assert "percept target of ball" in lines
    assert "event 2 s hide ball" in lines


def test_nodes_are_listed_by_kind_and_explained_by_name(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["nodes"]) == 0
    listed = [line.split()[0] for line in capsys.readouterr().out.splitlines() if line.startswith("  ")]
    assert set(Registry.of(Workspace())) <= set(listed)
    assert main(["nodes", "fallback", "watchdog", "approach"]) == 0
    out = capsys.readouterr().out
    assert "another name of selector" in out
    assert "on_stale  node        optional" in out
    assert "    approach: {target: target, distance: 0.4 m}" in out
    assert "= 0.12 (6.9 deg)" in out


def test_a_file_with_mistakes_is_told_behind_the_others(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (project / "trees").mkdir(exist_ok=True)
    (project / "trees" / "bad.yaml").write_text("format: 3\nroot: idle\n", encoding="utf-8")
    assert code_of(["trees"]) == 2
    told = capsys.readouterr()
    assert "fetch  Walk" in told.out
    assert "bad.yaml:1:9: error: 'format' cannot be 3" in told.err


@pytest.mark.parametrize("command", ["run", "check", "show", "trees", "nodes", "skills", "scenes", "robots", "bench"])
def test_every_command_has_help(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert code_of([command, "--help"]) == 0
    assert f"usage: humanoid-bt {command}" in capsys.readouterr().out


def test_the_help_tells_the_exit_codes(capsys: pytest.CaptureFixture[str]) -> None:
    assert code_of(["--help"]) == 0
    assert "3    stopped for safety" in capsys.readouterr().out


def test_check_and_run_name_the_same_skills_for_a_built_in_tree(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "skills").mkdir()
    code = "class Idle(Skill):\n    def update(self): return self.running('')\n"
    skill = f"from humanoid_bt.decision.skill import Skill\n\n{code}"
    (tmp_path / "skills" / "idle.py").write_text(skill, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    for command in (["check", "fetch"], ["show", "fetch"], ["run", "fetch", "--no-record", "--no-view"]):
        assert code_of(command) == 2
        assert "unknown parameter 'look_around' of 'idle'" in "".join(capsys.readouterr())


def test_a_sub_tree_says_what_it_gives_and_which_nodes_it_takes(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["trees", "handover", "search", "patrol"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "taken node = {wait: 5 s} What succeeds when it is done" in out
    assert "visited whole number output How many places it came to" in out
