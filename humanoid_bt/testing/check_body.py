"""``check_body``: a body tried against what control asks of every body, in one call."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np

from humanoid_bt.control.body.body import Body, Setpoint
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.control.controller import Controller
from humanoid_bt.core.clock import DECISION_PERIOD, SERVO_PERIOD, cycles
from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import Array, BaseTarget, Command, Estimate, Mode, State, Target
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene
from humanoid_bt.plant.scene_config import SceneConfig
from humanoid_bt.robot.config import Walk
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.testing.conformance import Conformance, RuleOutcome

_STAND, _STILL, _TURNS = 4.0, 0.05, 0.1  # s; m and rad that it may drift meanwhile: walkers turn slowly as they stand
_GOAL = (0.8, 0.3, 0.5)  # m, m, rad: where it is to walk
_WALK, _NEAR, _TURNED = 20.0, 0.06, 0.12  # s; m and rad from there that count as arrived
_FAR = (3.0, 0.0, 0.0)
_SET_OUT, _STOP, _HOLD = 2.0, 4.0, 4.0  # s
_BLOW, _BLOW_TIME, _FALL = 1500.0, 0.2, 4.0  # N, s, s

Targets = Mapping[str, Target]
_Outcome = tuple[bool, str]
"""Whether a rule is kept, and what shows it."""


def check_body(robot: Path, walk: Walk | None = None) -> Conformance:
    """Try a robot's body on physics: it stands, walks, stops, holds, comes back after a fall, and does so each time.

    A body that fails meanwhile keeps no rule, nor does one that needs too long for its updates.

    Args:
        robot: the ``robot.yaml``.
        walk: what walks and balances; what ``robot.yaml`` says if None.

    Raises:
        UserError: the robot has mistakes.
    """
    model, start = load_robot(robot, walk)
    rules: list[RuleOutcome] = []
    try:
        rules += _tried(_Trial(model, start))
    except UserError as error:
        if any(problem.code != "broken-body" for problem in error.problems):
            raise
        rules.append(RuleOutcome("begins", False, str(error)))
    return Conformance(f"the body of {model.config.name}", tuple(rules))


class _Trial:
    """A robot on an empty floor under control, commanded as decision would.

    Attributes:
        period: of the body [s].
        spent: on each of its updates, on the wall clock [s].
        failed: when and why the body failed since this was emptied last, "" if it did not.
    """

    def __init__(self, robot: RobotModel, start: Array) -> None:
        self.robot, self._start = robot, start
        self.plant = MujocoPlant(self.robot, Scene(SceneConfig(format=1, name="empty"), seed=0))
        self.plant.place(self._start)
        self.controller = Controller(self.robot, self.plant)
        self.spent: list[float] = []
        self.failed = ""
        self.period = self.controller.body.period
        self._time(self.controller.body)
        self._sequence = 0

    def _time(self, body: Body) -> None:
        update = body.update

        def timed(estimate: Estimate, targets: Targets, hold: bool) -> Setpoint:
            began = perf_counter()
            setpoint = update(estimate, targets, hold)
            self.spent.append(perf_counter() - began)
            return setpoint

        body.update = timed  # type: ignore[method-assign]  # only of this one

    def begin(self) -> None:
        """Stand at the start."""
        self.plant.place(self._start)
        self.controller.reset()
        self._sequence = 0

    def run(self, seconds: float, targets: Targets | None, until: Callable[[State], bool] | None = None) -> bool:
        """Run with these targets, or with a silent decision; return whether ``until`` came true."""
        for _ in range(round(seconds / DECISION_PERIOD)):
            if targets is not None:
                self._sequence += 1
                self.controller.submit(Command(self._sequence, self.controller.cycle * SERVO_PERIOD, targets))
            self.controller.run_cycles(cycles(DECISION_PERIOD))
            if failed := self.controller.body_failed:
                self.failed = failed
            if until is not None and until(self.controller.state()):
                return True
        return False

    @property
    def state(self) -> State:
        return self.controller.state()

    @property
    def fallen(self) -> bool:
        return self.controller.supervisor.mode is Mode.DAMP


def _tried(trial: _Trial) -> Iterator[RuleOutcome]:
    yield _judged("stands", trial, _stands)
    first = trial.plant.data.qpos.copy()
    yield _judged("walks", trial, _walks)
    yield _judged("stops", trial, _stops)
    yield _judged("holds", trial, _holds)
    yield _judged("comes back", trial, _comes_back)
    yield _judged("same", trial, partial(_same, first))
    if trial.spent:
        yield _in_time(trial)


def _judged(name: str, trial: _Trial, rule: Callable[[_Trial], _Outcome]) -> RuleOutcome:
    """Return what came of a rule; the body does not keep it if it failed, and another one took over."""
    trial.failed = ""
    try:
        outcome = rule(trial)
    except UserError as error:  # the body did not begin anew
        return RuleOutcome(name, False, str(error))
    passed, shown = outcome
    if trial.failed:
        return RuleOutcome(name, False, trial.failed)
    if not passed and (stops := trial.controller.supervisor.stops):
        shown += f"; stopped after {stops[0].time:.1f} s: {stops[0].reason}"
    return RuleOutcome(name, passed, shown)


def _same(first: Array, trial: _Trial) -> _Outcome:
    trial.begin()
    trial.run(_STAND, {})
    off = float(np.abs(trial.plant.data.qpos - first).max())
    return off == 0, f"run again, it differs by {off:.1e}"


def _in_time(trial: _Trial) -> RuleOutcome:
    took, period = median(trial.spent), trial.period
    shown = f"an update takes {took * 1000:.1f} ms, it may take half of the period of {period * 1000:g} ms"
    return RuleOutcome("in time", took <= period / 2, shown)


def _stands(trial: _Trial) -> _Outcome:
    trial.run(_STAND, {})
    off, turned = _off(trial.state, (0.0, 0.0, 0.0))
    good = not trial.fallen and trial.state.base_settled and off < _STILL and turned < _TURNS
    return good, f"{_how(trial)} after {_STAND:g} s, {off * 100:.1f} cm and {turned:.2f} rad from there"


def _walks(trial: _Trial) -> _Outcome:
    there = trial.run(_WALK, _to(_GOAL), lambda state: (state.base_settled and _arrived(state)) or trial.fallen)
    off, turned = _off(trial.state, _GOAL)
    shown = f"{_how(trial)} after {trial.state.time - _STAND:.1f} s, {off * 100:.1f} cm and {turned:.2f} rad away"
    return there and not trial.fallen, shown


def _stops(trial: _Trial) -> _Outcome:
    trial.begin()
    trial.run(_SET_OUT, _to(_FAR))
    walked, began = not trial.state.base_settled, trial.state.time
    stood = trial.run(_STOP, None, lambda state: state.base_settled)
    good = walked and stood and trial.state.mode is Mode.PROTECTIVE_STOP
    return good, f"{_how(trial)} {trial.state.time - began:.1f} s after decision's last command"


def _holds(trial: _Trial) -> _Outcome:
    x, y, heading = trial.state.stance.tolist()
    trial.run(_HOLD, None)
    off, turned = _off(trial.state, (x, y, heading))
    good = not trial.fallen and off < _STILL
    return good, f"{_how(trial)} after {_HOLD:g} s of it, {off * 100:.1f} cm and {turned:.2f} rad away"


def _comes_back(trial: _Trial) -> _Outcome:
    trial.plant.push(trial.robot.config.torso, np.array([0.0, _BLOW, 0.0]), _BLOW_TIME)
    fell = trial.run(_FALL, {}, lambda _: trial.fallen)
    if not fell:
        return False, f"{_BLOW:g} N for {_BLOW_TIME:g} s did not make it fall"
    trial.begin()
    good, shown = _stands(trial)
    return good, f"after a fall: {shown}"


def _to(place: tuple[float, float, float]) -> Targets:
    return {"base": BaseTarget(np.array(place[:2]), place[2])}


def _arrived(state: State) -> bool:
    off, turned = _off(state, _GOAL)
    return off < _NEAR and turned < _TURNED


def _off(state: State, place: tuple[float, float, float]) -> tuple[float, float]:
    """Return how far the stance is from a place [m], and how far it is turned from it [rad]."""
    stance: Array = state.stance
    return math.dist(stance[:2], place[:2]), abs(math.remainder(stance.item(2) - place[2], math.tau))


def _how(trial: _Trial) -> str:
    if trial.fallen:
        return "fallen"
    return "at rest" if trial.state.base_settled else "not at rest"
