"""A hand that moves into a wall, many times; and how often a robot that touches nothing takes it that something does.

python -m tests.safety.contact_trials --walls 100 --runs 50
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.control.controller import Controller
from humanoid_bt.control.supervisor import Supervisor
from humanoid_bt.core.clock import DECISION_PERIOD, ESTIMATE_PERIOD, cycles
from humanoid_bt.core.messages import SIDES, TORSO, Array, Estimate, HandTarget, Mode, Side
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene
from humanoid_bt.plant.scene_config import ObjectConfig, SceneConfig
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.testing.stage import Stage
from tests.control.control_rig import ControlRig

SPEED = 0.3
"""Of the hand [m/s]."""

PEAK, LATER, LATER_AFTER = 120.0, 30.0, 0.3
"""Force on the wall that is promised: the largest [N], and the largest from a time [s] after the first touch on [N]."""

_THICK = 0.1  # m
_AWAY, _BEYOND = 0.10, 0.25  # m from the palm to the wall when it begins, and from the wall to the last target
_THERE, _PUSHES, _AFTERWARD = 3.0, 2.0, 10.0  # s; the arm is at home before the end
_LEARN = 6.0  # s instead of the first, in which the robot learns what its hands carry
_PALM = 0.05  # m that a hand reaches farther than its palm, at most
_TRULY = 0.2  # s before an alarm in which the arm must have touched something


class Wall:
    """The built-in humanoid in front of a wall whose place can be chosen.

    Args:
        hand_payload: what each hand carries [kg].

    Attributes:
        rig: the robot with its controller.
        loaded: whether the hands carry something.
        force: with which anything of the robot pushes the wall now [N].
    """

    def __init__(self, hand_payload: float = 0.0) -> None:
        self.loaded = hand_payload > 0
        robot, start = load_robot(Path(Workspace(builtin_root()).find_robot("humanoid")))
        wall = ObjectConfig(shape="box", size=[_THICK, 2.0, 2.4], position=(5.0, 0.0, 1.3), solid=True)
        self.rig = ControlRig(robot, start)
        self.rig.plant = MujocoPlant(robot, Scene(SceneConfig(format=1, name="wall", objects={"wall": wall}), 0))
        self.rig.plant.alter(hand_payload=hand_payload)
        self.rig.plant.place(start)
        self.rig.controller = Controller(robot, self.rig.plant)
        model = self.rig.plant.model
        self._body = model.body("object_wall").id
        self._number = np.zeros(6)
        self.geoms = set(np.flatnonzero(model.geom_bodyid == self._body).tolist())
        self._arms = {side: _geoms_of_arm(robot, model, side) for side in SIDES}

    def reset(self, distance: float, seed: int) -> None:
        """Stand at the origin, with the wall's face this far ahead [m]; the seed is of the sensors' noise."""
        plant = self.rig.plant
        plant.scene.seed = seed
        self.rig.reset()
        plant.model.body_pos[self._body, 0] = distance + _THICK / 2

    @property
    def force(self) -> float:
        plant, whole = self.rig.plant, 0.0
        contact = plant.data.contact
        for number, pair in enumerate(contact.geom[: plant.data.ncon].tolist()):
            if self.geoms.intersection(pair):
                mujoco.mj_contactForce(plant.model, plant.data, number, self._number)
                whole += float(np.linalg.norm(self._number[:3]))
        return whole

    def touches(self, side: Side) -> bool:
        """Return whether an arm touches the wall."""
        contact, data = self.rig.plant.data.contact, self.rig.plant.data
        arm = self._arms[side]
        return any(
            self.geoms.intersection(pair) and arm.intersection(pair) for pair in contact.geom[: data.ncon].tolist()
        )


def _geoms_of_arm(robot: RobotModel, model: mujoco.MjModel, side: Side) -> set[int]:
    bodies = {robot.model.body(robot.model.jnt_bodyid[joint + 1]).name for joint in robot.arm_joints(side)}
    bodies.add(robot.config.hands[side].body)
    return {geom for geom in range(model.ngeom) if model.body(model.geom_bodyid[geom]).name in bodies}


@dataclass(frozen=True)
class Outcome:
    """What came of a hand that moved into a wall.

    Attributes:
        peak: largest force on the wall [N].
        later: largest force from a while after the first touch on, until the arm has gone home past the wall, and on
            the way to where the hand is sent into the wall from, which may graze it [N].
        yields: time from the first touch until the arm yields [s], inf if it does not.
        early: whether an arm yielded before anything touched it.
        stands: whether the robot stands at rest in the end, was never stopped, and its arm is at home and stiff.
    """

    peak: float
    later: float
    yields: float
    early: bool
    stands: bool

    @property
    def good(self) -> bool:
        """Whether it is as promised."""
        return 0 < self.peak <= PEAK and self.later <= LATER and self.stands and not self.early


def into_wall(wall: Wall, seed: int) -> Outcome:
    """Move a hand into the wall, and on; then let go of it, and wait until it is at home."""
    numbers = np.random.default_rng(seed)
    side: Side = SIDES[seed % 2]
    face, aside, height = (float(numbers.uniform(*ends)) for ends in ((0.30, 0.40), (0.08, 0.30), (0.65, 1.1)))
    wall.reset(face, seed)
    rig = wall.rig
    supervisor = rig.controller.supervisor
    forces: list[float] = []
    touches: list[bool] = []
    yields: list[bool] = []
    modes: set[Mode] = set()

    def look() -> None:
        forces.append(wall.force)
        touches.append(wall.touches(side))
        yields.append(bool(supervisor.touch.yielding))
        modes.add(supervisor.mode)

    def go(x: float, duration: float) -> None:
        palm = HandTarget(np.array([x, aside if side == "left" else -aside, height]))
        rig.run(duration, {f"{side}_hand": palm}, cycle=look)

    begin = face - _PALM - _AWAY
    go(begin, _LEARN if wall.loaded else _THERE)
    sent = len(forces)
    for tick in range(round(_PUSHES / DECISION_PERIOD)):
        go(min(begin + SPEED * DECISION_PERIOD * tick, face + _BEYOND), DECISION_PERIOD)
    rig.run(_AFTERWARD, {}, cycle=look)
    touched = np.flatnonzero(touches[sent:])
    if not len(touched):
        return Outcome(0.0, 0.0, np.inf, any(yields), stands=False)
    first = sent + int(touched[0])
    after = np.flatnonzero(yields[first:])
    at_home = not yields[-1] and rig.controller.body.arms.stiffness is None
    stands = modes == {Mode.RUN} and rig.state.base_settled and at_home
    return Outcome(
        peak=max(forces),
        later=max(forces[:sent] + forces[first + cycles(LATER_AFTER) :]),
        yields=after[0] * 1e-3 if len(after) else np.inf,
        early=any(yields[:first]),
        stands=stands,
    )


@dataclass(frozen=True)
class Alarms:
    """What a robot took for contact in a run.

    Attributes:
        outcome: of its tree.
        true: arms that yielded, and torsos that were touched, while something did touch them.
        false: while nothing did.
        largest: group of links -> largest force that it seemed to feel [N].
    """

    outcome: str
    true: list[str]
    false: list[str]
    largest: dict[str, float]


class _Listener:
    """Stands between the observer and the supervisor, and looks at what really touches."""

    def __init__(self, stage: Stage, robot: RobotModel) -> None:
        self._stage, self._robot = stage, robot
        self._feel = Supervisor.feel
        model = robot.model
        self._group = {
            model.body(model.jnt_bodyid[joint + 1]).name: f"{side}_arm"
            for side in SIDES
            for joint in robot.arm_joints(side)
        }
        self.begin()

    def begin(self) -> None:
        self.alarms = Alarms("", [], [], {})
        self._last: dict[str, int] = {}
        self._known: set[str] = set()
        self._periods = 0

    def feel(self, supervisor: Supervisor, forces: dict[str, Array], estimate: Estimate) -> None:
        self._feel(supervisor, forces, estimate)
        self._periods += 1
        self._look()
        for group, force in forces.items():
            self.alarms.largest[group] = max(self.alarms.largest.get(group, 0.0), float(np.linalg.norm(force)))
        contacts = supervisor.touch.contacts
        now = {group for group, contact in contacts.items() if contact.yields or group == TORSO}
        for group in now - self._known:
            recent = self._periods - self._last.get(group, -(10**9)) < cycles(_TRULY) / cycles(ESTIMATE_PERIOD)
            (self.alarms.true if recent else self.alarms.false).append(group)
        self._known = now

    def _look(self) -> None:
        plant = self._stage.plant
        if plant is None:
            return
        model, data = plant.model, plant.data
        for pair in model.geom_bodyid[data.contact.geom[: data.ncon]].tolist():
            for name in (model.body(body).name for body in pair):
                if name in self._group:
                    self._last[self._group[name]] = self._periods
                elif name == self._robot.config.torso:
                    self._last[TORSO] = self._periods


def alarms(seeds: range, conditions: dict[str, float]) -> Iterator[Alarms]:
    """Run ``fetch`` in ``random_target`` with some seeds, and yield what the robot felt."""
    stage = Stage(Workspace(builtin_root()), "humanoid", "random_target")
    robot, _ = load_robot(Path(Workspace(builtin_root()).find_robot("humanoid")))
    listener = _Listener(stage, robot)
    before = Supervisor.feel

    def feel(supervisor: Supervisor, forces: dict[str, Array], estimate: Estimate) -> None:
        listener.feel(supervisor, forces, estimate)

    Supervisor.feel = feel  # type: ignore[method-assign,assignment]  # watched for a while
    try:
        for seed in seeds:
            listener.begin()
            run = stage.run("fetch", seed=seed, conditions=conditions, duration=60.0)
            yield Alarms(run.outcome, listener.alarms.true, listener.alarms.false, listener.alarms.largest)
    finally:
        Supervisor.feel = before  # type: ignore[method-assign]  # watched for a while


def _walls(seeds: range, hand_payload: float) -> bool:
    wall = Wall(hand_payload)
    outcomes = [into_wall(wall, seed) for seed in seeds]
    bad = [seed for seed, outcome in zip(seeds, outcomes, strict=True) if not outcome.good]
    sys.stdout.write(
        f"a hand at {SPEED:g} m/s into a wall: as promised in {len(seeds) - len(bad)} of {len(seeds)}; largest force "
        f"{max(outcome.peak for outcome in outcomes):.0f} N, {max(outcome.later for outcome in outcomes):.0f} N from "
        f"{LATER_AFTER:g} s on, "
        f"yields after {max(outcome.yields for outcome in outcomes) * 1000:.0f} ms at most; "
        f"alarms before: {sum(outcome.early for outcome in outcomes)}\n"
    )
    for seed in bad:
        sys.stdout.write(f"  seed {seed}: {outcomes[seeds.index(seed)]}\n")
    return not bad


def _alarms(seeds: range, conditions: dict[str, float]) -> bool:
    found: list[Alarms] = []
    for seed, one in zip(seeds, alarms(seeds, conditions), strict=True):
        found.append(one)
        felt = ", ".join(f"{group} {force:.0f} N" for group, force in one.largest.items())
        sys.stdout.write(f"  seed {seed}: {one.outcome}; false {one.false}, true {one.true}; felt {felt}\n")
        sys.stdout.flush()
    false = [seed for seed, one in zip(seeds, found, strict=True) if one.false]
    largest = {group: max(one.largest[group] for one in found) for group in found[0].largest}
    sys.stdout.write(
        f"fetch in random_target, {conditions or 'nothing in the hands'}: false alarms in {len(false)} of {len(seeds)} "
        f"({', '.join(map(str, false)) or 'none'}), true ones in {sum(bool(one.true) for one in found)}, succeeded "
        f"{sum(one.outcome == 'success' for one in found)}; largest forces felt: "
        + ", ".join(f"{group} {force:.1f} N" for group, force in largest.items())
        + "\n"
    )
    return not false


def main(arguments: list[str] | None = None) -> int:
    """Make the trials; return 0 if all of them were as promised."""
    parser = argparse.ArgumentParser(prog="python -m tests.safety.contact_trials", description=__doc__)
    parser.add_argument("--walls", type=int, default=100, help="hands into a wall (default: %(default)s)")
    parser.add_argument("--runs", type=int, default=50, help="runs of fetch that count alarms (default: %(default)s)")
    parser.add_argument("--first", type=int, default=0, help="seed of both to begin with (default: %(default)s)")
    parser.add_argument("--hand-payload", type=float, default=0.0, help="what each hand carries in them [kg]")
    options = parser.parse_args(arguments)
    walls, runs = (range(options.first, options.first + count) for count in (options.walls, options.runs))
    good = [_walls(walls, options.hand_payload)] if walls else []
    conditions = {"hand_payload": options.hand_payload} if options.hand_payload else {}
    good += [_alarms(runs, conditions)] if runs else []
    return 0 if all(good) else 1


if __name__ == "__main__":
    raise SystemExit(main())
