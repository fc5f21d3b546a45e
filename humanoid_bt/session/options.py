"""What to run, and how: every argument of a session, judged once for Python and the command line."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, get_args

from humanoid_bt.cable.address import read_address, read_key
from humanoid_bt.core.clock import HOLD_TIME
from humanoid_bt.core.errors import Problem, UserError, nearest, resolved
from humanoid_bt.core.sizes import VALID, read_size, shown_size
from humanoid_bt.core.sources import Sources
from humanoid_bt.perception.choice import written
from humanoid_bt.record.folder import log_beside
from humanoid_bt.record.folder_limits import load_limits
from humanoid_bt.record.parts import PART_SIZE, SMALLEST_PART
from humanoid_bt.record.sinks import Sinks, has_display
from humanoid_bt.robot.config import Walk
from humanoid_bt.session import limits
from humanoid_bt.tree.tree import Tree

Mode = Literal["lockstep", "realtime"]

_LONGEST_NAME = 150  # bytes of a tree's name in the name of a file, which has 255
RUNS = Path("runs")
"""Folder of recordings below the working directory; made when it is needed."""

OnEStop = Literal["wait", "end"]

RUN_TIME = 600.0
"""Longest simulated time of a run in lockstep that says nothing else, and that nobody watches [s]."""


@dataclass(frozen=True)
class RunOptions:
    """What to run, and how.

    Attributes:
        tree: name or path of the tree, or a tree that was loaded or made in Python.
        robot, scene: names or paths; None for what the tree says.
        body: what walks and balances; None for what ``robot.yaml`` says.
        perception: the percept sources; None for what the tree or the scene says.
        parameters: values for the tree's parameters, or text as after ``--set``.
        arguments: what else can be given beside the parameters, for hints.
        seed: of everything random.
        duration: longest simulated time [s]; None for what :meth:`limit` says.
        on_estop: whether the run waits for the reset of an emergency stop; None for what :meth:`waits` says.
        pace: simulated seconds per second; None for 1 with a live view, else as fast as it can.
        sinks: where the recording goes.
        numbered: whether the name of its file gets a number when it is taken, because nobody gave that name.
        mode: lockstep, or realtime with control and perception as processes of their own.
        hold: in realtime mode, how long control balances the robot when decision has died [s].
        plant: where the plant is, in realtime mode; "" for one that is simulated here.
        plant_key: file with the key for frames to it; "" for none.
        camera: whether the recording has pictures of the head camera; "auto" where they do not hold up the run.
        watch: swap the tree for an edited one whenever its files change; goes on when the tree has ended.
        view_optional: go on without the native viewer if it cannot be opened.
        gateway: name or path of the gateway file; None for none.
        staged: what a test does to the run, as in the report; None if it does nothing.
    """

    tree: str | Tree
    robot: str | None = None
    scene: str | None = None
    body: Walk | None = None
    perception: Sources | None = None
    parameters: Mapping[str, Any] = field(default_factory=dict)
    arguments: tuple[str, ...] = ()
    seed: int = 0
    duration: float | None = None
    on_estop: OnEStop | None = None
    pace: float | None = None
    sinks: Sinks = field(default_factory=Sinks)
    numbered: bool = False
    mode: Mode = "lockstep"
    hold: float = HOLD_TIME
    plant: str = ""
    plant_key: str = ""
    camera: bool | Literal["auto"] = "auto"
    watch: bool = False
    view_optional: bool = False
    gateway: str | None = None
    staged: dict[str, Any] | None = None

    @classmethod
    def of(
        cls,
        tree: Any,
        *,
        parameters: Mapping[str, Any],
        arguments: tuple[str, ...],
        robot: Any,
        scene: Any,
        body: Any,
        perception: Any,
        seed: Any,
        mode: Any,
        duration: Any,
        on_estop: Any,
        pace: Any,
        hold: Any,
        plant: Any,
        plant_key: Any,
        record: Any,
        record_part_size: Any,
        view: Any,
        serve: Any,
        camera: Any,
        watch: Any,
        gateway: Any,
    ) -> RunOptions:
        """Return the options that the arguments of a :class:`~humanoid_bt.session.session.Session` stand for.

        Raises:
            UserError: with everything that is wrong with them.
        """
        judge = _Judge()
        judge.choice("mode", mode, get_args(Mode))
        judge.choice("body", body, (None, *get_args(Walk)))
        judge.choice("on_estop", on_estop, (None, *get_args(OnEStop)))
        judge.choice("watch", watch, (False, True))
        judge.choice("view", view, (False, True, "auto"))
        judge.choice("camera", camera, (False, True, "auto"))
        where, key = judge.plant(plant, plant_key, mode)
        speed = judge.number("pace", pace, limits.PACE)
        if speed and mode == "realtime":
            judge.note("'pace' does not go with the mode realtime", "realtime runs on the wall clock")
        if gateway is not None and mode == "lockstep":
            judge.note(
                "'gateway' does not go with the mode lockstep", "valid: mode='realtime'; ROS time is a wall clock"
            )
        named = judge.tree(tree)
        if isinstance(named, Tree):
            judge.loaded(named, parameters, watch)
        port = judge.number("serve", serve, limits.PORT)
        options = cls(
            tree=named,
            robot=judge.name("robot", robot),
            scene=judge.name("scene", scene),
            body=body,
            perception=judge.sources(perception),
            parameters=parameters,
            arguments=arguments,
            seed=int(judge.number("seed", seed, limits.SEED, needed=True) or 0),
            duration=judge.number("duration", duration, limits.DURATION),
            on_estop=on_estop,
            pace=1.0 if watch and mode == "lockstep" and not speed else speed,
            sinks=Sinks(
                file=judge.recording(record, named),
                view=has_display() if view == "auto" else view,
                serve=None if port is None else int(port),
                part_size=judge.size("record_part_size", record_part_size),
                limits=load_limits(RUNS) if record is True else None,
            ),
            numbered=record is True,
            mode=mode,
            hold=judge.number("hold", hold, limits.POSITIVE, needed=True) or HOLD_TIME,
            plant=where,
            plant_key=key,
            camera=camera,
            watch=watch,
            view_optional=view == "auto",
            gateway=judge.name("gateway", gateway),
        )
        if judge.problems:
            raise UserError(judge.problems)
        return options

    @property
    def log(self) -> Path | None:
        """File in which control notes what happens, beside the recording; None without one."""
        return log_beside(self.sinks.file) if self.sinks.file else None

    def waits(self, watched: bool) -> bool:
        """Return whether the run waits for the reset of an emergency stop, or ends with it.

        Args:
            watched: whether a live view is open.
        """
        return self.on_estop == "wait" if self.on_estop else self._attended(watched)

    def limit(self, watched: bool, tree: Tree) -> float:
        """Return the longest simulated time [s]: without end where a person is taken to be there.

        Args:
            watched: whether a live view is open.
            tree: whose own time limits are not cut short.
        """
        if self.duration is not None:
            return self.duration
        return math.inf if self._attended(watched) else max(RUN_TIME, _time_limits(tree))

    def _attended(self, watched: bool) -> bool:
        return watched or self.watch or self.mode == "realtime"


def _time_limits(tree: Tree) -> float:
    """Return how long a tree may run as its time-outs say, one after the other [s]."""
    durations = [node.values.get("duration") for node in tree.nodes if node.type_name == "timeout"]
    return sum(duration for duration in durations if isinstance(duration, (int, float)))


class _Judge:
    """Takes the arguments of a session one by one and notes what is wrong with them."""

    def __init__(self) -> None:
        self.problems: list[Problem] = []

    def note(self, message: str, hint: str = "") -> None:
        self.problems.append(Problem(message, hint=hint))

    def tree(self, tree: Any) -> str | Tree:
        return tree if isinstance(tree, Tree) else self._path("tree", tree, "the name or the file of a tree, or a Tree")

    def loaded(self, tree: Tree, parameters: Mapping[str, Any], watch: Any) -> None:
        """Judge what does not go with a tree that is there already."""
        if parameters:
            given = ", ".join(f"{name}={value!r}" for name, value in parameters.items())
            hint = f"give them where it is loaded: load({str(tree.path)!r}, {given})"
            self.note(f"the tree {tree.name!r} is loaded already, with its parameters", hint)
        if watch:
            self.note("'watch' needs the file of a tree, not one that is loaded already", "give its name or its file")

    def name(self, argument: str, value: Any) -> str | None:
        return None if value is None else self._path(argument, value, f"the name or the path of a {argument}")

    def sources(self, value: Any) -> Sources | None:
        try:
            return written(value)
        except UserError as error:
            self.problems += error.problems
            return None

    def number(self, argument: str, value: Any, limit: limits.Limit, needed: bool = False) -> float | None:
        if value is None and not needed:
            return None
        try:
            return limit.take(value, argument)
        except UserError as error:
            self.problems += error.problems
            return None

    def choice(self, argument: str, value: Any, valid: tuple[Any, ...]) -> None:
        if not any(type(value) is type(known) and value == known for known in valid):
            self.note(f"{argument!r} cannot be {value!r}", nearest(str(value), map(str, valid)))

    def plant(self, plant: Any, key: Any, mode: Any) -> tuple[str, str]:
        """Judge where a plant is, and the file with its key, before anything is started; return both, "" for none."""
        if plant is None:
            if key is not None:
                self.note("'plant_key' is that of a plant in another process", "give 'plant' too")
            return "", ""
        if mode != "realtime":
            self.note("'plant' does not go with the mode lockstep", "valid: mode='realtime'")
        where = self._path("plant", plant, "an address")
        file = None if key is None else Path(self._path("plant_key", key, "a file")).absolute()
        try:
            if where:
                read_key(read_address(where), file)
        except UserError as error:
            self.problems += error.problems
        return where, "" if file is None else str(file)

    def size(self, argument: str, value: Any) -> int:
        size = read_size(value) if isinstance(value, str) else value
        if isinstance(size, int) and not isinstance(size, bool) and size >= SMALLEST_PART:
            return size
        self.note(f"{argument!r} must be {VALID}, at least {shown_size(SMALLEST_PART)}, not {value!r}")
        return PART_SIZE

    def recording(self, value: Any, tree: str | Tree) -> Path | None:
        if isinstance(value, bool):
            return default_recording(tree) if value else None
        path = Path(self._path("record", value, "a file, True or False"))
        if path.name and path.suffix != ".rrd" and not path.is_dir():
            self.note(f"'record' must be a file that ends in .rrd, not {str(path)!r}", f"{path.with_suffix('.rrd')}")
        return path

    def _path(self, argument: str, value: Any, valid: str) -> str:
        path = os.fspath(value) if isinstance(value, (str, os.PathLike)) else ""
        if path and isinstance(path, str):
            return path
        self.note(f"{argument!r} must be {valid}, not {value!r}")
        return ""


def default_recording(tree: str | Tree) -> Path:
    """Return where a run is recorded by default."""
    name = tree.name if isinstance(tree, Tree) else Path(tree).stem
    name = os.fsencode(name)[:_LONGEST_NAME].decode(errors="ignore")
    return RUNS / f"{name}-{time.strftime('%Y%m%d-%H%M%S')}.rrd"


def make_folder() -> None:
    """Make the folder of recordings.

    Raises:
        UserError: it cannot be made.
    """
    try:
        RUNS.mkdir(exist_ok=True)
    except OSError as error:
        hint = "give another place with --record FILE (record=FILE in Python), or --no-record"
        raise UserError(f"the folder {str(resolved(RUNS))!r} cannot be made: {error.strerror}", hint=hint) from error
