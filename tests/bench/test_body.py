"""Trials of a robot's body: what a seed draws, how they are judged, and that they are the same every time."""

from __future__ import annotations

import math
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from humanoid_bt import Conditions, Stage, UserError, Workspace
from humanoid_bt.bench.body import Withstood, chosen, measure_body
from humanoid_bt.bench.body_rows import ROWS, Row
from humanoid_bt.bench.body_trial import judged
from humanoid_bt.campaign.result import Cost, Result
from humanoid_bt.campaign.stage_trials import pushes
from humanoid_bt.campaign.trial import CONDITION, SET, Task, Trial
from humanoid_bt.campaign.workers import Done
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.messages import Gait
from humanoid_bt.files.workspace import builtin_root
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene
from humanoid_bt.plant.scene_config import SceneConfig
from tests.bench.test_realtime import alive, descendants

ROBOT = Workspace(builtin_root()).find_robot("humanoid").absolute()
SEEDS = range(200)


def row(name: str) -> Row:
    (found,) = chosen([name])
    return found


# ---- what is tried --------------------------------------------------------------------------------------------------


def test_a_seed_draws_the_same_goal_and_push_for_every_row() -> None:
    for seed in (0, 7):
        trials = [one.trial(0, "mine", seed) for one in ROWS if one.name not in ("straight", "metre", "odometry")]
        goals = {tuple(trial.part(SET).items()) for trial in trials if trial.part(SET)}
        sides = {tuple(push["push"]["force"]) for trial in trials for push in pushes(trial)}
        assert len(goals) == 1
        assert len({round(math.atan2(y, x), 9) for x, y, _ in sides}) == 1
    assert row("goals").trial(0, "mine", 0).given != row("goals").trial(0, "mine", 1).given


def test_goals_lie_all_around_and_pushes_come_from_every_side() -> None:
    goals = [row("goals").trial(0, "mine", seed).part(SET) for seed in SEEDS]
    places = np.array([[goal["x"], goal["y"]] for goal in goals])
    distances, bearings = np.linalg.norm(places, axis=1), np.arctan2(places[:, 1], places[:, 0])
    forces = np.array([pushes(row("push-walking-150").trial(0, "mine", s))[0]["push"]["force"] for s in SEEDS])
    np.testing.assert_allclose(np.linalg.norm(forces, axis=1), 150)
    assert distances.min() > 0.5 and distances.max() < 3.0 and np.ptp(distances) > 2.3
    for angles in (bearings, [goal["heading"] for goal in goals], np.arctan2(forces[:, 1], forces[:, 0])):
        assert set(np.floor(np.array(angles) / (math.pi / 2)).astype(int)) == {-2, -1, 0, 1}  # quarters


def test_every_row_has_conditions_that_a_run_can_have_and_what_is_asked_of_it() -> None:
    assert len({one.name for one in ROWS}) == len(ROWS)
    different = {one.name: Conditions.of(one.trial(0, "mine", 3).part(CONDITION)).changed for one in ROWS}
    assert different["slope"].keys() == {"slope", "uphill"}
    assert abs(different["encoder"]["encoder_error"]) == pytest.approx(math.radians(0.5))
    pushed = {name for name in different if name.startswith("push-")}
    unchanged = {"goals", "fetch", "straight", "metre", "odometry", *pushed}
    assert {name for name, found in different.items() if not found} == unchanged
    bounds = {one.name: one.promise.bound for one in ROWS}
    assert bounds.pop("push-standing-200") == 90
    assert set(bounds.values()) == {95}


def test_what_is_more_than_it_may_be_is_no_success() -> None:
    odometry = row("odometry")
    good = Result("success", "there", values=dict.fromkeys(odometry.limits, 0.0), units={"heading_error": "rad"})
    assert odometry.judged(good) is good
    bad = odometry.judged(replace(good, values={**good.values, "heading_error": 0.1}))
    assert (bad.outcome, bad.reason) == ("failure", "heading error 5.7 deg, at most 1.5 deg")
    fallen = replace(bad, outcome="fell", reason="it fell")
    assert odometry.judged(fallen) is fallen
    goals = [odometry.trial(0, "r", seed).part(SET) for seed in SEEDS]
    assert all(math.hypot(goal["x"], goal["y"]) == pytest.approx(5) for goal in goals)


def test_encoders_are_off_to_both_sides() -> None:
    errors = [row("encoder").trial(0, "mine", seed).part(CONDITION)["encoder_error"] for seed in SEEDS]
    assert 60 < sum(error > 0 for error in errors) < 140


@pytest.mark.trials
def test_the_robot_is_walking_whenever_it_is_pushed_on_its_way() -> None:
    tree = row("goals").trial(0, "mine", 0).tree
    nearest = {"x": 0.5, "y": 0.0, "heading": 0.0}  # no goal is reached in fewer steps
    states = Stage(builtin_root(), scene="empty").run(tree, parameters=nearest, duration=2.5).states
    times = [pushes(row("push-walking-60").trial(0, "mine", seed))[0]["at"] for seed in SEEDS]
    assert {state.gait for state in states if min(times) <= state.time <= max(times)} == {Gait.STEP}


def test_rows_are_chosen_by_name_and_pattern_in_their_own_order() -> None:
    assert [one.name for one in chosen(["torso-*", "goals"])] == ["goals", "torso-2kg", "torso-5kg"]
    assert chosen([]) == list(ROWS)
    with pytest.raises(UserError, match=r"no row 'slop'[\s\S]*did you mean 'slope'"):
        chosen(["goals", "slop"])


