"""A trial of a body: run on a stage, and judged by where the robot is, not by where it takes itself to be."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from humanoid_bt.bench.body_rows import BODY, STAND
from humanoid_bt.bench.gait import UNITS, GaitWatch
from humanoid_bt.campaign.result import SUCCESS, Result
from humanoid_bt.campaign.stage_trials import pushes, result_of
from humanoid_bt.campaign.trial import CONDITION, SET, Task, Trial
from humanoid_bt.campaign.work import Answer, Run
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.geometry import rotation_matrix
from humanoid_bt.core.messages import SIDES, Array
from humanoid_bt.core.odometry import odometry_error
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.robot.config import Walk
from humanoid_bt.robot.model import sole_site
from humanoid_bt.testing.stage import Stage
from humanoid_bt.testing.tree_run import TreeRun

NEAR, TURNED = 0.10, 0.20
"""A goal is reached when the middle between the feet is this near [m], and turned this little from it [rad]."""

_FELL, _ASTRAY = "fell", "failure"


def make() -> Run:
    """Return what runs trials in this process."""
    stages: dict[tuple[str, str, Walk | None], Stage] = {}

    def run(task: Task) -> Answer:
        trial, began = task.trial, time.monotonic()
        key = trial.robot, trial.scene, trial.given.get(BODY)
        if key not in stages:
            stages[key] = Stage(Workspace(builtin_root()), trial.robot, trial.scene, body=key[-1])
        stage = stages[key]
        goal = trial.part(SET)
        watch = GaitWatch(lambda: stage.plant, math.hypot(goal["x"], goal["y"])) if goal else None
        found = stage.run(
            trial.tree,
            seed=trial.seed,
            parameters=trial.part(SET),
            duration=trial.duration,
            script=pushes(trial),
            conditions=trial.part(CONDITION),
            record=task.recording or None,
            watchers=[watch] if watch else [],
        )
        assert stage.plant is not None
        result = judged(result_of(found), trial, stage.plant)
        result = _with_odometry(result, found)
        if watch:
            result = replace(result, values={**result.values, **watch.values}, units={**result.units, **UNITS})
        return result, None, time.monotonic() - began

    return run


@dataclass(frozen=True)
class _Body:
    """Where a simulated robot really is.

    Attributes:
        stance: middle between the feet and where they face, shape (3,): x, y [m], yaw [rad], world frame.
        tilt: of the base [rad].
        height: of the base above the feet [m].
    """

    stance: Array
    tilt: float
    height: float

    @classmethod
    def of(cls, plant: MujocoPlant) -> _Body:
        soles = [plant.data.site(sole_site(side)) for side in SIDES]
        middle = np.mean([sole.xpos for sole in soles], axis=0)
        ahead = np.sum([sole.xmat.reshape(3, 3)[:, 0] for sole in soles], axis=0)
        stance = np.array([*middle[:2], math.atan2(ahead[1], ahead[0])])
        up = rotation_matrix(plant.data.qpos[3:7])[2, 2]
        return cls(stance, math.acos(max(-1.0, min(1.0, float(up)))), float(plant.data.qpos[2] - middle[2]))


def _with_odometry(result: Result, run: TreeRun) -> Result:
    """Add how wrong the robot was about itself.

    Position in the end, as a share of the way from its start; heading in the end; velocity, root of the mean square,
    with the velocity from tick to tick for the true one.
    """
    states, truths = run.states, run.truths
    off, turned = odometry_error(states[-1], truths[-1])
    way = math.dist(truths[-1].base_position[:2], truths[0].base_position[:2])
    places = np.array([truth.base_position for truth in truths])
    believed = np.array([state.base_linear_velocity for state in states])
    wrong = (believed[1:] + believed[:-1]) / 2 - np.diff(places, axis=0) / DECISION_PERIOD
    velocity = math.sqrt(float(np.mean(np.sum(wrong[:, :2] ** 2, axis=1))))
    values = {"drift": off / way if way else 0.0, "heading_error": turned, "velocity_error": velocity}
    units = {"heading_error": "rad", "velocity_error": "m/s"}
    return replace(result, values={**result.values, **values}, units={**result.units, **units})


def judged(result: Result, trial: Trial, plant: MujocoPlant) -> Result:
    """Return what came of a trial: ``success`` if the robot has done what it was to do, and is on its feet.

    Args:
        result: what its run said.
        trial: it.
        plant: as the run has left it.
    """
    body, goal, fall = _Body.of(plant), trial.part(SET), plant.robot.config.fall
    _, start = load_robot(Path(trial.robot))
    if result.fell or body.tilt > fall.tilt or body.height < fall.height * start[2]:
        return replace(result, outcome=_FELL, fell=True)
    if not goal:  # it was to stand, which never ends, or to touch a ball
        stood = trial.tree == STAND and result.outcome == "unfinished"
        return replace(result, outcome=SUCCESS) if stood else result
    off = math.hypot(goal["x"] - body.stance[0], goal["y"] - body.stance[1])
    turned = abs(math.remainder(goal["heading"] - body.stance[2], math.tau))
    result = replace(result, values={"off": off, "turned": turned}, units={"off": "m", "turned": "rad"})
    if result.succeeded and (off > NEAR or turned > TURNED):
        where = f"it is {off * 100:.0f} cm and {math.degrees(turned):.0f} deg from there"
        return replace(result, outcome=_ASTRAY, reason=f"{result.reason}, it says: {where}")
    return result
