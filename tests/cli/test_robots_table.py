"""``robots table``, of trials and speeds that are made up; pictures are taken where there is OpenGL."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from pathlib import Path
from typing import Any

import pytest

from humanoid_bt.bench.body import Withstood
from humanoid_bt.bench.body_rows import Row
from humanoid_bt.bench.figure import figure
from humanoid_bt.bench.robot_table import Speed
from humanoid_bt.campaign.result import Cost, Result
from humanoid_bt.campaign.trial import Task
from humanoid_bt.campaign.workers import Done
from humanoid_bt.cli import main, robots_table
from humanoid_bt.files.workspace import Workspace, builtin_root


@pytest.fixture(autouse=True)
def asked(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> dict[str, Any]:
    """Put made-up trials and speeds in the place of the measurement; return what is asked for."""
    asked: dict[str, Any] = {"robots": [], "interrupt": ""}

    def measure(
        robot: Path, rows: Sequence[Row], seeds: Sequence[int], *, progress: Callable[[Withstood], None], **given: Any
    ) -> Generator[Withstood]:
        asked["robots"].append(robot.parent.name)
        asked.update(rows=[row.name for row in rows], seeds=list(seeds), **given)
        for row, body in [(row, body) for row in rows for body in given["bodies"]]:
            if asked["interrupt"] == robot.parent.name:
                raise KeyboardInterrupt
            results = [Result("success" if seed else "failure", "", values={"speed": 0.5}) for seed in seeds]
            tasks = [Task(row.trial(seed, str(robot), seed, body)) for seed in seeds]
            found = Withstood(row, [Done(*one, Cost()) for one in zip(tasks, results, strict=True)], body)
            progress(found)
            yield found

    fast, slow = figure("walks", "CPU", "s", [(3.0, 1.0)]), figure("alone", "CPU", "s", [(20.0, 1.0)])
    solve = figure("solve", "mj_step", "us CPU", [(250e-6, 2e-4)], scale=1e6)
    monkeypatch.setattr(robots_table, "measure_body", measure)
    monkeypatch.setattr(robots_table, "portrait", lambda *_: (b"a picture", ""))
    monkeypatch.setattr(Speed, "of", lambda *_: Speed(fast, slow, solve))
    monkeypatch.chdir(tmp_path)
    return asked


def copied(folder: Path, name: str) -> None:
    """Put a copy of the built-in robot into the workspace."""
    built_in = Workspace(builtin_root()).find_robot("humanoid")
    target = folder / "sim" / name
    target.mkdir(parents=True)
    (target / "humanoid.xml").write_text(built_in.with_name("humanoid.xml").read_text())
    (target / "robot.yaml").write_text(built_in.read_text().replace("name: humanoid", f"name: {name}", 1))


def test_a_table_has_what_was_measured_of_each_robot_and_its_picture(
    asked: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copied(tmp_path, "twin")
    command = ["robots", "table", "humanoid", "twin", "--out", "found", "--trials", "2", "--only", "straight", "goals"]
    assert main(command) == 0
    assert (asked["robots"], asked["rows"], asked["seeds"]) == (["humanoid", "twin"], ["goals", "straight"], [0, 1])
    assert sorted(path.name for path in Path("found").iterdir()) == ["humanoid.png", "robots.md", "twin.png"]
    lines = Path("found/robots.md").read_text().splitlines()
    assert lines[2] == "|  | robot | body | goals | straight | walks at | simulated | IK, one solve |"
    assert lines[4] == (
        '| <img src="humanoid.png" width="120" alt="humanoid"> | **humanoid**, 40.7 kg, 1.33 m, 31 joints | dcm '
        "| 1 of 2 | 1 of 2 | 0.50 m/s | 3.0x (20x) | 250 us |"
    )
    assert "**twin**" in lines[5]
    assert "Made by `humanoid-bt robots table humanoid twin --trials 2 --only straight goals`: 2 trials" in lines[7]
    out = capsys.readouterr().out
    assert "twin, dcm: straight 1/2" in out
    assert "written: found/robots.md" in out


def test_seeds_can_be_those_that_nothing_was_tuned_on(asked: dict[str, Any]) -> None:
    assert main(["robots", "table", "humanoid", "--seed", "16000", "--trials", "3"]) == 0
    assert asked["seeds"] == [16000, 16001, 16002]
    table = Path("robots/robots.md").read_text()
    assert (
        "Made by `humanoid-bt robots table humanoid --trials 3 --seed 16000`: 3 trials, seeds 16000 to 16002" in table
    )


def test_without_pictures_there_is_a_table_all_the_same(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(robots_table, "portrait", lambda *_: (b"", "there is no OpenGL to render with"))
    assert main(["robots", "table", "humanoid"]) == 0
    assert "|  | **humanoid**" in Path("robots/robots.md").read_text()
    assert "humanoid: no picture: there is no OpenGL" in capsys.readouterr().out


def test_ctrl_c_leaves_the_robots_that_are_done(
    asked: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copied(tmp_path, "twin")
    asked["interrupt"] = "twin"
    assert main(["robots", "table", "humanoid", "twin"]) == 130
    table = Path("robots/robots.md").read_text()
    assert "**humanoid**" in table and "**twin**" not in table
    assert "1 of 2 robots are in the table" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["table"], "robots table takes some robots"),
        (["table", "humanoit"], "did you mean 'humanoid'"),
        (["table", "humanoid", "humanoid"], "two of the robots are called 'humanoid'"),
        (["table", "humanoid", "--only", "goal"], "did you mean 'goals'"),
        (["table", "humanoid", "--out", "a_file/below"], "the folder 'a_file/below' cannot be made"),
        (["humanoid", "--trials", "3"], "--trials is for robots table"),
        (["humanoid", "--seed", "0"], "--seed is for robots table"),
    ],
)
def test_a_mistake_is_told_with_what_is_valid(
    arguments: list[str], message: str, asked: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    Path("a_file").write_text("")
    assert main(["robots", *arguments]) == 2
    assert message in capsys.readouterr().err
    assert asked["robots"] == []
