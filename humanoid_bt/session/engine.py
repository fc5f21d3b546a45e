"""What a run needs of the loops below the tree, whichever way they are wired: in lockstep or as processes."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple, Protocol

import mujoco

from humanoid_bt.control.supervisor import Stop
from humanoid_bt.core.clock import Clock
from humanoid_bt.core.kept import Kept
from humanoid_bt.core.messages import Array, Command, Pause, Percept, State, Truth
from humanoid_bt.decision.calls import Calls
from humanoid_bt.link.run_folder import RunInfo
from humanoid_bt.link.wire import Event
from humanoid_bt.plant.scene import Scene
from humanoid_bt.plant.touches import Touch
from humanoid_bt.realtime.timing import Timing
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.tree.tree import Tree


class Input(NamedTuple):
    """What came from outside of the run, and is not what was sensed: with it, the run can be run again.

    Attributes:
        time: engine time from which on it counts [s].
        kind: push, reset, reset_after_tick, key, set, force, answer.
        value: as data for JSON.
    """

    time: float
    kind: str
    value: Any


class SupervisorView(Protocol):
    """What decision sees of the supervisor: stops and refusals so far, and a way to ask for a stop."""

    stops: Kept[Stop]
    rejected: Kept[str]

    def raise_estop(self, source: str, reason: str) -> None:
        """Raise the emergency stop. From any thread."""

    def request_stop(self, source: str, reason: str) -> None:
        """Ask for a protective stop until the end of the run."""


class Engine(Protocol):
    """Control, plant and perception of one run."""

    robot: RobotModel
    scene: Scene
    notices: Kept[Event]

    @property
    def clock(self) -> Clock:
        """The engine's clock."""

    @property
    def model(self) -> mujoco.MjModel:
        """MuJoCo's model of the robot in its scene."""

    @property
    def supervisor(self) -> SupervisorView:
        """The supervisor, or what is known of it."""

    @property
    def truth(self) -> Truth | None:
        """Where the robot really is, None if nobody knows."""

    @property
    def external_force_max(self) -> float:
        """Largest external force or torque on any body [N, Nm]; final after :meth:`close`."""

    @property
    def touches(self) -> Sequence[Touch]:
        """What of the scene the robot has touched, as only the simulation knows; final after :meth:`close`."""

    @property
    def timing(self) -> Timing | None:
        """How punctual the servo is; None where there is no wall clock to be late for."""

    @property
    def inputs(self) -> Kept[Input]:
        """What came from outside so far, and is not what was sensed."""

    @property
    def publishes(self) -> Collection[str]:
        """The percepts that its sources publish."""

    @property
    def calls(self) -> Calls | None:
        """What carries calls of the tree to other programs, None where nothing does."""

    @property
    def hold(self) -> Pause | None:
        """Why the tree is to stand still and control to hold the robot; None while nothing keeps it."""

    @property
    def unseen(self) -> Mapping[str, str]:
        """The percepts that were never published so far, and why."""

    def start(self, info: RunInfo, log: Path | None = None) -> None:
        """Begin; the robot stands.

        Args:
            info: what runs, for ``humanoid-bt status``.
            log: file in which control notes what happens, where it is a process of its own.

        Raises:
            UserError: a percept source cannot begin.
        """

    def log_cycles(self) -> None:
        """Keep every servo cycle for whoever takes them; before :meth:`start`."""

    @property
    def cycle_tables(self) -> tuple[Path, Path] | None:
        """The files in which plans and servo cycles are kept, None where :meth:`take_cycles` gives them."""

    def take_cycles(self) -> tuple[Array, Array] | None:
        """Return the rows of plans and servo cycles since the last time; None if there are files of them, or none."""

    def close(self) -> None:
        """End everything that was started."""

    def abandon(self) -> str:
        """End the run without waiting for the robot to stand; return what becomes of it, "" if nothing does."""

    def request_reset(self, source: str) -> None:
        """Ask for a reset of a latched stop; the answer comes as a notice. From any thread."""

    def sense(self) -> tuple[State, Mapping[str, Percept]]:
        """Return the state and the latest percepts, for one tick."""

    def submit(self, command: Command) -> None:
        """Give the command of a tick to control."""

    def advance(self) -> None:
        """Let one period of decision pass, where time is simulated; the wall clock goes on by itself."""

    def push(self, body: str, force: Array, duration: float) -> None:
        """Push a body with a force, shape (3,), world frame [N], for a time [s].

        Raises:
            UserError: there is no such body, or nobody can push it.
        """

    @property
    def shows_parameters(self) -> bool:
        """Whether other programs see the parameters of the tree, and may set them."""

    def show_parameters(self, shown: Sequence[Mapping[str, Any]]) -> None:
        """Show other programs the parameters of the tree, as data for JSON."""

    def take_settings(self) -> Sequence[Mapping[str, Any]]:
        """Return which parameters others want to be set, since the last time: number, name, value, source, at.

        Each is answered with :meth:`announce`, of the kind ``setting``; ``at`` is on the monotonic clock [s].
        """

    @property
    def takes_orders(self) -> bool:
        """Whether the tree runs once for every goal from outside, and not from the start."""

    def take_orders(self) -> Sequence[Mapping[str, Any]]:
        """Return the goals that came, or were canceled, since the last time."""

    def announce(self, kind: Literal["node", "event", "goal", "setting"], values: Mapping[str, object]) -> None:
        """Tell programs outside of the run what happened.

        Args:
            kind: what it is.
            values: as data for JSON.
        """

    def publish(self, status: Mapping[str, object], tree: Tree) -> None:
        """Tell whoever looks from outside what the tree does."""