# ---- how it is judged -----------------------------------------------------------------------------------------------


@pytest.fixture
def plant() -> MujocoPlant:
    """The robot at the origin, heading along x."""
    robot, start = load_robot(ROBOT)
    plant = MujocoPlant(robot, Scene(SceneConfig(format=1, name="empty"), 0))
    plant.place(start)
    return plant


def walked(x: float, y: float, heading: float) -> Trial:
    return Trial(0, "walk", str(ROBOT), "empty", 0, {"set.x": x, "set.y": y, "set.heading": heading})


@pytest.mark.parametrize(
    ("goal", "outcome"),
    [((0.05, -0.05, 0.1), "success"), ((0.08, -0.08, 0.0), "failure"), ((0.0, 0.0, -0.25), "failure")],
)
def test_a_goal_is_reached_where_the_robot_is_and_not_where_it_says(
    plant: MujocoPlant, goal: tuple[float, float, float], outcome: str
) -> None:
    result = judged(Result("success", "walk_to: 0 cm from it"), walked(*goal), plant)
    assert (result.outcome, result.fell) == (outcome, False)
    assert result.values["off"] == pytest.approx(math.hypot(*goal[:2]), abs=1e-3)
    assert result.values["turned"] == pytest.approx(abs(goal[2]), abs=1e-3)
    assert ("it says: it is 11 cm and 0 deg from there" in result.reason) == (goal[0] == 0.08)


def test_a_robot_that_lies_has_fallen_whatever_it_says(plant: MujocoPlant) -> None:
    lying = plant.data.qpos[:].copy()
    lying[2:7] = [0.2, math.cos(0.7), 0.0, math.sin(0.7), 0.0]
    plant.place(lying)
    for said in ("success", "unfinished"):
        result = judged(Result(said, ""), walked(0, 0, 0), plant)
        assert (result.outcome, result.fell) == ("fell", True)


def test_a_ball_is_fetched_when_its_tree_says_so(plant: MujocoPlant) -> None:
    fetched = row("fetch").trial(0, str(ROBOT), 0)
    assert (fetched.tree, fetched.scene, fetched.part(SET)) == ("fetch", "random_target", {})
    assert judged(Result("success", "touched"), fetched, plant).succeeded
    assert judged(Result("unfinished", "time is up"), fetched, plant).outcome == "unfinished"


def test_a_robot_that_was_to_stand_has_done_so_unless_it_was_stopped(plant: MujocoPlant) -> None:
    stood = Trial(0, "stand", str(ROBOT), "empty", 0)
    assert judged(Result("unfinished", "time is up"), stood, plant).outcome == "success"
    assert judged(Result("stopped", "somebody"), stood, plant).outcome == "stopped"


# ---- the whole ------------------------------------------------------------------------------------------------------


def measured(rows: Sequence[str], workers: int, folder: Path | None = None) -> list[Withstood]:
    told: list[Withstood] = []
    recordings = None if folder is None else lambda one, seed, _: folder / f"{one.name}-{seed}.rrd"
    wanted = [row(name) for name in rows]
    found = list(measure_body(ROBOT, wanted, [1], workers=workers, progress=told.append, recordings=recordings))
    assert [(one.row.name, len(one.trials)) for one in found] == [(name, 1) for name in rows]
    assert sorted(one.row.name for one in told) == sorted(rows)
    return found


@pytest.mark.trials
def test_trials_are_the_same_in_any_number_of_processes_and_recorded_or_not(tmp_path: Path) -> None:
    rows = ["push-standing-60", "push-standing-200"]
    one, two, (again,) = measured(rows, 1), measured(rows, 2), measured(rows[1:], 1, tmp_path)
    assert [found.to_dict() for found in one] == [found.to_dict() for found in two]
    assert again.to_dict() == one[1].to_dict()
    assert [path.name for path in tmp_path.iterdir()] == ["push-standing-200-1.rrd"]
    gentle, hard = one
    assert (gentle.good.count, gentle.on_feet.count, gentle.verdict, gentle.failed) == (1, 1, "ok", [])
    assert gentle.trials[0].result.trace != hard.trials[0].result.trace
    assert hard.good.count == hard.on_feet.count == 1 - len(hard.failed)


@pytest.mark.parametrize(("name", "good"), [("goals", "reached"), ("push-standing-60", "withstood")])
def test_what_was_withstood_and_who_stayed_on_their_feet_are_two_counts(name: str, good: str) -> None:
    one = row(name)
    results = [Result("success", ""), Result("failure", "drifted"), Result("fell", "", fell=True)]
    trials = [Done(Task(one.trial(seed, "mine", seed), ""), result, Cost()) for seed, result in enumerate(results)]
    told = Withstood(one, trials).to_dict()
    assert (told[good], told["on_feet"], told["of"]) == (1, 2, 3)


@pytest.mark.trials
def test_interrupting_it_tells_what_is_known_and_ends_what_it_started() -> None:
    command = [sys.executable, "-m", "humanoid_bt", "bench", "--body", "--only", "push-standing-60", "goals"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as bench:
        assert bench.stdout is not None
        assert "seeds 0 to 19" in bench.stdout.readline()
        deadline = time.monotonic() + 60
        while not (children := set(descendants(bench.pid))) and time.monotonic() < deadline:
            time.sleep(0.01)
        bench.send_signal(signal.SIGINT)
        assert bench.wait(30) == 130
    assert children
    assert not alive(children)
