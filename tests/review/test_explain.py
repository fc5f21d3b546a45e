"""What else an explanation tells: moments, nodes, joints, data for programs, wrong names."""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import humanoid_bt as hbt
from humanoid_bt.cli import main
from humanoid_bt.core.messages import Percept
from humanoid_bt.record.reading import Cycles, News, read_flight
from humanoid_bt.review.body import Motion
from humanoid_bt.review.explain import modes_told
from humanoid_bt.review.happened import Happened
from humanoid_bt.review.hints import EXPLAIN_JOINT, hints
from humanoid_bt.review.history import Change, History, Span
from humanoid_bt.review.life import life_explained
from humanoid_bt.review.moment import moment_explained
from humanoid_bt.review.pushed import hardest_push
from humanoid_bt.review.scene import sight_rows
from humanoid_bt.session.session import Session

Play = Callable[..., Path]


@pytest.fixture(scope="module")
def fallen(play: Play) -> Path:
    """A robot that walked for a second and was pushed over."""
    return play("walk", duration=4.0, at=1.0, do=lambda session: session.push((0.0, -400.0, 0.0), 0.2))


@pytest.fixture(scope="module")
def seen(play: Play) -> Path:
    """A robot that approached a ball until the scene hid it at 0.4 s."""
    return play("doubtful")


def test_modes_are_those_of_the_servo_cycles(fallen: Path) -> None:
    found = hbt.explain(fallen)
    run, damp = found.data["modes"]
    (stop,) = found.data["stops"]
    assert (run["mode"], damp["mode"]) == ("run", "damp")
    assert damp["begin"] == pytest.approx(stop["time"], abs=1e-6)
    assert f"damp from {stop['time']:.3f} s to the end" in found.text(200)
    assert found.time == pytest.approx(stop["time"])


@pytest.mark.parametrize(
    ("mode", "lasting", "told"),
    [
        ([0], 20.0, "run all the time, until 12.000 s and on"),
        ([0], 12.0, "run all the time, to the end, 12.000 s"),
        ([0, 1], 20.0, "run until 2.000 s, protective stop from 2.000 s until 12.000 s and on"),
        ([0, 1], 12.0, "run until 2.000 s, protective stop from 2.000 s to the end, 12.000 s"),
        (
            [0, 1, 0, 1, 0, 1],
            20.0,
            "run until 2.000 s, protective stop from 2.000 s, run from 4.000 s, protective stop from 6.000 s, "
            "and 2 more changes",
        ),
    ],
)
def test_the_modes_end_where_the_run_does(mode: list[int], lasting: float, told: str) -> None:
    names = ["run", "protective_stop"]
    spans = [Span(2.0 * number, 2.0 * number + 2.0, names[of]) for number, of in enumerate(mode)]
    spans[-1] = spans[-1]._replace(until=12.0)
    history: Any = SimpleNamespace(modes=lambda _begin, end: spans if end == 12.0 else [], until=lasting)
    assert modes_told(history, 2.0) == told


def test_a_push_is_found_where_it_was_and_steps_are_none(fallen: Path) -> None:
    log = read_flight(fallen)
    push = Motion(log, 0.0, 1.4).push()
    assert push is not None
    assert push.begin == pytest.approx(1.0, abs=0.02)
    assert push.end == pytest.approx(1.2, abs=0.05)
    assert push.direction == "to the right"
    assert Motion(log, 0.0, 0.99).push() is None


