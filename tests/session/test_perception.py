"""Runs with percept sources of a workspace: named by scene, tree or run, isolated, replayed, in both modes."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

import humanoid_bt as hbt
from humanoid_bt.cli import main
from humanoid_bt.core.errors import UserError
from humanoid_bt.plant.camera_client import CameraProcess
from humanoid_bt.plant.rendering import Shot
from tests.perception.opengl import opengl
from tests.perception.sources import BAD, SIGN, write

__all__ = ["opengl"]

SEE = """
format: 1
{header}
root:
  emergency_stop:
    watchdog:
      percept: sign
      max_age: 0.5 s
      sequence:
        - wait_until: "sign.class == 'sign' and distance(sign) > 1.5 m"
        - wait: 0.6 s
"""
SCENE = "format: 1\nname: doors\nperception: [tracker, door_sign, {raises: {}}]\n"


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    write(tmp_path, "door_sign.py", SIGN)
    write(tmp_path, "bad.py", BAD)
    for folder in ("trees", "sim/scenes"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "sim/scenes/doors.yaml").write_text(SCENE)
    (tmp_path / "trees/see.yaml").write_text(SEE.format(header="scene: doors"))
    (tmp_path / "trees/own.yaml").write_text(SEE.format(header="perception: {door_sign: {ahead: 180 cm}}"))
    return tmp_path


def test_a_scene_names_sources_and_one_that_raises_is_told(project: Path) -> None:
    report = hbt.run("see", record="run.rrd")
    assert report.outcome == "success", report.reason
    told = [(event["time"], event["text"]) for event in report.events if event["level"] == "error"]
    assert [time for time, _ in told] == [0.5]
    assert "the percept source 'raises' is off: it raised KeyError: 'no detector' (perception/bad.py:13" in told[0][1]
    assert report.percepts["sign"]["class"] == "sign"
    events = hbt.open_recording("run.rrd").events()
    assert any("'raises' is off" in text for text in events["text"].to_pylist())
    again = hbt.replay("run.rrd")
    assert (again.whole, again.difference) == (True, None)


def test_a_tree_names_sources_and_a_run_others(project: Path) -> None:
    assert hbt.run("own").percepts["sign"]["distance"] == pytest.approx(1.8, abs=0.1)
    given = hbt.run("own", perception={"door_sign": {"ahead": 2.5}})
    assert given.percepts["sign"]["distance"] == pytest.approx(2.5, abs=0.1)


def test_the_same_seed_is_the_same_run(project: Path) -> None:
    first, again, other = (hbt.run("own", seed=seed).trace_hash for seed in (1, 1, 2))
    assert first == again != other


def test_a_percept_that_no_source_publishes_is_a_warning(project: Path) -> None:
    file = project / "trees/own.yaml"
    file.write_text(file.read_text().replace("door_sign: {ahead: 180 cm}", "door_sign: {sign: plate}"))
    (problem,) = [one for one in hbt.check("trees/own.yaml") if one.code == "unknown-percept"]
    assert "percept 'sign'" in problem.message


@pytest.mark.parametrize(
    ("file", "text", "place"),
    [
        ("trees/own.yaml", SEE.format(header="perception: {door_sing: {}}"), "trees/own.yaml:3:14"),
        ("trees/own.yaml", SEE.format(header="perception: {door_sign: {ahead: fast}}"), "trees/own.yaml:3:33"),
        ("sim/scenes/doors.yaml", SCENE.replace("door_sign", "door_sing"), "sim/scenes/doors.yaml:3:23"),
    ],
)
def test_mistakes_are_told_where_they_are_written(project: Path, file: str, text: str, place: str) -> None:
    (project / file).write_text(text)
    errors = [problem for problem in hbt.check(file) if problem.severity == "error"]
    assert [str(problem.place) for problem in errors] == [place]


def test_a_file_of_sources_is_checked_by_itself(project: Path) -> None:
    write(project, "empty.py", "")
    (problem,) = hbt.check("perception/empty.py")
    assert (str(problem.place), problem.code) == ("perception/empty.py:1:1", "broken-source")
    assert not hbt.check("perception/door_sign.py")


def test_without_opengl_a_source_that_needs_pictures_says_so(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "disabled")
    with pytest.raises(UserError, match=r"needs the head camera, and there is no picture: .*OpenGL(.|\n)*libegl1"):
        hbt.run("fetch", perception="color_blob")


def test_a_dry_run_has_no_pictures() -> None:
    with pytest.raises(UserError, match="'color_blob' needs the head camera, and a dry run has no picture"):
        hbt.Stage(dry=True, perception="color_blob").run("fetch")


@pytest.mark.usefixtures("opengl")
def test_a_camera_that_dies_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    take = CameraProcess.take

    def killed(camera: CameraProcess, shot: Shot) -> object:
        if shot.time >= 0.6 and camera.process is not None:
            camera.process.kill()
            camera.process.wait()
        return take(camera, shot)

    monkeypatch.setattr(CameraProcess, "take", killed)
    report = hbt.run("fetch", perception="color_blob", duration=1.5)
    assert [event["text"] for event in report.events if event["level"] == "error"] == [
        "the percept source 'color_blob' is off: it has no picture: its process ended"
    ]


def test_the_command_line_names_sources_with_parameters_and_lists_them(
    project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = ["--perception", "door_sign: {ahead: 3 m}", "--perception", "tracker", "--no-record", "--report", "r.json"]
    assert main(["run", "own", "--quiet", *given]) == 0
    assert json.loads(Path("r.json").read_text())["percepts"]["sign"]["distance"] == pytest.approx(3.0, abs=0.1)
    assert main(["run", "own", "--perception", "door_sing", "--no-record"]) == 2
    assert "--perception door_sing: error: no percept source named 'door_sing'" in capsys.readouterr().err
    for given, wrong in (
        ("door_sign: {ahaed: 3 m}", "unknown parameter 'ahaed' of 'door_sign'"),
        ("door_sign: {ahead: 3 kg}", "'ahead' has the unit 'kg'"),
    ):
        assert main(["run", "own", "--perception", "tracker", "--perception", given, "--no-record"]) == 2
        assert capsys.readouterr().err.startswith(f"--perception {given}: error: {wrong}")
    assert main(["sources", "door_sign"]) == 0
    assert "25 Hz, needs nothing; from perception/door_sign.py" in capsys.readouterr().out


def test_a_dry_run_and_a_stage_see_with_a_trees_sources(project: Path) -> None:
    stage = hbt.Stage(dry=True)
    run = stage.run("own")
    assert run.succeeded, run.reason
    assert run.report.percepts["sign"]["distance"] == pytest.approx(1.8, abs=0.1)
    assert stage.run("own").trace == run.trace


@pytest.mark.realtime
def test_in_realtime_sources_run_in_the_perception_process(project: Path) -> None:
    tree = project / "trees/see.yaml"
    tree.write_text(tree.read_text().replace("0.6 s", "2 s"))
    (project / "sim/scenes/doors.yaml").write_text(SCENE.replace("raises", "blocks"))
    report = hbt.run("see", mode="realtime", duration=20)
    assert report.outcome == "success", report.reason
    (told,) = [event["text"] for event in report.events if "percept source" in event["text"]]
    assert told == "the percept source 'blocks' is off: it has been at it for more than 0.2 s"


AGAIN = """
format: 1
root:
  emergency_stop:
    sequence:
      - wait: 0.2 s
      - watchdog:
          percept: sign
          max_age: 1 min
          sequence:
            - wait_until: sign.age > 1 s
            - timeout: {duration: 20 s, wait_until: sign.age < 0.2 s}
"""


@pytest.mark.trials
@pytest.mark.realtime
def test_a_source_that_keeps_the_lock_is_off_and_the_others_see_again(project: Path) -> None:
    (project / "trees/again.yaml").write_text(AGAIN)
    for _ in range(3):
        report = hbt.run("again", perception=["door_sign", "holds"], mode="realtime", duration=60)
        (told,) = [event["text"] for event in report.events if event["level"] == "error"]
        if "one of them held up" not in told:  # it is not known which if both had just begun to look
            break
    assert report.outcome == "success", report.reason
    held = r"the percept source 'holds' is off: it held up perception for 3\.\d s, which begins anew without it"
    assert re.fullmatch(held, told)


@pytest.mark.trials
@pytest.mark.realtime
def test_in_realtime_a_source_that_cannot_begin_is_told(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "disabled")
    with pytest.raises(UserError, match="needs the head camera, and there is no picture"):
        hbt.run("fetch", perception="color_blob", mode="realtime")
