"""A real simulated robot on which one skill runs alone, in lockstep."""

from __future__ import annotations

import copy
import math
import typing
from collections.abc import Callable, Iterable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, get_args

import numpy as np
from py_trees.common import Status

from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.clock import PERCEPTION_PERIOD, cycles
from humanoid_bt.core.errors import Place, UserError, nearest, relative
from humanoid_bt.core.geometry import turn_of_axis
from humanoid_bt.core.items import item_of
from humanoid_bt.core.messages import Array, Command, PalmAxis, Percept, Pose, Side, State
from humanoid_bt.core.palm import axis_of
from humanoid_bt.core.params import Param, PerceptName
from humanoid_bt.core.reading import convert, needed
from humanoid_bt.decision.overridden import not_made
from humanoid_bt.decision.result import results_of
from humanoid_bt.decision.robot import Robot
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.session import limits
from humanoid_bt.session.lockstep import Lockstep
from humanoid_bt.session.options import OnEStop
from humanoid_bt.testing.check_skill_result import SkillCheck
from humanoid_bt.testing.check_skill_rules import tried
from humanoid_bt.testing.conditions import Conditions
from humanoid_bt.testing.events import Event, script_of
from humanoid_bt.testing.faults import Push, See
from humanoid_bt.testing.rig_result import RigResult
from humanoid_bt.testing.scripted_perception import ScriptedPerception
from humanoid_bt.testing.stage import Stage
from humanoid_bt.testing.tree_run import TreeRun, Watcher
from humanoid_bt.tree.node import Node
from humanoid_bt.tree.node_type import NodeType
from humanoid_bt.tree.nodes.registry import Registry
from humanoid_bt.tree.source.given import given, plain_item
from humanoid_bt.tree.ticking.executor import Executor, NodeChange
from humanoid_bt.tree.tree import Tree

_PLACE = Place("rig.run")


