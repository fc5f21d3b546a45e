"""A workspace with small skills, a robot without a body, and hand-made snapshots for it."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from humanoid_bt.core.clock import CycleClock
from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import SIDES, Command, FootPose, Gait, Level, Mode, Percept, Side, State
from humanoid_bt.decision.calls import Calls
from humanoid_bt.decision.robot import Robot
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.robot.config import GazeConfig, HandConfig, LegConfig, RobotConfig, SiteConfig, SoleConfig
from humanoid_bt.tree.source.load import load_tree
from humanoid_bt.tree.ticking.executor import Executor, NodeChange
from humanoid_bt.tree.tree import Tree
from tests.tree.calls import NamedCalls

SKILLS = '''
from typing import Literal

import py_trees
from humanoid_bt.core.params import PerceptName, param
from humanoid_bt.decision.skill import Skill, Status

LOG = []
"""What skills were told, in order: (event, node name)."""


class Approach(Skill):
    """Walk until near the target."""

    resources = ("base", "gaze")
    target: PerceptName = param(doc="Whom to approach.")
    distance: float = param(0.5, above=0, unit="m", doc="How near.")
    tolerance: float = param(0.06, above=0, unit="m", doc="Arrived when this close; it is there or not.")

    def update(self):
        track = self.robot.track(self.target)
        if track.distance <= self.distance:
            return self.succeed("there")
        self.robot.walk_to(track.position_world[:2], 0.0)
        return self.running("walking")


class Reach(Skill):
    """Touch the target."""

    resources = ("left_hand", "right_hand")
    bounded = True
    target: PerceptName = param(doc="What to touch.")
    hand: Literal["left", "right", "nearest"] = param("nearest", doc="Which hand.")

    @classmethod
    def resources_for(cls, values):
        return cls.resources if values["hand"] == "nearest" else (values["hand"] + "_hand",)

    def update(self):
        self.robot.move_hand("left", self.robot.track(self.target).position_world)
        return self.running("reaching")


class Idle(Skill):
    """Stand and look around."""

    resources = ("gaze", "posture")
    ends = False
    look_around: bool = param(True, doc="Turn the head now and then.")

    def update(self):
        self.robot.look_at([1, 0, 1])
        return self.running("idle")


class Look(Skill):
    """Look ahead."""

    resources = ("gaze",)
    bounded = True

    def update(self):
        self.robot.look_at([1, 0, 1])
        return self.succeed("seen")


class Act(Skill):
    """Do what its script says, one letter per tick: r(unning), s(uccess), f(ailure), x (raise); the last stays."""

    script: str = param("r", doc="What to return.")

    def __init__(self, name="", **values):
        super().__init__(name, **values)
        self.ticks = 0

    def initialise(self):
        LOG.append(("start", self.name))

    def update(self):
        letter = self.script[min(self.ticks, len(self.script) - 1)]
        self.ticks += 1
        if letter == "x":
            raise RuntimeError("out of order")
        if letter == "n":
            return None
        return {"r": Status.RUNNING, "s": Status.SUCCESS, "f": Status.FAILURE}[letter]

    def terminate(self, new_status):
        LOG.append((new_status.name, self.name))


class BadEnd(Act):
    """Raise when halted."""

    def terminate(self, new_status):
        super().terminate(new_status)
        if new_status is Status.INVALID:
            raise RuntimeError("cannot stop")


class BadStart(Act):
    """Leave the program when started."""

    def initialise(self):
        super().initialise()
        raise SystemExit(3)


class Plain(py_trees.behaviour.Behaviour):
    """A behaviour that knows nothing of robots."""

    def __init__(self, name: str, count: int = 2):
        super().__init__(name)
        self.count = count

    def update(self):
        self.count -= 1
        return Status.SUCCESS if self.count <= 0 else Status.RUNNING
'''

COUNTED = """\
subtree: true
parameters: {limit: 2}
blackboard: {count: 0}
outputs: {total: {type: number, doc: How often.}}
root:
  sequence:
    - set_blackboard: {key: count, expression: count + 1}
    - set_blackboard: {key: total, expression: count}
    - condition: count <= limit
