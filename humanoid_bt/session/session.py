"""One tree on one robot: ticked step by step or to its end, with a report of what happened."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from os import PathLike
from types import TracebackType
from typing import Any, Literal, Self

import numpy as np

from humanoid_bt.core.clock import HOLD_TIME
from humanoid_bt.core.errors import HumanoidBtError, UserError
from humanoid_bt.core.messages import Pause, State
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.perception.track import Track
from humanoid_bt.record.parts import PART_SIZE
from humanoid_bt.robot.config import Walk
from humanoid_bt.session import limits
from humanoid_bt.session.blackboard import Blackboard, Percepts
from humanoid_bt.session.debugging import Debugging
from humanoid_bt.session.drive import Drive
from humanoid_bt.session.engine import Engine
from humanoid_bt.session.listener import Listener, listening
from humanoid_bt.session.loader import workspace_of
from humanoid_bt.session.options import Mode, OnEStop, RunOptions
from humanoid_bt.session.report import Report
from humanoid_bt.tree.node import Node
from humanoid_bt.tree.source.given import given
from humanoid_bt.tree.tree import Tree

_AT = 1e-9  # s; engine times are sums of floats


class Session(Debugging):
    """One tree on one robot, ready to run once.

    As a context manager it begins when it is entered. However it is left, the robot is brought to a stand, the
    recording is whole, and :attr:`report` is there. What a session shows is what its last step saw.

    Args:
        tree: name or file of a tree, or a tree that was loaded or made in Python and was in no session before.
        workspace: folder in which names are looked up; else a tree file's own, or the working directory.
        robot, scene: names or paths; else what the tree says.
        body: what walks and balances: "dcm", or "policy" or "own" for the learned walker or the class that
            robot.yaml names; else what it says.
        perception: the percept sources: a name, a mapping of names to parameters, or a list of these; else what the
            tree says, or the scene.
        seed: of everything random.
        mode: "lockstep": simulated time, all in one process, deterministic. "realtime": the wall clock, with control
            and perception as processes of their own.
        duration: longest simulated time [s], or text, "2 min"; if None without end in realtime mode, with a live view
            and with ``watch``, else 600, or what the tree's own time-outs allow if that is more.
        on_estop: what an emergency stop does to the run: "wait" for its reset, or "end". If None it waits where
            ``duration`` is without end by default, and ends elsewhere. A fall always ends it.
        pace: simulated seconds per second; if None 1 where somebody watches, else as fast as it can.
        hold: in realtime mode, how long control balances the robot when this process has died [s].
        plant: where the robot is, in realtime mode, if it is not simulated here: "udp://HOST:PORT".
        plant_key: file with the key that the plant has too; needed where its address is not this machine's own.
        record: the file of the recording; True for ``runs/TREE-DATE-TIME.rrd``, False for none.
        record_part_size: size from which on the recording goes on in another file, in bytes or as "500 MB".
        view: open the viewer on this machine's display; "auto" if there is one.
        serve: port of 127.0.0.1 on which a browser finds the viewer.
        camera: record what the head camera sees; "auto" where that does not hold up the run.
        watch: swap the tree for an edited one whenever its files change; goes on when the tree has ended.
        gateway: in realtime mode, the name or the file of a gateway, which joins the run with ROS 2.
        listener: who is told what happens.
        parameters: values for the tree's parameters, for names that are those of arguments too.
        values: values for the tree's parameters: 0.45, or text as after ``--set``, "45 cm".

    Raises:
        UserError: an argument, the tree, robot, scene or a skill has mistakes, or a sink cannot be opened.
        NodeError: a skill raised an exception in ``setup``.
    """

    def __init__(
        self,
        tree: str | PathLike[str] | Tree,
        *,
        workspace: str | PathLike[str] | Workspace | None = None,
        robot: str | PathLike[str] | None = None,
        scene: str | PathLike[str] | None = None,
        body: Walk | None = None,
        perception: str | Mapping[str, Any] | Sequence[Any] | None = None,
        seed: int = 0,
        mode: Mode = "lockstep",
        duration: float | str | None = None,
        on_estop: OnEStop | None = None,
        pace: float | None = None,
        hold: float = HOLD_TIME,
        plant: str | None = None,
        plant_key: str | PathLike[str] | None = None,
        record: bool | str | PathLike[str] = False,
        record_part_size: int | str = PART_SIZE,
        view: bool | Literal["auto"] = False,
        serve: int | None = None,
        camera: bool | Literal["auto"] = "auto",
        watch: bool = False,
        gateway: str | PathLike[str] | None = None,
        listener: Listener | None = None,
        parameters: Mapping[str, Any] | None = None,
        **values: Any,
    ) -> None:
        options = RunOptions.of(
            tree,
            parameters=given(parameters, values),
            arguments=_ARGUMENTS if values else (),
            robot=robot,
            scene=scene,
            body=body,
            perception=perception,
            seed=seed,
            mode=mode,
            duration=duration,
            on_estop=on_estop,
            pace=pace,
            hold=hold,
            plant=plant,
            plant_key=plant_key,
            record=record,
            record_part_size=record_part_size,
            view=view,
            serve=serve,
            camera=camera,
            watch=watch,
            gateway=gateway,
        )
        who = Listener() if listener is None else listening(listener)
        self._drive = Drive(options, workspace_of(options.tree, workspace), who)
        self._interruption = ""

    # ---- running ----------------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Begin: open the recording, start what runs beside the tree. Entering the session does it.

        Raises:
            UserError: the recording or the view cannot be opened.
            HumanoidBtError: it has begun before, or control did not come up.
        """
        if self._drive.begun:
            raise HumanoidBtError(f"the session of {self.tree.name!r} has begun before: it runs once, make a new one")
        self._drive.start()

    def step(self) -> bool:
        """Tick the tree once, 20 ms after the last time; return whether it goes on.

        False says that the run ends: :attr:`outcome` says how. An exception in a skill is such an end too, with the
        outcome "error" and the traceback in the report; it is not raised here. Ctrl-C is raised when the tick is
        over.

        A paused tree gets its tick too, and stands still again after it.

        In realtime mode it waits for the next tick. Who takes longer than 100 ms between two steps leaves the robot
        without commands, and the supervisor stops it until the next one.

        Raises:
            HumanoidBtError: the session has not begun, or the run has ended.
        """
        if self.paused is not None:
            self._drive.debugger.stepped("program")
        return self._go(None)

    def wait(self, duration: float) -> bool:
        """Let time pass without a tick while the run is paused, and control holds the robot; return as :meth:`step`.

        It is over when the run is not paused any more, or ends.

        Args:
            duration: how long [s].

        Raises:
            UserError: the duration is none.
            HumanoidBtError: as :meth:`step`, or the run is not paused.
        """
        until = self._from_now(limits.POSITIVE.take(duration, "duration"))
        if self._drive.running and self.paused is None:
            raise HumanoidBtError("the run is not paused: step() and run_until() let time pass")
        goes_on = True
        while goes_on and self.time < until() and (pause := self.paused) is not None:
            goes_on = self._go(pause)
        return goes_on

    def _go(self, pause: Pause | None) -> bool:
        """Tick the tree once, or let the time of a tick pass in a pause; return whether the run goes on."""
        if not self._drive.running:
            raise HumanoidBtError(self._why_no_step())
        if self._interruption:
            self._drive.leave("interrupted", self._interruption)
        elif pause is None:
            self._drive.tick()
        else:
            self._drive.stand_still(pause)
        return self._drive.running

    def run_until(self, condition: float | Callable[[Session], object], timeout: float | None = None) -> bool:
        """Step until something holds, the run is paused, or ends; return whether it holds.

        Args:
            condition: an engine time [s], or what is asked after each step and answers whether it holds.
            timeout: longest time from now [s]; as long as the run goes on if None.

        Raises:
            UserError: the condition is neither.
            HumanoidBtError: as :meth:`step`.
        """
        holds = self._condition(condition)
        if timeout is not None and not (isinstance(timeout, (int, float)) and timeout >= 0):
            raise UserError(f"'timeout' must be a number of seconds, 0 or more, not {timeout!r}")
        if self._drive.running and self._ticked and holds():
            return True
        until = self._from_now(math.inf if timeout is None else timeout)
        while self.paused is None and self.time < until():
            goes_on = self.step()
            if holds():
                return True
            if not goes_on:
                return False
        return False

    def _from_now(self, duration: float) -> Callable[[], float]:
        """Return what tells when so long has passed from now on, before the first step from when that will be."""
        now = self.time if self._ticked else None
        return lambda: (self._drive.loop.began if now is None else now) + duration - _AT

    def _condition(self, condition: float | Callable[[Session], object]) -> Callable[[], bool]:
        if callable(condition):
            return lambda: bool(condition(self))
        if isinstance(condition, (int, float)) and not isinstance(condition, bool) and not math.isnan(condition):
            return lambda: self.time >= condition - _AT
        raise UserError(f"'condition' must be a time [s] or a function of the session, not {condition!r}")

    def run(self, *, attended: bool = False) -> Report:
        """Step to the end, bring the robot to a stand, close the recording; return the report.

        A report comes back whatever the tree does. Ctrl-C brings the robot to a stand too, and is raised after it; a
        second one ends the run at once.

        Args:
            attended: whether another thread, as one that reads keys, is there to continue the run when it is paused.

        Raises:
            UserError: the recording or the view cannot be opened.
            HumanoidBtError: it is paused, and nobody is there to continue it.
            KeyboardInterrupt: somebody ended it; :attr:`report` is there all the same.
        """
        if not self._drive.begun or self._drive.report is not None:
            self.start()  # refuses a second time
        if self.breakpoints and not attended:
            raise HumanoidBtError("nobody continues a run() at its breakpoints: run_until() returns there")
        self._drive.debugger.attended = attended
        with ExitStack() as leaving:
            leaving.push(self)
            leaving.enter_context(self._drive.whole_ticks())
            while not self.outcome:
                if self.paused is not None and not attended:
                    raise HumanoidBtError(f"{self.paused}, and nobody continues it: run_until() returns then")
                self._go(self._drive.debugger.standing())
        return self.report

    def interrupt(self, reason: str) -> None:
        """End the run instead of the next step: the outcome is "interrupted", or "stopped" in an emergency stop.

        From any thread.
        """
        self._interruption = self._interruption or reason or "no reason was given"
        self._drive.ticks.interrupted(self._interruption)

    def close(self) -> None:
        """Bring the robot to a stand and close the recording; leaving the session does it. Twice is once."""
        self._drive.close()

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _traceback: TracebackType | None
    ) -> None:
        if error is not None:
            reason = "Ctrl-C" if isinstance(error, KeyboardInterrupt) else f"{type(error).__name__}: {error}"
            self._drive.leave("interrupted", reason)
        self.close()

    # ---- stopping and disturbing ------------------------------------------------------------------------------------

    def raise_estop(self, reason: str = "raised by the program", *, source: str = "program") -> None:
        """Raise the emergency stop. From any thread, at any time until the session has been left.

        Raises:
            HumanoidBtError: it has been left.
        """
        self._not_left("stopped")
        self._drive.engine.supervisor.raise_estop(source, reason)

    def request_reset(self, *, source: str = "program") -> None:
        """Ask for a reset of a latched stop before the next step; the answer comes as an event. From any thread.

        Raises:
            HumanoidBtError: the session has been left.
        """
        self._not_left("reset")
        self._drive.engine.request_reset(source)

    def push(self, force: Any, duration: float = 0.1, body: str = "") -> None:
        """Push the simulated robot from now on, in lockstep.

        Args:
            force: shape (3,), world frame [N], at most 10 kN in each direction.
            duration: how long [s].
            body: the body's name in the robot's model; the torso if "".

        Raises:
            UserError: there is no such body, the force or the duration is none, or the mode is realtime.
            HumanoidBtError: the session has been left.
        """
        self._not_left("pushed")
        try:
            vector = np.array(force, dtype=float)
        except (TypeError, ValueError):
            vector = np.zeros(0)
        if vector.shape != (3,) or not np.isfinite(vector).all():
            raise UserError(f"'force' must be three numbers [N], not {force!r}")
        for value in vector:
            limits.FORCE.take(float(value), "force")
        lasting = limits.POSITIVE.take(duration, "duration")
        self._drive.engine.push(body or self._drive.engine.robot.config.torso, vector, lasting)

    # ---- looking ----------------------------------------------------------------------------------------------------

    @property
    def tree(self) -> Tree:
        """The tree."""
        return self._drive.runner.tree

    @property
    def time(self) -> float:
        """Engine time of the last step [s]; 0 before the first."""
        return self.state.time if self._ticked else 0.0

    @property
    def state(self) -> State:
        """The robot's state at the last step.

        Raises:
            HumanoidBtError: there was none yet.
        """
        if (state := self._drive.loop.state) is None:
            raise HumanoidBtError("the robot's state is there after the first step()")
        return state

    @property
    def percepts(self) -> Mapping[str, Track]:
        """What has been seen so far by name, as skills see it: where it is, how old, how sure."""
        return Percepts(self._drive.tracks)

    @property
    def blackboard(self) -> Blackboard:
        """The tree's keys, to be read, and set until the run has ended."""
        return Blackboard(self.tree.keys, self._ticked, bool(self.outcome), self._drive.keep_key)

    def node(self, path: str) -> Node:
        """Return a node of the tree, with its status and feedback, by its path or the end of it."""
        return self.tree.node(path)

    @property
    def outcome(self) -> str:
        """How the run ended, as in the report; "" while it goes on."""
        return self._drive.end.outcome if self._drive.end else ""

    @property
    def report(self) -> Report:
        """What happened: there when :meth:`run` has returned, and after the ``with`` block or :meth:`close`.

        Raises:
            HumanoidBtError: the session has not been left yet.
        """
        if self._drive.report is None:
            now = f"the run has ended ({self.outcome}), and the" if self.outcome else "the"
            raise HumanoidBtError(f"{now} report is there after run(), after the 'with' block or after close()")
        return self._drive.report

    @property
    def robot_name(self) -> str:
        """The robot's name."""
        return self.engine.robot.config.name

    @property
    def scene_name(self) -> str:
        """The scene's name."""
        return self.engine.scene.config.name

    @property
    def engine(self) -> Engine:
        """Control, plant and perception, for those who measure them; what is in it may change."""
        return self._drive.engine

    @property
    def _ticked(self) -> bool:
        return self._drive.loop.state is not None

    def __repr__(self) -> str:
        now = self.outcome or ("running" if self._drive.running else "not begun")
        return f"<Session of {self.tree.name!r}: {now}, {self.time:.2f} s>"

    def _why_no_step(self) -> str:
        if self.outcome:
            return f"the run of {self.tree.name!r} has ended ({self.outcome}): a new Session runs it again"
        return "the session has not begun: use it as 'with session:', or call start()"


_ARGUMENTS = tuple(inspect.signature(Session).parameters)[1:-1]
