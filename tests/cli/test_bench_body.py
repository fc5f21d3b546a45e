"""What ``bench --body`` prints and writes, of trials that are made up."""

from __future__ import annotations

import json
from collections.abc import Callable, Generator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from humanoid_bt.bench.body import Withstood, chosen
from humanoid_bt.bench.body_rows import Row
from humanoid_bt.campaign.result import Cost, Result
from humanoid_bt.campaign.trial import Task
from humanoid_bt.campaign.workers import Done
from humanoid_bt.cli import bench_body, main
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.robot.model import BASE_COORDINATES
from tests.policy_files import write_standing_robot

FALLS = "the robot is falling: its base is tilted (supervisor)"


@pytest.fixture(autouse=True)
def asked(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Put made-up trials in the place of the measurement; return what is asked for, and set when it is interrupted."""
    asked: dict[str, Any] = {"interrupt": 10_000}

    def measure(
        robot: Path, rows: Sequence[Row], seeds: Sequence[int], *, progress: Callable[[Withstood], None], **given: Any
    ) -> Generator[Withstood]:
        asked.update(robot=robot, rows=[row.name for row in rows], seeds=list(seeds), **given)
        number = 0
        for row, body in [(row, body) for row in rows for body in given["bodies"]]:
            trials: list[Done] = []
            for seed in seeds:
                if number == asked["interrupt"]:
                    raise KeyboardInterrupt
                result = Result("success", "there", time=9.0, trace="abc")
                if row.name == "slope" and seed % 2:
                    result = Result("fell", FALLS, time=seed / 10, fell=True)
                if body == "dcm" and seed == 0:
                    result = Result("fell", FALLS, time=2.0, fell=True)
                if row.name == "slope" and seed == 4:
                    result = Result("failure", "walk_to: comes no nearer", time=30.0)
                if row.name == "odometry":
                    values = {"drift": 0.001 * seed, "heading_error": 0.01, "velocity_error": 0.02}
                    result = replace(result, values=values, units={"heading_error": "rad", "velocity_error": "m/s"})
                recording = str(given["recordings"](row, seed, body)) if given["recordings"] else ""
                trials.append(Done(Task(row.trial(number, str(robot), seed, body), recording), result, Cost()))
                progress(Withstood(row, list(trials), body))
                number += 1
            yield Withstood(row, trials, body)

    monkeypatch.setattr(bench_body, "measure_body", measure)
    return asked


@pytest.mark.parametrize("columns", [60, 80])
def test_the_table_fits_a_small_terminal(
    columns: int, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    assert main(["bench", "--body"]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert max(len(line) for line in lines if "humanoid-bt bench" not in line) <= columns
    assert "  humanoid-bt bench --body --only slope --seed 1 --trials 1 --record" in lines, "not broken"
    rows = [" ".join(line.split()) for line in lines]
    assert "goals 20/20 20/20 84-100 % 95 % ok" in rows
    assert "push-standing-200 20/20 84-100 % 90 % ok" in rows
    assert "slope 9/20 10/20 26-66 % 95 % missed" in rows


def test_what_a_row_limits_is_told_beside_its_limit(capsys: pytest.CaptureFixture[str]) -> None:
    main(["bench", "--body", "--only", "odometry", "goals", "--trials", "3", "--seed", "4"])
    told = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    assert told[told.index("odometry mean worst limit") + 1 :] == [
        "drift 0.50 % 0.60 % 1.50 %",
        "heading error 0.57 deg 0.57 deg 1.5 deg",
        "velocity error 0.02 m/s 0.02 m/s 0.03 m/s",
    ]


def test_what_failed_is_told_with_the_worst_first_and_the_command_that_shows_it(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    assert main(["bench", "--body", "--only", "slope", "goals"]) == 1
    rows = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    assert rows[rows.index("slope: a slope of 4 deg") :] == [
        "slope: a slope of 4 deg",
        "fell: seeds 1, 3, 5, 7, 9 and 5 more",
        "not there: seeds 4",
        f"seed 1, 0.1 s: {FALLS}",
        "humanoid-bt bench --body --only slope --seed 1 --trials 1 --record",
    ]


def test_a_robot_with_two_bodies_has_them_side_by_side(
    asked: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("onnxruntime", reason="learned walkers need onnxruntime: pip install 'humanoid-bt[policy]'")
    robot, standing = load_robot(Workspace(builtin_root()).find_robot("humanoid"))
    path = write_standing_robot(tmp_path, robot.joint_names, standing[BASE_COORDINATES:])
    monkeypatch.setenv("COLUMNS", "200")  # whatever the length of the path
    command = ["bench", "--body", "--robot", str(path), "--only", "goals", "--trials", "4"]
    assert main(command) == 1
    lines = capsys.readouterr().out.splitlines()
    for title, value in (("goal", "4/4"), ("promised", "95 %")):
        assert lines[2].index(title) + len(title) == lines[3].index(value) + len(value), "one below the other"
    assert lines[2].rindex("feet") + len("feet") == lines[3].rindex("3/4") + len("3/4")
    rows = [" ".join(line.split()) for line in lines]
    assert rows[1:4] == ["policy dcm", "goal feet goal feet promised", "goals 4/4 4/4 ok 3/4 3/4 missed 95 %"]
    assert "goals (dcm): walks to a random goal" in rows
    assert rows[-1].endswith("--walk dcm")
    assert main([*command, "--walk", "policy"]) == 0
    assert asked["bodies"] == ["policy"]
    asked["interrupt"] = 4
    capsys.readouterr()
    assert main(command) == 130
    lines = capsys.readouterr().out.splitlines()
    assert " ".join(lines[3].split()) == "goals 4/4 4/4 ok 95 %"
    assert lines[3].index("95 %") + len("95 %") == lines[2].index("promised") + len("promised")


def test_a_row_of_three_bodies_is_one_line_also_where_that_is_wider_than_the_terminal(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr(bench_body, "bodies_of", lambda config: ("policy", "dcm", "own"))
    main(["bench", "--body", "--only", "goals", "--trials", "4"])
    rows = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    assert rows[2:4] == ["goal feet goal feet goal feet promised", "goals 4/4 4/4 ok 3/4 3/4 missed 4/4 4/4 ok 95 %"]


def test_the_exit_code_says_whether_every_promise_is_kept(asked: dict[str, Any]) -> None:
    assert main(["bench", "--body", "--only", "goals", "push-*", "--trials", "3", "--seed", "40", "-j", "2"]) == 0
    assert (asked["seeds"], asked["workers"], asked["recordings"]) == ([40, 41, 42], 2, None)
    assert main(["bench", "--body", "--only", "slope"]) == 1


def test_ctrl_c_leaves_what_is_known(asked: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked["interrupt"] = 67
    file = tmp_path / "body.json"
    assert main(["bench", "--body", "--json", str(file)]) == 130
    rows = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    walked = [f"{name} 20/20 20/20 84-100 % 95 % ok" for name in ("goals", "straight", "metre")]
    assert rows[2:6] == [*walked, "odometry 7/7 7/7 65-100 % 95 % ok"]
    assert json.loads(file.read_text(encoding="utf-8"))["whole"] is False


def test_the_file_holds_every_trial(tmp_path: Path) -> None:
    file = tmp_path / "body.json"
    assert main(["bench", "--body", "--only", "slope", "friction-0.3", "--trials", "6", "--json", str(file)]) == 1
    data = json.loads(file.read_text(encoding="utf-8"))
    assert {"machine", "versions", "robot", "trials", "first_seed", "rows"} <= data.keys()
    icy, steep = data["rows"]
    assert (icy["row"], icy["reached"], icy["on_feet"], icy["of"], icy["verdict"]) == ("friction-0.3", 6, 6, 6, "ok")
    assert (steep["reached"], steep["on_feet"], steep["promised"], steep["verdict"]) == (2, 3, 0.95, "missed")
    assert steep["interval"] == pytest.approx([0.0968, 0.7], abs=1e-3)
    assert steep["trials"][4]["seed"] == 4
    assert steep["trials"][4]["reason"] == "walk_to: comes no nearer"
    assert steep["trials"][4]["given"].keys() >= {"condition.slope", "condition.uphill", "set.x"}


def test_a_robot_without_hands_carries_nothing_in_them(
    tmp_path: Path, asked: dict[str, Any], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    built_in = Workspace(builtin_root()).find_robot("humanoid")
    text = built_in.read_text(encoding="utf-8")
    folder = tmp_path / "sim" / "armless"
    folder.mkdir(parents=True)
    (folder / "humanoid.xml").write_text(built_in.with_name("humanoid.xml").read_text(encoding="utf-8"))
    (folder / "robot.yaml").write_text(text.replace(text[text.index("hands:") : text.index("gaze:")], ""))
    monkeypatch.chdir(tmp_path)
    assert main(["bench", "--body", "--robot", "armless", "--only", "hands-*", "goals"]) == 0
    assert asked["rows"] == ["goals"]
    assert asked["robot"] == folder / "robot.yaml"
    assert "hands-2kg humanoid has no hands" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--body", "--only", "slop"], "did you mean 'slope'"),
        (["--body", "--robot", "humanoit"], "did you mean 'humanoid'"),
        (["--trials", "3"], "--trials goes with --body"),
        (["--realtime", "--only", "slope"], "--only goes with --body"),
    ],
)
def test_a_mistake_is_told_with_what_is_valid(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["bench", *arguments]) == 2
    assert message in capsys.readouterr().err


def test_recordings_are_named(
    asked: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "120")
    assert main(["bench", "--body", "--only", "slope", "--trials", "1", "--seed", "7", "--record"]) == 1
    out = capsys.readouterr().out
    assert "in a trial each, seed 7" in out
    recording = asked["recordings"](chosen(["slope"])[0], 7, None)
    assert recording.parent == tmp_path / "runs"
    assert recording.name.startswith("slope-seed7-")
    shown = [line.split() for line in out.splitlines() if "runs/" in line]
    assert [line[:-1] for line in shown] == [["humanoid-bt", "explain"], ["open", "it:", "rerun"]]
    assert shown[0][-1] == shown[1][-1]