"""
"""A sub-tree that counts how often it was started, in a key that begins anew each time."""

NO_TARGET: Mapping[str, Percept] = {}


def make_workspace(root: Path, skills: str = SKILLS) -> Workspace:
    """Return a workspace with one file of skills."""
    (root / "skills").mkdir(parents=True)
    (root / "trees").mkdir()
    (root / "skills" / "test_skills.py").write_text(skills)
    return Workspace(root)


def make_robot(
    clock: CycleClock,
    log: Callable[[str, Level, str], None] | None = None,
    calls: Calls | None = None,
    hands: Sequence[Side] = SIDES,
) -> Robot:
    """Return a robot."""
    sole = SiteConfig(body="foot")
    leg = LegConfig(hip_roll="a", hip_pitch="b", ankle_pitch="c", ankle_roll="d", sole=sole)
    config = RobotConfig(
        format=1,
        name="test",
        model="test.xml",
        base="pelvis",
        torso="torso",
        legs={"left": leg, "right": leg},
        sole=SoleConfig(half_length=0.1, half_width=0.05),
        hands={side: HandConfig(body=f"{side}_palm") for side in hands},
        gaze=GazeConfig(body="head"),
        drives=[],
    )
    return Robot(config, clock, log=log, calls=calls)


def make_state(time: float = 0.0, mode: Mode = Mode.RUN, reason: str = "", source: str = "") -> State:
    """Return the state of a robot that stands at the origin."""
    zero, foot = np.zeros(3), FootPose(0, 0, 0)
    joints = np.zeros(0)
    return State(
        time=time,
        cycle=round(time * 1000),
        joint_positions=joints,
        joint_velocities=joints,
        joint_torques=joints,
        setpoint_positions=joints,
        setpoint_velocities=joints,
        base_position=zero,
        base_quaternion=np.array([1.0, 0, 0, 0]),
        base_linear_velocity=zero,
        base_angular_velocity=zero,
        base_covariance=np.zeros((9, 9)),
        com=zero,
        com_velocity=zero,
        hands={"left": zero, "right": zero},
        feet={"left": foot, "right": foot},
        stance=zero,
        gaze_position=zero,
        gaze_direction=np.array([1.0, 0, 0]),
        foot_force={"left": 200.0, "right": 200.0},
        gait=Gait.STAND,
        footsteps=(),
        base_settled=True,
        mode=mode,
        stop_reason=reason,
        stop_source=source,
        command_sequence=-1,
        command_sources={},
        targets={},
        hand_errors={},
        hand_orientations={},
        hand_turn_errors={},
        hand_obstacles={},
        limit_flags=(),
    )


def seen(time: float, distance: float = 1.0, confidence: float = 0.9, sideways: float = 0.0) -> dict[str, Percept]:
    """Return one percept named ``target``."""
    return {"target": Percept("target", time, np.array([distance, sideways, 0.0]), confidence)}


class Run:
    """One tree being ticked by hand, every 0.1 s."""

    def __init__(self, tree: Tree) -> None:
        self.tree = tree
        self.clock = CycleClock()
        self.events: list[tuple[str, str, str]] = []
        self.calls = NamedCalls(self.clock)
        self.robot = make_robot(self.clock, lambda *event: self.events.append(event), self.calls)
        self.changes: list[NodeChange] = []
        self.executor = Executor(tree, self.robot, self.changes.append)
        self.executor.setup()
        self.log: list[tuple[str, str]] = _log_of(tree)
        self.log.clear()

    @property
    def time(self) -> float:
        return self.clock.now()

    def tick(
        self, percepts: Mapping[str, Percept] = NO_TARGET, mode: Mode = Mode.RUN, reason: str = "", source: str = ""
    ) -> Command:
        """Tick once, then let 0.1 s pass."""
        self.changes.clear()
        try:
            return self.executor.tick(make_state(self.time, mode, reason, source), percepts)
        finally:
            self.clock.cycle += 100

    def ticks(self, count: int) -> str:
        """Tick often; return the root's statuses as letters."""
        letters = []
        for _ in range(count):
            self.tick()
            letters.append(self.executor.status.name[0].lower())
        return "".join(letters)

    def halt(self) -> None:
        """Halt the tree."""
        self.changes.clear()
        self.executor.halt("test")

    def told(self) -> list[tuple[str, str]]:
        """Return what changed in the last tick or halt: (last part of the path, status)."""
        return [(change.path.rpartition("/")[2], change.status.name) for change in self.changes]

    def feedback(self, name: str) -> str:
        """Return a node's feedback."""
        return next(node.behaviour.feedback_message for node in self.tree.nodes if node.name == name)


def load(workspace: Workspace, text: str, **overrides: str) -> Tree:
    """Load a tree from the text of its file; the header's format may be left out."""
    path = workspace.root / "trees" / "t.yaml"
    path.write_text(text if "format:" in text else "format: 1\n" + text)
    return load_tree(path, workspace, overrides)


def found(workspace: Workspace, text: str, *codes: str, **overrides: str) -> list[str]:
    """Return what checking a tree file finds, as ``line:column code message``; only some codes if they are given."""
    try:
        problems = load(workspace, text, **overrides).warnings
    except UserError as error:
        problems = error.problems
    return [
        f"{problem.place.line}:{problem.place.column} {problem.code} {problem.message}"
        for problem in problems
        if problem.place is not None and (not codes or problem.code in codes)
    ]


def write(workspace: Workspace, name: str, text: str) -> Path:
    """Write a tree file, but for its format; return its path."""
    path = workspace.root / "trees" / f"{name}.yaml"
    path.write_text("format: 1\n" + textwrap.dedent(text), encoding="utf-8")
    return path


def run(workspace: Workspace, root: str) -> Run:
    """Load a tree from its root node, in YAML's flow form, ready to be ticked."""
    return Run(load(workspace, f"root: {root}\n"))


def _log_of(tree: Tree) -> list[tuple[str, str]]:
    for node in tree.nodes:
        if node.kind == "skill":
            log: list[tuple[str, str]] = vars(sys.modules[type(node.behaviour).__module__]).get("LOG", [])
            return log
    return []