@pytest.mark.parametrize(
    ("pushed", "lost", "is_seen", "known"),
    [
        (1.5, 1.7, True, "in time"),
        (0.07, 0.2, False, "in time"),  # nobody knows yet what steps do, nor when it lost its balance
        (0.6, 2.5, False, ""),  # it walked on for long after that
        (1.9, 1.7, False, "late"),  # it fell already
    ],
)
def test_a_push_is_one_if_balance_is_lost_by_it(pushed: float, lost: float, is_seen: bool, known: str) -> None:
    time = np.arange(3000) * 1e-3
    velocity = np.zeros((3000, 3))
    velocity[:, 0] = np.clip(time - pushed, 0.0, 0.2) * 8.0
    tilt = np.where(time < lost, 0.0, 0.1)
    zero = np.zeros(3000)
    columns = {
        "base_position": np.ones((3000, 3)),
        "base_quaternion": np.stack([np.cos(tilt / 2), zero, np.sin(tilt / 2), zero], axis=1),
        "base_velocity": velocity,
        "torque": np.zeros((3000, 1)),
        "foot_force": np.zeros((3000, 2)),
    }
    log: Any = SimpleNamespace(cycles=lambda *_: Cycles(time, columns, {}, 0))
    motion = Motion(log, 0.0, 3.0)
    assert motion.lost == pytest.approx(lost if lost > 0.5 else 0.0, abs=0.002)
    push = motion.push()
    assert (push is not None) == is_seen
    if push is not None:
        assert push.begin == pytest.approx(pushed, abs=0.02)
    asked = (pushed, "push", ("torso", (50.0, 0.0, 0.0), 0.2))
    history: Any = SimpleNamespace(
        setup={"robot": {"mass": 30.0}}, log=SimpleNamespace(news_of=lambda _: [(pushed, "input", asked)])
    )
    found = hardest_push(history, motion, 0.0, 3.0)
    assert ("" if found is None else "late" if found.late else "in time") == known
    if found is not None:
        assert found.what == f"it was pushed forward with 50 N at {pushed:.3f} s"
        assert str(found) == f"50 N forward for 0.2 s, from {pushed:.3f} s on"


def test_a_push_that_came_too_late_is_not_told_for_a_weaker_one_before() -> None:
    asked = [
        (time, "push", ("torso", (force, 0.0, 0.0), 0.2)) for time, force in ((1.5, 40.0), (1.6, 50.0), (1.9, 90.0))
    ]
    history: Any = SimpleNamespace(
        setup={"robot": {"mass": 30.0}}, log=SimpleNamespace(news_of=lambda _: [(of[0], "input", of) for of in asked])
    )
    motion: Any = SimpleNamespace(is_late=lambda at: at > 1.7, may_explain=lambda _: True, heading=lambda _: 0.0)
    found = hardest_push(history, motion, 0.0, 3.0)
    assert found is not None and found.force == 50.0


@pytest.mark.trials
@pytest.mark.parametrize(("force", "direction"), [((400.0, 0.0, 0.0), "forward"), ((0.0, 400.0, 0.0), "to the left")])
def test_the_direction_of_a_push_is_as_the_robot_sees_it(
    play: Play, force: tuple[float, float, float], direction: str
) -> None:
    found = hbt.explain(play("stand", duration=3.0, at=0.5, do=lambda session: session.push(force, 0.2)))
    assert f"it was pushed {direction} with 400 N at 0.500 s" in found.headline
    push = Motion(read_flight(found.recording), 0.0, found.time or 0.0).push()
    assert push is not None
    assert push.direction == direction


def test_a_moment_tells_node_command_percepts_and_joints(seen: Path) -> None:
    found = hbt.explain(seen, at=0.3)
    assert found.headline == "at 0.300 s: 'approach' ran, mode run"
    assert found.place.startswith("trees/doubtful.yaml:4:")
    rows = dict(found.rows)
    assert rows["command"].startswith("#14: 'approach': ")
    assert rows["percepts"].startswith("target seen ")
    assert [joint["load"] for joint in found.data["joints"]] == sorted(
        (joint["load"] for joint in found.data["joints"]), reverse=True
    )
    assert len(found.data["joints"]) == len(read_flight(seen).setup["robot"]["joints"])


