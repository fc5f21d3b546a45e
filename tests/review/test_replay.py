"""A recorded run, run again from its inputs."""

from __future__ import annotations

import json
import math
import random
import runpy
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from humanoid_bt.cli import main
from humanoid_bt.core.errors import UserError
from humanoid_bt.record.reading import News, read_flight
from humanoid_bt.record.shape import SETUP
from humanoid_bt.review.explain import explain
from humanoid_bt.review.recording import open_recording
from humanoid_bt.review.replay import replay
from humanoid_bt.session.session import Session
from tests.projects import make_project
from tests.review.data.test_damage import ODD, log_with, mangled
from tests.review.direct import recorded_directly

TREE = """\
format: 1
parameters: {{ stay: {stay} s }}
root:
  emergency_stop:
    sequence:
      - pause: {{ duration: $stay }}
      - walk: {{ raise_after: 0.4 s }}
"""


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A user's project folder."""
    folder = make_project(tmp_path_factory.mktemp("user") / "project")
    (folder / "trees/late.yaml").write_text(TREE.format(stay=0.3), encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def disturbed(project: Path) -> Path:
    """The recording of a run that was pushed, stopped and reset from outside, and left."""
    file = project / "disturbed.rrd"
    with recorded_directly(), Session("walk", workspace=project, record=file, camera=False, on_estop="wait") as session:
        session.run_until(0.5)
        session.push((0.0, 60.0, 0.0), 0.1)
        session.run_until(0.9)
        session.raise_estop("by hand")
        session.run_until(1.3)
        session.request_reset()
        session.run_until(1.7)
    return file


@pytest.fixture(scope="module")
def raising(project: Path) -> Path:
    """The recording of a run in which a skill raises an exception."""
    file = project / "raising.rrd"
    with recorded_directly(), Session("late", workspace=project, record=file, camera=False, stay=0.2) as session:
        session.run()
    return file


READING = """
    def setup(self, **kwargs):
        super().setup(**kwargs)
        self.speeds = open(__file__.rpartition("/")[0] + "/speeds.txt").read()
"""

KEYED = """\
format: 1
blackboard: { go: { type: integer, default: 0 }, seen: { type: integer, default: 3 } }
root:
  emergency_stop:
    timeout:
      duration: 0.6 s
      reactive_selector:
        - condition: go > 1 and seen == 5
        - idle
"""

GIVEN_UP = "format: 1\nroot: {emergency_stop: {timeout: {duration: 0.2 s, idle: }}}\n"


@pytest.mark.parametrize("alone", [False, True])
def test_what_a_program_sets_on_the_blackboard_comes_again(project: Path, alone: bool) -> None:
    (project / "trees/keyed.yaml").write_text(KEYED, encoding="utf-8")
    file = project / f"keyed-{alone}.rrd"
    with recorded_directly(), Session("keyed", workspace=project, record=file, camera=False) as session:
        session.blackboard["seen"] = 5
        session.run_until(0.2)
        session.blackboard["go"] = 2
        assert session.run().outcome == "success"
    again = replay(file, **({"tree": "keyed", "workspace": project} if alone else {}))
    assert (again.whole, again.outcome) == (not alone, "success")
    assert again.reason == again.recorded_reason
    assert again.reason.startswith("condition: go ")
    assert again.identical


@pytest.mark.parametrize("alone", [False, True])
def test_what_a_program_sets_or_forces_comes_again(project: Path, alone: bool) -> None:
    file = project / f"forced-{alone}.rrd"
    with recorded_directly(), Session("late", workspace=project, record=file, camera=False) as session:
        session.set("stay", "0.2 s")
        session.run_until(0.1)
        session.between_ticks(lambda: session.set("walk.raise_after", "5 s"))
        session.run_until(0.4)
        session.force("walk", "SUCCESS")
        assert session.run().outcome == "success"
    again = replay(file, **({"tree": "late", "workspace": project} if alone else {}))
    assert (again.whole, again.outcome, again.difference) == (not alone, "success", None)
    assert {row["kind"] for row in open_recording(file).inputs().to_pylist()} == {"set", "force"}


@pytest.mark.parametrize(
    "act",
    [
        lambda session: session.force("pause", "SUCCESS"),
        lambda session: (session.raise_estop("by hand"), session.request_reset()),
    ],
    ids=["force", "reset"],
)
def test_what_comes_between_the_first_two_ticks_comes_there_again(
    project: Path, tmp_path: Path, act: Callable[[Session], object]
) -> None:
    options: Any = {"workspace": project, "camera": False, "on_estop": "wait", "duration": 0.1}
    with recorded_directly(), Session("late", record=tmp_path / "run.rrd", **options) as session:
        session.step()
        act(session)
        session.run()
    again = replay(tmp_path / "run.rrd")
    assert (again.whole, again.outcome, again.difference) == (True, session.report.outcome, None)


@pytest.mark.parametrize("alone", [False, pytest.param(True, marks=pytest.mark.trials)])
def test_a_run_that_was_paused_is_compared_up_to_that(project: Path, alone: bool) -> None:
    file = project / f"paused-{alone}.rrd"
    with recorded_directly(), Session("late", workspace=project, record=file, camera=False) as session:
        session.run_until(0.2)
        session.pause()
        session.wait(0.2)
        session.resume()
        session.run_until(0.5)
    again = replay(file, **({"tree": "late", "workspace": project} if alone else {}))
    assert again.identical
    assert again.notes[0].startswith("somebody paused the run at 0.2")
    assert again.duration == pytest.approx(0.2, abs=0.021)


@pytest.mark.parametrize("alone", [False, True])
def test_a_run_that_waited_for_an_edit_is_compared_up_to_the_end_of_its_tree(project: Path, alone: bool) -> None:
    (project / "trees/given_up.yaml").write_text(GIVEN_UP, encoding="utf-8")
    file = project / f"waited-{alone}.rrd"
    options: Any = {"record": file, "camera": False, "duration": 1.0, "watch": True, "pace": 1e9}
    with recorded_directly(), Session("given_up", workspace=project, **options) as session:
        assert session.run().sim_time == pytest.approx(1.0)
    assert open_recording(file).ended == pytest.approx(0.2)
    assert "at 0.200 s while 'idle' still ran" in explain(file).headline
    again = replay(file, **({"tree": "given_up", "workspace": project} if alone else {}))
    assert (again.identical, again.outcome, again.duration) == (True, "failure", pytest.approx(0.2))
    if not alone:
        assert again.notes == ["the run went on after its tree, which ended at 0.20 s: the rest is not compared"]


GESTURE = """
from humanoid_bt import Skill, Status


class Gesture(Skill):
    \"\"\"Turn both hands, then bend an arm.\"\"\"

    resources = ("left_hand", "right_hand")
    bounded = True

    def initialise(self) -> None:
        self.since = self.robot.clock.now()

    def update(self) -> Status:
        now = self.robot.clock.now() - self.since
        if now > 1.0:
            return self.succeed("done")
        if now > 0.6:
            self.robot.move_arm("right", {"right_elbow": -1.2}, speed=0.8)
            return self.running("bending")
        place = self.robot.pose("left_shoulder").position + (0.3, 0, -0.2)
        self.robot.move_hand("left", place, direction=(1, 0, 0), speed=0.2)
        self.robot.move_hand("right", (0, 0, 0.3), (0, 1, 0, 0), relative=True)
        return self.running("turning")
"""


@pytest.mark.parametrize("alone", [False, pytest.param(True, marks=pytest.mark.trials)])
def test_what_is_asked_of_hands_and_arms_comes_again_to_the_bit(project: Path, alone: bool) -> None:
    (project / "skills/gesture.py").write_text(GESTURE, encoding="utf-8")
    (project / "trees/gesture.yaml").write_text("format: 1\nroot: {emergency_stop: gesture}\n", encoding="utf-8")
    file = project / f"gesture-{alone}.rrd"
    with recorded_directly(), Session("gesture", workspace=project, record=file, camera=False) as session:
        assert session.run().outcome == "success"
    again = replay(file, **({"tree": "gesture", "workspace": project} if alone else {}))
    assert (again.whole, again.identical) == (not alone, True)
    rows = open_recording(file).table("commands").to_pylist()
    followed = next(row for row in rows if row["relative"])
    assert (followed["resource"], followed["z"], followed["qx"]) == ("right_hand", 0.3, 1.0)
    led = next(row for row in rows if row["axis"])
    assert (led["axis"], led["dx"], led["speed"]) == ("fingers", 1.0, 0.2)
    assert next(json.loads(row["joints"]) for row in rows if row["joints"]) == {"right_elbow": -1.2}
    told = " ".join(str(explain(file, at=0.4)).split())
    assert "left hand to (" in told and "fingers along (1.00, 0.00, 0.00), at most 0.2 m/s" in told
    assert "right hand to (0.00, 0.00, 0.30) m from the other palm, turned to (0.00, 1.00, 0.00, 0.00)" in told
    assert "right arm at right_elbow -69 deg, at most 0.8 rad/s" in " ".join(str(explain(file, at=0.8)).split())


def test_a_run_again_is_the_same_to_the_bit(disturbed: Path) -> None:
    again = replay(disturbed)
    assert again.difference is None
    assert (again.whole, again.identical) == (True, True)
    assert again.ticks == sum(1 for _ in read_flight(disturbed).ticks())
    assert (again.outcome, again.recorded_outcome) == ("unfinished", "unfinished")


@pytest.mark.trials
def test_so_is_one_that_ends_with_an_exception(raising: Path) -> None:
    again = replay(raising)
    assert again.identical
    assert again.outcome == "error"
    assert "KeyError" in again.reason
    assert not again.passes


@pytest.mark.trials
def test_it_needs_nothing_of_the_workspace(raising: Path, project: Path, tmp_path: Path) -> None:
    away = tmp_path / "sent.rrd"
    shutil.copy(raising, away)
    moved = project.rename(project.with_name("moved"))
    try:
        assert replay(away).identical
    finally:
        moved.rename(project)


@pytest.mark.trials
def test_without_its_inputs_it_is_another_run(disturbed: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = read_flight(disturbed)
    log.news[:] = [news for news in log.news if not (news.kind == "input" and news.value[1] == "push")]
    monkeypatch.setattr("humanoid_bt.review.replay.read_flight", lambda _: log)
    again = replay(disturbed)
    assert again.difference is not None
    assert again.difference.time == pytest.approx(0.52)  # the tick after the push
    assert "base_" in again.difference.quantity or "joint_" in again.difference.quantity
    assert f"first difference  at 0.520 s {again.difference.quantity}: " in str(again)


PAUSE, WALK = (f"late/emergency_stop/sequence/{name}" for name in ("pause", "walk"))


@pytest.mark.parametrize(
    ("recorded", "told"),
    [
        ([0.1, [PAUSE, "SUCCESS", "waited"]], (0.1, f"node {PAUSE}", "SUCCESS", "no change")),
        ([0.2, ["late/odd", "SUCCESS", ""]], (0.2, "node late/odd", "SUCCESS", f"{PAUSE} SUCCESS")),
        (None, (0.2, f"node {WALK}", "RUNNING", f"{PAUSE} SUCCESS")),
    ],
)
def test_a_node_that_changes_otherwise_is_told_with_the_tick_in_which_it_does(
    raising: Path, monkeypatch: pytest.MonkeyPatch, recorded: list[Any] | None, told: tuple[float, str, str, str]
) -> None:
    log = read_flight(raising)
    index = next(i for i, news in enumerate(log.news) if news.kind == "node" and news.value[1] == "SUCCESS")
    if recorded is None:
        del log.news[index]
    else:
        log.news.insert(index, News(recorded[0], "node", recorded[1]))
    monkeypatch.setattr("humanoid_bt.review.replay.read_flight", lambda _: log)
    found = replay(raising).difference
    assert found is not None
    assert (round(found.time, 6), *found[1:]) == told


def test_decision_alone_decides_the_same(raising: Path) -> None:
    again = replay(raising, tree="late", parameters={"stay": "0.2 s"})
    assert not again.whole
    assert again.identical
    assert again.outcome == "error"


def test_another_value_decides_otherwise_at_a_moment(raising: Path) -> None:
    again = replay(raising, parameters={"stay": "0.1 s"})
    assert again.difference is not None
    assert again.difference.time == pytest.approx(0.1)
    assert again.difference.quantity == "node late/emergency_stop/sequence/pause"
    assert (again.difference.before, again.difference.after) == ("no change", "SUCCESS")


def test_a_parameter_that_was_given_is_given_again(raising: Path) -> None:
    assert read_flight(raising).setup["tree"]["parameters"]["stay"] == {
        "value": 0.2,
        "written": "0.2 s",
        "from": "given",
    }


def test_a_recording_becomes_a_test_that_fails_until_it_is_mended_where_the_test_stands(
    raising: Path, project: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    elsewhere = tmp_path / "elsewhere"
    shutil.copytree(project, elsewhere, ignore=shutil.ignore_patterns("*.rrd"))
    (elsewhere / "tests").mkdir()
    test = elsewhere / "tests/test_late.py"
    assert main(["replay", str(raising), "--json", "--to-test", str(test)]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["identical"]
    assert "fails now, until what went wrong is mended" in err
    assert not passes(test)
    skills, before = next(
        (file, text)
        for file in (elsewhere / "skills").glob("*.py")
        if 'raise KeyError("missing")' in (text := file.read_text(encoding="utf-8"))
    )
    skills.write_text(before.replace('raise KeyError("missing")', 'return self.succeed("there")'), encoding="utf-8")
    assert passes(test)
    assert main(["replay", str(raising), "--to-test", str(test)]) == 2
    assert "exists" in capsys.readouterr().err


def passes(test: Path) -> bool:
    """Return whether what is in a file of tests passes, without the second that pytest takes to begin."""
    (run,) = (what for name, what in runpy.run_path(str(test)).items() if name.startswith("test_"))
    try:
        run()
    except AssertionError:
        return False
    return True


def test_a_later_part_of_a_recording_is_not_replayed_alone(raising: Path, tmp_path: Path) -> None:
    part = shutil.copy(raising, tmp_path / "raising.part002.rrd")
    with pytest.raises(UserError, match=r"raising.part002.rrd' cannot be replayed without its part 1"):
        replay(part)
    assert ("damaged", "part 1 is missing among its files") in explain(part).rows


def test_the_command_says_whether_it_is_identical(raising: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replay", str(raising), "--set", "stay=0.1s", "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert (told["identical"], told["difference"]["quantity"]) == (False, "node late/emergency_stop/sequence/pause")
    assert main(["replay", str(raising), "--set", "stai=0.1s"]) == 2
    assert "did you mean 'stay'?" in capsys.readouterr().err


def test_what_is_missing_is_told(raising: Path, project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = read_flight(raising)
    monkeypatch.setattr("humanoid_bt.review.replay.read_flight", lambda _: log)
    mesh = {"role": "model", "name": "sim/other/arm.stl", "sha256": "0"}
    log.setup["files"].append(mesh)
    with pytest.raises(UserError, match="1 files of the run are not in the recording"):
        replay(raising)
    log.setup["files"].remove(mesh)
    skills = next(file for file in log.setup["files"] if "class Walk" in file.get("text", ""))
    skills["text"] = skills["text"].replace("    def initialise", f"{READING}\n    def initialise", 1)
    with pytest.raises(UserError, match=r"pause' reads 'skills/speeds.txt', which is not recorded\n.*--current"):
        replay(raising)
    with pytest.raises(UserError, match="'files' cannot be 'curent'\n    did you mean 'current'"):
        replay(raising, files="curent")
    with pytest.raises(UserError, match=r"'trees/late\.yaml' of the run is not in"):
        replay(raising, files="current", workspace=project.parent)
    log.setup = SETUP({})
    with pytest.raises(UserError, match="does not say what was run"):
        replay(raising)


@pytest.mark.trials
def test_a_recording_that_says_something_else_is_answered(raising: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    chance, whole, answered = random.Random(3), read_flight(raising), 0
    times, kinds = [0.1, -1.0, 1e300, math.nan], ["node", "unseen", "input", "stop", "tree", "end", "limits"]
    for number in range(18):
        log = read_flight(raising)
        if number % 2:
            log.setup = SETUP({key: mangled(value, chance) for key, value in whole.setup.items()})
        else:
            odd = [[chance.choice(times), chance.choice(kinds), chance.choice(ODD)] for _ in range(5)]
            more = log_with({}, odd, {})
            log.blocks["news"] += more.blocks["news"]
            log.until["news"] += more.until["news"]
        monkeypatch.setattr("humanoid_bt.review.replay.read_flight", lambda _, log=log: log)
        try:
            str(replay(raising, parameters={} if number % 6 == 0 else {"stay": "0.1 s"}))
        except UserError:
            answered += 1
    assert 0 < answered < 9


@pytest.mark.trials
@pytest.mark.realtime
def test_decisions_of_realtime_are_made_again(project: Path) -> None:
    file = project / "realtime.rrd"
    with Session("late", workspace=project, mode="realtime", record=file, camera=False) as session:
        session.run()
    again = replay(file)
    assert not again.whole
    assert again.difference is None
    assert (again.outcome, again.recorded_outcome) == ("error", "error")