class Rig:
    """A simulated robot on an empty floor, for one skill at a time.

    Nothing of the robot is faked: free base, contacts, torque limits, servo, supervisor. Only what it sees is
    dictated by the test.

    Args:
        workspace: where skills are found; the working directory if None.
        robot: name of the robot.

    Raises:
        UserError: the robot or a skill has mistakes.
    """

    def __init__(self, workspace: str | PathLike[str] | Workspace | None = None, robot: str = "humanoid") -> None:
        self.workspace = workspace = workspace if isinstance(workspace, Workspace) else Workspace(workspace)
        self._registry = Registry.of(workspace)
        self._robot_name = robot
        self._stages: dict[tuple[str | None, bool, str], Stage] = {}
        self._model, start = load_robot(workspace.find_robot(robot))
        scene = Scene(load_scene(workspace.find_scene("empty")), seed=0)
        self._perception = ScriptedPerception()
        self._lockstep = Lockstep(self._model, start, scene, self._perception)
        self._script: list[tuple[float, Callable[[], None]]] = []
        self._silent_until = -math.inf
        self.reset()

    def reset(self) -> None:
        """Stand at the origin, heading along x, at time zero, with nothing seen."""
        self._perception = ScriptedPerception()
        self._lockstep.reset(self._perception)
        lockstep = self._lockstep
        raise_estop = lockstep.controller.supervisor.raise_estop
        self._robot = Robot(
            self._model.config, lockstep.clock, raise_estop, unseen=lambda: lockstep.unseen, model=self._model
        )
        self._script = []
        self._silent_until = -math.inf

    # ---- what the test reads ----------------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """Engine time [s]."""
        return self._lockstep.clock.now()

    @property
    def state(self) -> State:
        """The robot's state now."""
        return self._lockstep.controller.state()

    def hand_distance(self, side: Side, position: Any) -> float:
        """Return how far a palm is from a position, shape (3,), world frame [m].

        Raises:
            UserError: there is no such side, the robot has no hand there, or the position is none.
        """
        if side not in get_args(Side):
            raise UserError(f"'side' cannot be {side!r}", hint=nearest(str(side), get_args(Side)))
        hands = self.state.hands
        if side not in hands:
            raise UserError(f"the robot has no {side} hand")
        return float(np.linalg.norm(hands[side] - _vector(position, "position")))

    def pose(self, name: str) -> Pose:
        """Return where a body or a site of the robot is, as ``self.robot.pose`` of a skill does.

        Raises:
            HumanoidBtError: the robot has neither of this name.
        """
        return self._robot.anatomy.pose(name, self.state)

    def hand_turned(self, side: Side, direction: Any, axis: PalmAxis = "fingers") -> float:
        """Return the angle from an axis of a palm to a direction, shape (3,), world frame [rad].

        Args:
            side: of the hand.
            direction: of any length.
            axis: "fingers", or "facing": where the palm faces.

        Raises:
            UserError: there is no such side or axis, or the direction is none, or zero.
        """
        for what, name, valid in (("side", side, get_args(Side)), ("axis", axis, get_args(PalmAxis))):
            if name not in valid:
                raise UserError(f"{what!r} cannot be {name!r}", hint=nearest(str(name), valid))
        wanted = _vector(direction, "direction")
        if not (length := float(np.linalg.norm(wanted))) > 0:
            raise UserError(f"'direction' cannot be {direction!r}", hint="three numbers, not all of them zero")
        pointed = axis_of(self.pose(f"{side}_palm").rotation, axis)
        return float(np.linalg.norm(turn_of_axis(pointed, wanted / length)))

    # ---- what the test dictates -------------------------------------------------------------------------------------

    def see(self, name: str, position: Any, confidence: float = 0.95, size: Any = None) -> None:
        """Let the robot see a thing at a position, shape (3,), world frame [m], from now on.

        A thing with a size, shape (3,): length, width, height [m], is an obstacle, but nothing to bump into.

        Raises:
            UserError: these are none.
        """
        seen = _see(name, position, confidence=confidence, size=size)
        self._perception.see(seen.percept, seen.position, seen.confidence, seen.size)

    def lose(self, name: str) -> None:
        """Let perception of a thing end: its last percept grows old."""
        self._perception.lose(name)

    def push(self, force: Any, duration: float | str = 0.1, body: str = "") -> None:
        """Push a body (default: the torso) with a force, shape (3,), world frame [N], for a time [s].

        Raises:
            UserError: there is no such body, or these are no force and time.
        """
        given = {"force": force, "duration": duration, "body": body}
        push = Push.from_item(plain_item("push", given, Place("rig.push")), "push")
        self._lockstep.plant.push(push.body or self._model.config.torso, np.array(push.force), push.duration)

    def raise_estop(self, reason: str = "raised by the test") -> None:
        """Raise the emergency stop."""
        self._lockstep.controller.supervisor.raise_estop("rig", reason)

    def silence_decision(self, duration: float | str) -> None:
        """Let no command reach control for a time [s], as if decision were stuck."""
        self._silent_until = self.time + _time(duration)

    def at(self, time: float | str, action: Callable[[], None]) -> None:
        """Do something at an engine time [s], such as ``rig.at(1.0, lambda: rig.lose("target"))``.

        Raises:
            UserError: the time is none, or the action nothing that can be called.
        """
        if not callable(action):
            raise UserError(f"'action' cannot be {action!r}", hint='what can be called: lambda: rig.lose("target")')
        self._script.append((limits.MOMENT.take(time, "time"), action))

    # ---- running ----------------------------------------------------------------------------------------------------

    def run(self, skill: str, *, timeout: float | str = 10.0, **values: Any) -> RigResult:
        """Run one skill until it ends or the time is up; then it is halted.

        Args:
            skill: its name in trees.
            timeout: longest simulated time [s]; or text, "2 min".
            values: its parameters. For a parameter that names a percept a position (x, y, z) may be given, world
                frame [m]: the robot sees a thing there under the parameter's name.

        Raises:
            UserError: there is no such skill or parameter, or a value has the wrong type.
            NodeError: the skill raised an exception.
        """
        longest = _time(timeout, "timeout")
        node_type = self._skill(skill)
        tree = _alone(node_type, self._convert(node_type, values))
        changes: list[NodeChange] = []
        executor = Executor(tree, self._robot, changes.append)
        executor.setup()
        states: list[State] = []
        commands: list[Command] = []
        begin, ordered = self.time, self._lockstep.controller.supervisor.stops
        before = ordered.total
        behaviour = tree.root
        while True:
            state, command = self._tick(executor)
            states.append(state)
            commands.append(command)
            status, feedback = behaviour.status, behaviour.feedback_message
            if status is not Status.RUNNING or self.time - begin >= longest:
                break
            self._advance(command)
        if status is Status.RUNNING:
            executor.halt("the test's time is up")
        results, stops = dict(results_of(behaviour)), list(ordered.since(before))
        return RigResult(status, feedback, self.time - begin, results, states, commands, changes, stops)

    def check_skill(self, skill: str, *, timeout: float | str = 10.0, **values: Any) -> SkillCheck:
        """Try a skill against the contract, rule by rule; raise nothing for what it breaks.

        It lives many times, each time from the start of the robot: undisturbed, started anew, halted in many ticks,
        with an emergency stop, without the percepts it asks for. What the robot has been shown it sees in all of them,
        and afterwards, when it stands at its start again.

        Args:
            skill: its name in trees.
            timeout: longest simulated time of one life [s]; or text, "2 min".
            values: its parameters, as for :meth:`run`; best such with which it succeeds.

        Raises:
            UserError: there is no such skill or parameter, or a value has the wrong type.
        """
        longest, subject = limits.HOLD.take(timeout, "timeout"), _Tried(self, skill, values)
        try:
            return tried(subject, longest)
        finally:
            subject.begin()

    def run_tree(
        self,
        tree: str | PathLike[str] | Tree,
        *,
        scene: str | PathLike[str] | None = None,
        percepts: Mapping[str, Any] | None = None,
        perception: str | Mapping[str, Any] | Sequence[Any] | None = None,
        dry: bool = False,
        seed: int = 0,
        duration: float | str | None = None,
        on_estop: OnEStop | None = None,
        script: Iterable[Event | Mapping[str, Any]] = (),
        conditions: Conditions | Mapping[str, Any] | None = None,
        replace: Mapping[str, Any] | None = None,
        record: str | PathLike[str] | None = None,
        watchers: Iterable[Watcher] | Watcher = (),
        parameters: Mapping[str, Any] | None = None,
        **values: Any,
    ) -> TreeRun:
        """Run a whole tree to its end on a robot of the same kind, which stands at the scene's start.

        Args:
            tree: its name or file, or one that was loaded.
            scene: name or path of the scene; if None what the tree says, or an empty floor where percepts are given.
            percepts: what the robot sees from the beginning, wherever it looks: name -> position, shape (3,), world
                frame [m].
            perception: the percept sources, as in a scene file; what the tree or the scene says if None.
            dry: without physics: the robot is at once where it is told to be. For the logic of trees only.
            seed: of everything random.
            duration: longest simulated time [s], or text, "2 min"; as in ``humanoid-bt run`` if None.
            on_estop: what an emergency stop does to the run: "wait" for its reset, or "end"; if None it waits where
                the script resets it.
            script: faults, each at a time or at a moment; as events, or as in YAML.
            conditions: what is different from the beginning.
            replace: what stands in a node's place, by the node's path, the end of it, or by type.
            record: file of the recording; none is made if None.
            watchers: who looks on, or the only one who does.
            parameters: values for the tree's parameters, for names that are those of arguments too.
            values: values for the tree's parameters: 0.45, or text as after ``--set``, "45 cm".

        Raises:
            UserError: an argument, the tree, scene or a skill has mistakes, or the recording cannot be opened.
            NodeError: a skill raised an exception in ``setup``.
        """
        where = "empty" if scene is None and percepts else None if scene is None else str(scene)
        key = where, dry, repr(perception)
        stage = self._stages.get(key)
        if stage is None:
            stage = Stage(self.workspace, self._robot_name, where, dry, perception=perception)
            self._stages[key] = stage
        seen = [Event(at=0, see=_see(name, where), place=_percept(name)) for name, where in (percepts or {}).items()]
        return stage.run(
            tree,
            seed=seed,
            parameters=given(parameters, values),
            duration=duration,
            on_estop=on_estop,
            script=[*seen, *script_of(script)],
            conditions=conditions,
            replace=replace,
            record=record,
            watchers=watchers,
        )

    def settle(self, duration: float | str = 2.0) -> State:
        """Let the robot come to rest with nothing commanded, for a time [s]; return the state then.

        Raises:
            UserError: it is no such time, or without an end.
        """
        until = self.time + limits.HOLD.take(duration, "duration")
        while self.time < until:
            state, percepts = self._sense()
            self._robot.begin_tick(state, percepts)
            self._advance(self._robot.release_all())
        return self.state

    def _tick(self, executor: Executor) -> tuple[State, Command]:
        state, percepts = self._sense()
        return state, executor.tick(state, percepts)

    def _sense(self) -> tuple[State, dict[str, Percept]]:
        due = [entry for entry in self._script if entry[0] <= self.time + 1e-9]
        self._script = [entry for entry in self._script if entry not in due]
        for _, action in due:
            action()
        return self._lockstep.sense()

    def _advance(self, command: Command) -> None:
        if self.time >= self._silent_until:
            self._lockstep.submit(command)
        self._lockstep.advance()

    def _skill(self, name: str) -> NodeType:
        node_type = self._registry.get(name)
        if node_type is None or node_type.kind != "skill":
            known = [name for name, kind in self._registry.items() if kind.kind == "skill"]
            where = f"the workspace {relative(self.workspace.root)!r}, nor among the built-in ones"
            raise UserError(f"no skill named {name!r} in {where}", hint=nearest(name, known))
        return node_type

    def _convert(self, node_type: NodeType, values: dict[str, Any]) -> dict[str, Any]:
        converted: dict[str, Any] = {}
        params, what = node_type.params, f"the skill {node_type.type_name!r}"
        if unknown := [name for name in values if name not in params]:
            hint = nearest(unknown[0], params) or "it has none"
            raise UserError(f"{what} has no parameter {unknown[0]!r}", hint=hint, code="unknown-parameter")
        if missing := [name for name, spec in params.items() if spec.required and name not in values]:
            hint = needed(params[missing[0]])
            raise UserError(f"{what} needs the parameter {missing[0]!r}", hint=hint, code="missing-parameter")
        for name, value in values.items():
            spec = params[name]
            names_one = (
                PerceptName in (spec.type, *typing.get_args(spec.type)) and typing.get_origin(spec.type) is not list
            )
            if names_one and value is not None and not isinstance(value, str):
                self.see(name, value)
                self._wait_for_perception()
                converted[name] = name
            else:
                written = value.tolist() if isinstance(value, np.ndarray) else value
                converted[name] = convert(spec, item_of(written, _PLACE))
        return converted

    def _wait_for_perception(self) -> None:
        """Stand until perception runs next, so that what was just dictated is seen in the skill's first tick."""
        while not self._lockstep.clock.due(cycles(PERCEPTION_PERIOD)):
            state, percepts = self._sense()
            self._robot.begin_tick(state, percepts)
            self._advance(self._robot.release_all())