def test_a_moment_tells_when_its_node_said_what_it_says(seen: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = read_flight(seen)
    place = History(log).place("doubtful/emergency_stop/watchdog/reactive_sequence/approach")
    node = f"doubtful/emergency_stop/watchdog/reactive_sequence/approach  {place}, since 0.00 s"
    began, later = (dict(hbt.explain(seen, at=at).rows)["nodes"] for at in (0.0, 0.3))
    assert re.fullmatch(re.escape(node) + r"; at first: 1\.\d+ m to go to target", began)
    assert later.startswith(began)
    assert re.fullmatch(r"; by then: target distance 1\.\d+ m, bearing error .* deg", later.removeprefix(began))
    monkeypatch.setattr(History, "acting", lambda _history, _time: [Change(0.0, "doubtful/other", "RUNNING", "")])
    assert dict(moment_explained(History(log), 0.3).rows)["nodes"] == "doubtful/other  , since 0.00 s"


def test_of_a_decision_that_died_only_its_last_tick_is_told(seen: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = read_flight(seen)
    ticks, news_of = log.ticks, log.news_of
    monkeypatch.setattr(log, "ticks", lambda begin, end: ticks(begin, min(end, 0.1)))
    monkeypatch.setattr(log, "news_of", lambda *kinds, **_: (n for n in news_of(*kinds, end=0.1) if n.kind != "end"))
    history = History(log)
    told = "decision's last tick was at 0.100 s, in which 'approach' ran, mode run"
    assert moment_explained(history, 0.3).headline == f"at 0.300 s: {told}"
    assert moment_explained(history, 0.15).headline == "at 0.150 s: 'approach' ran, mode run"
    assert life_explained(history, "approach").headline.endswith("and still ran in decision's last tick, at 0.100 s")


def test_percepts_of_a_moment_are_those_of_that_time(seen: Path) -> None:
    before, after = (hbt.explain(seen, at=at).data["percepts"][0] for at in (0.3, 0.4))
    assert before["confidence"] > 0.8
    assert after["confidence"] < 0.2


def test_the_percepts_that_are_told_are_those_of_the_reason_and_how_many_more(
    seen: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = read_flight(seen)
    names = ["target", "a", "b", "c", "box 2"]
    percepts = [Percept(name, 0.3, np.array([1.0, 0.0, 0.0]), 0.9) for name in names]
    monkeypatch.setattr(log, "seen_before", lambda _time: iter(percepts))
    rows = sight_rows(History(log), 0.3, "no way to target: box 2 is in the way")
    assert [(name, text.split(" seen")[0]) for name, text in rows] == [
        ("percepts", "box 2"),
        ("", "target"),
        ("", "a"),
        ("", "and 2 more"),
    ]


def test_the_life_of_a_node(seen: Path) -> None:
    found = hbt.explain(seen, node="approach")
    assert found.headline.startswith("'approach' ran once from 0.000 s to 0.400 s: was halted: preempted by")
    (life,) = found.data["lives"]
    assert [name for name, _, _ in life["results"]] == ["target_distance", "bearing_error"]
    rows = dict(found.rows)
    assert "base to" in rows["first"] and "base to" in rows["at last"]
    assert rows["type"] == "approach, target: target"


@pytest.mark.parametrize("gone", [False, True])
def test_a_node_is_told_as_it_was_in_the_tree_in_which_it_ran(seen: Path, gone: bool) -> None:
    log = read_flight(seen)
    edited = copy.deepcopy(log.setup["tree"])
    for node in edited["nodes"]:
        node |= {"type": "wait", "kind": "action", "place": "new.yaml:1:1"}
        node["path"] += "/new" * gone
    log.news.append(News(0.4, "tree", edited))  # in the tick in which it was halted
    found = life_explained(History(log), "approach")
    rows = dict(found.rows)
    assert rows["type"] == "approach, target: target"
    assert found.place.startswith("trees/doubtful.yaml:") and found.place in rows["node"]
    assert {row["type"] for row in Happened(log).nodes if row["name"] == "approach"} == {"approach"}


def test_a_node_that_never_had_its_turn(play: Play) -> None:
    found = hbt.explain(play("waits_when_lost", duration=0.1), node="blind")
    assert found.headline == "'blind' never had its turn"
    assert found.time is None


def test_nodes_of_one_name_are_told_together(seen: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    history = History(read_flight(seen))
    paths = [node["path"] for node in history.log.setup["tree"]["nodes"]][:2]
    monkeypatch.setattr(history, "matching", lambda _name: paths)
    assert life_explained(history, "wait").headline.startswith("'wait' (2 nodes) ran 2 times, the last time ")


def test_a_node_that_was_halted_in_its_first_tick_had_its_turn(seen: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = read_flight(seen)
    path = next(node["path"] for node in log.setup["tree"]["nodes"] if node["path"].endswith("/approach"))
    told = [News(1.0, "node", [path, "INVALID", said]) for said in ("halted: 'parallel' failed", "")]
    monkeypatch.setattr(log, "news_of", lambda *kinds, **_: told if "node" in kinds else [])
    found = life_explained(History(log), "approach")
    assert found.headline == "'approach' was asked once at 1.000 s: was halted: 'parallel' failed"


def test_the_extremes_of_a_joint_are_those_of_all_servo_cycles(fallen: Path) -> None:
    log = read_flight(fallen)
    found = hbt.explain(fallen, joint="right_knee")
    number = log.setup["robot"]["joints"].index("right_knee")
    cycles = log.cycles()
    for name in ("position", "torque"):
        values = cycles.columns[name][:, number]
        extremes = found.data["extremes"][name]
        assert (extremes["least"], extremes["most"]) == (values.min(), values.max())
        assert extremes["most_at"] == cycles.time[values.argmax()]
    assert found.data["limits"]["torque"] == 150
    assert found.data["at_torque_limit"]
    assert "at its torque limit" in found.headline


def test_the_setup_has_the_limits_of_the_robot(fallen: Path) -> None:
    with Session("stand") as session:
        session.step()
        robot = session.engine.robot
    kept = read_flight(fallen).setup["robot"]
    assert kept["joints"] == list(robot.joint_names)
    np.testing.assert_array_equal(kept["limits"]["torque"], robot.torque_limit)
    np.testing.assert_array_equal(kept["limits"]["lower"], robot.lower)
    assert kept["mass"] == robot.mass


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--node", "aproach"], "did you mean 'approach'?"),
        (["--joint", "right_elbw"], "did you mean 'right_elbow'?"),
        (["--at", "99"], "valid: 0.001 to {until:.3f} s"),
        (["--at", "-1"], "must be a time, 0 or more, in s or with a unit"),
        (["--at", "1", "--node", "x"], "not allowed with argument"),
    ],
)
def test_a_wrong_name_or_time_is_answered(
    seen: Path, options: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        code = main(["explain", str(seen), *options])
    except SystemExit as end:
        code = end.code  # type: ignore[assignment]  # of another type in each round
    out, err = capsys.readouterr()
    assert (code, out) == (2, "")
    assert said.format(until=read_flight(seen).span[1]) in err


def test_the_newest_recording_is_explained(
    seen: Path, fallen: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["explain"]) == 2
    assert "no recording in 'runs'" in capsys.readouterr().err
    (tmp_path / "runs").mkdir()
    for file in (seen, fallen):
        (tmp_path / "runs" / file.name).write_bytes(file.read_bytes())
    assert main(["explain", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["kind"] == "push"
    assert told["recording"] == f"runs/{fallen.name}"
    assert told["headline"] == hbt.explain(fallen).headline


def test_what_is_no_recording_is_answered(tmp_path: Path) -> None:
    other = tmp_path / "other.rrd"
    other.write_text("nothing")
    for path in (other, tmp_path / "missing.rrd"):
        with pytest.raises(hbt.UserError, match="no recording that can be read"):
            hbt.explain(path)
    with pytest.raises(hbt.UserError, match="only one of"):
        hbt.explain(other, at=1.0, node="x")


@pytest.mark.parametrize(
    ("tree", "headline"),
    [
        ("wait", r"the run succeeded at 0\.7\d\d s, after an emergency stop at 0\.100 s for 0\.40 s: pause: waited"),
        ("walk", r"the emergency stop was raised at 0\.100 s .*; the robot went on at 0\.500 s; the run was ended .*"),
    ],
)
def test_a_stop_from_which_the_run_recovered_is_told_with_how_long_it_lasted(
    play: Play, tree: str, headline: str
) -> None:
    def stop_for_a_while(session: Session) -> None:
        session.raise_estop("a hand on the button", source="keyboard")
        session.run_until(0.48)
        session.request_reset(source="keyboard")

    found = hbt.explain(play(tree, at=0.1, do=stop_for_a_while, on_estop="wait"))
    assert re.fullmatch(headline, found.headline), found.headline
    stops = [text for name, text in found.rows if name == "stops"]
    assert stops == ["0.100 s emergency stop for 0.40 s: a hand on the button (keyboard)"] * (found.kind == "success")


def test_what_would_help_names_the_node_and_the_recording(play: Play) -> None:
    late = play("late")
    commands = [text for _, text in hbt.explain(late).after if "explain --node" in text]
    assert commands == [f"humanoid-bt explain --node walk {late} shows what it did"]
    assert hbt.explain(late, node="walk").headline.startswith("'walk' ran once")


def test_what_would_help_speaks_of_nothing_that_is_not_known() -> None:
    assert list(hints("sensor", {EXPLAIN_JOINT: ""})) == ["look at that sensor and its cable"]
    assert list(hints("sensor", {EXPLAIN_JOINT: "a command"}))[1:] == ["a command shows what it said"]


def test_of_a_run_without_trouble_nothing_else_is_told(play: Play) -> None:
    clean = hbt.explain(play("wait"))
    assert clean.kind == "success"
    assert clean.rows == []