def _time(duration: float | str, name: str = "duration") -> float:
    """Return a time that was given in seconds, or as text with its unit [s]; raises UserError if it is none."""
    return limits.DURATION.take(duration, name)


def _vector(value: Any, name: str) -> Array:
    """Return three numbers, shape (3,); raises UserError if they are none."""
    spec = Param(name, tuple[float, float, float])
    return np.array(convert(spec, plain_item(name, value, Place("the test"))))


def _see(name: str, position: Any, **further: Any) -> See:
    """Return what lets a thing be seen at a position; raises UserError if that is none."""
    given = {"percept": name, "position": position, **further}
    return See.from_item(plain_item("see", given, _percept(name)), "see")


def _percept(name: str) -> Place:
    return Place(f"the percept {name!r}")


class _Tried:
    """A skill that is tried on a rig, with what the rig has been shown."""

    def __init__(self, rig: Rig, skill: str, values: dict[str, Any]) -> None:
        self.node_type = rig._skill(skill)
        self.values = rig._convert(self.node_type, values)
        self._rig, self._shown = rig, rig._perception.shown
        self.lockstep = rig._lockstep

    def make(self) -> Tree:
        """Return a tree of the skill alone, made anew."""
        return _alone(self.node_type, copy.deepcopy(self.values))

    def begin(self) -> None:
        """Let the robot stand at its start and see what it was shown."""
        self._rig.reset()
        for name, shown in self._shown.items():
            self._rig.see(name, *shown)
        self._rig._wait_for_perception()

    def lose(self) -> None:
        """Let perception of everything end."""
        for name in self._shown:
            self._rig.lose(name)


def _alone(node_type: NodeType, values: Mapping[str, Any]) -> Tree:
    """Return a tree of nothing but a skill."""
    name = node_type.type_name
    behaviour = node_type.cls(name=name, **values)
    if problem := not_made(behaviour):
        raise UserError([problem])
    behaviour.path = name  # type: ignore[attr-defined]  # plain behaviours know their path too
    node = Node(name, name, node_type, values, _PLACE, behaviour, -1)
    return Tree(name, node_type.doc, Path(_PLACE.file), None, None, {}, "", (node,))
