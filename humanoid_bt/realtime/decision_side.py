"""Realtime mode as decision sees it: the same few calls as lockstep, answered by other processes."""

from __future__ import annotations

import contextlib
import json
import os
import time
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import mujoco

from humanoid_bt.control.cycle_log import Layout
from humanoid_bt.core.clock import DECISION_PERIOD, HOLD_TIME
from humanoid_bt.core.errors import ControlLost, HumanoidBtError, UserError
from humanoid_bt.core.kept import Kept
from humanoid_bt.core.messages import Array, Command, Pause, Percept, State, Truth, frozen
from humanoid_bt.core.plain import plain
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.link.ring import RingReader, RingWriter
from humanoid_bt.link.run_folder import RunFolder, RunInfo, clean_stale, live_runs
from humanoid_bt.link.wire import (
    Event,
    decode_event,
    decode_percepts,
    decode_state,
    decode_truth,
    encode_command,
    encode_event,
    percepts_room,
    picture_room,
    state_room,
)
from humanoid_bt.perception.choice import Chosen, choose
from humanoid_bt.plant.rendering import View
from humanoid_bt.plant.scene import Scene
from humanoid_bt.plant.scene_config import widest_view
from humanoid_bt.plant.scene_model import scene_model
from humanoid_bt.plant.touches import Touch
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.channels import RunSpec
from humanoid_bt.realtime.children import Children
from humanoid_bt.realtime.gateway_calls import GatewayCalls
from humanoid_bt.realtime.gateway_life import GatewayLife, GatewayPlan
from humanoid_bt.realtime.live_tree import TreeTeller
from humanoid_bt.realtime.perception_life import PerceptionLife
from humanoid_bt.realtime.remote_supervisor import RemoteSupervisor, StateClock
from humanoid_bt.realtime.schedule import Schedule, last_core
from humanoid_bt.realtime.timing import StopRecord, Timing
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.tree.tree import Tree

_START_TIMEOUT = 120.0  # s until the first state must be there: control may have to be compiled first
_SILENCE = 1.0  # s without a new state after which control counts as lost
_POLL = 0.005  # s between two looks at processes that start or end
_READ = ("state", "stop", "notice", "refusal", "percept", "source", "truth", "timing")
_WRITTEN = ("command", "request")


class Realtime:
    """A robot in a scene whose control and perception run in processes of their own.

    Args:
        robot: the robot.
        scene: what surrounds it.
        hold: how long control goes on balancing the robot after decision died [s].
        sources: the percept sources as they are written, None for the simulated tracker; and their workspace.
        chosen: what they are; the simulated tracker if None.
        plant: where the plant is, if it is in another process, and the file with its key; "" for none.
        gateway: what joins the run with programs outside of it, if anything does.

    Attributes:
        clock: the engine's clock.
        model: MuJoCo's, of the whole scene.
        supervisor: what is known of the supervisor.
        notices: what happened in other processes so far: (time [s], level, text).
        inputs: keys of the blackboard that a program set, and answers to calls; what else comes from outside is sensed.
        calls: what carries calls to other programs, None without a gateway.
        external_force_max: largest external force on any body; known after :meth:`close`.
        touches: what of the scene the robot has touched; known after :meth:`close`.
        truth: where the simulated robot really was lately, None before control says it.
        unseen: percepts that were never published so far, and why.
    """

    def __init__(
        self,
        robot: RobotModel,
        scene: Scene,
        hold: float = HOLD_TIME,
        *,
        sources: tuple[Any, str] = (None, ""),
        chosen: Sequence[Chosen] | None = None,
        plant: tuple[str, str] = ("", ""),
        gateway: GatewayPlan | None = None,
    ) -> None:
        self.robot, self.scene = robot, scene
        self._chosen = choose(None, Workspace(), scene.config) if chosen is None else chosen
        self.publishes = [name for one in self._chosen for name in one.names]
        self._sources, self._plant = sources, plant
        self._gateway_plan = gateway
        self._gateway: GatewayLife | None = None
        self.calls = None if gateway is None else GatewayCalls(gateway.check_call)
        if gateway is not None:
            self.publishes += [name for name in gateway.percepts if name not in self.publishes]
        self.clock = StateClock()
        self.model: mujoco.MjModel = scene_model(robot, scene)
        self.supervisor = RemoteSupervisor()
        self.notices: Kept[Event] = Kept()
        self.inputs: Kept[Any] = Kept()
        self.external_force_max = 0.0
        self.touches: list[Touch] = []
        self.timing = Timing()
        self.truth: Truth | None = None
        self.unseen: Mapping[str, str] = {}
        self._hold = hold
        self._folder: RunFolder | None = None
        self._children: Children | None = None
        self._teller: TreeTeller | None = None
        self._perception: PerceptionLife | None = None
        self._writers: dict[str, RingWriter] = {}
        self._readers: dict[str, RingReader] = {}
        self._percepts: dict[str, Percept] = {}
        self._read: dict[str, int] = dict.fromkeys(_READ, 0)
        self._state: State | None = None
        self._state_at = 0.0
        self._commands = False  # with its last command decision wanted something of the robot
        self._over = False
        self._logs = False

    # ---- life -------------------------------------------------------------------------------------------------------

    def start(self, info: RunInfo, log: Path | None = None) -> None:
        """Start the other processes and wait until the robot stands and perception has had a first look.

        Args:
            info: what runs, for ``humanoid-bt status``.
            log: file in which control notes what happens.

        Raises:
            HumanoidBtError: control or perception did not come up. Call :meth:`close` all the same.
        """
        clean_stale()
        folder = self._folder = RunFolder.create(info)
        told = f"the id of this run, for estop, reset and status: {folder.info.run_id}"
        self.notices.append(Event(self.clock.now(), "info", told))
        others = [run for run, _ in live_runs() if run.folder != folder.folder]  # one that begins now sees this one
        core = None if others else last_core()  # two servo loops on one processor would starve each other
        try:
            self._spec(core, log).write(folder)
            if log is not None:
                log.unlink(missing_ok=True)
        except OSError as error:
            raise HumanoidBtError(f"{error.filename} cannot be written: {error.strerror}") from error
        rooms = {"state": state_room(self.robot.joint_names), "percept": percepts_room(self.publishes)}
        channels.create_channels(folder, **rooms)
        if self.cycle_tables is not None:
            Layout.of(self.robot.joint_names).create(*self.cycle_tables)
        if self._gateway_plan is not None and self._gateway_plan.pictures:
            view = View(self.robot.config.gaze.body, *widest_view(self.scene.config))
            channels.create_picture_channel(folder, picture_room(*view.size))
        self._writers = {name: channels.writer(folder, name) for name in _WRITTEN}
        self._readers = {name: channels.reader(folder, name) for name in _READ}
        self._teller = TreeTeller(folder)
        self.supervisor.connect(channels.estop(folder))
        children = self._children = Children(folder)
        children.start("control", "humanoid_bt.realtime.control_process")
        self._wait(children, "control", "state")
        self._perception = PerceptionLife(folder, children, self._chosen, self._readers["percept"])
        self._perception.start()
        self._wait(children, "perception", "percept")
        if self._gateway_plan is not None and self.calls is not None:
            self._gateway = GatewayLife(self._gateway_plan, folder, children, self.calls)
            self._gateway.start()
        self._schedule = Schedule(DECISION_PERIOD, spin=False)
        self._state_at = time.monotonic()

    def log_cycles(self) -> None:
        """Have every servo cycle kept in :attr:`cycle_tables`."""
        self._logs = True

    @property
    def cycle_tables(self) -> tuple[Path, Path] | None:
        """The files in which plans and servo cycles are kept, once it has started."""
        return channels.cycle_tables(self._folder) if self._logs and self._folder is not None else None

    def take_cycles(self) -> None:
        """None: they are in :attr:`cycle_tables`."""

    def _wait(self, children: Children, role: str, channel: str) -> None:
        """Wait until a process writes to its channel."""
        deadline = time.monotonic() + _START_TIMEOUT
        while not self._readers[channel].sequence:
            for known in {"control", role}:
                if how := children.how_ended(known):
                    if self._folder is not None and (mistakes := channels.left_mistakes(self._folder)):
                        raise UserError(mistakes)
                    raise self._lost(known, how)
            if time.monotonic() > deadline:
                busy = self._perception.at_work if self._perception is not None else []
                why = f": the percept source {' and '.join(map(repr, busy))} is at work" if busy else ""
                raise HumanoidBtError(f"the {role} process did not start within {_START_TIMEOUT:g} s{why}")
            time.sleep(_POLL)

    def _spec(self, core: int | None, log: Path | None) -> RunSpec:
        return RunSpec(
            robot=str(self.robot.config.path.resolve()),
            scene=str(self.scene.config.path.resolve()),
            seed=self.scene.seed,
            core=core,
            log=str(log.resolve()) if log is not None else "",
            hold=self._hold,
            parent=os.getpid(),
            body=self.robot.config.body.walk,
            perception=plain(self._sources[0]),
            workspace=self._sources[1],
            plant=self._plant[0],
            key=self._plant[1],
            gateway=str(self._gateway_plan.file.resolve()) if self._gateway_plan else "",
            joints=tuple(self.robot.joint_names),
        )

    def abandon(self) -> str:
        """End the run without waiting: control brings the robot to a stand by itself, ends, and cleans up."""
        folder, self._folder = self._folder, None
        if folder is None or self._children is None or self._children.how_ended("control"):
            self._folder = folder
            return ""
        channels.quit_flag(folder).beat(channels.ABANDONED)
        if channels.has_left(folder):  # it may not have seen this any more
            self._folder = folder
            return ""
        folder.leave()
        return "control brings the robot to a stand and ends by itself"

    def close(self) -> None:
        """Wait until control has brought the robot to a stand, end all processes, remove what they shared.

        Whoever interrupts this does not wait: see :meth:`abandon`.
        """
        self._over = True
        try:
            self.supervisor.disconnect()
            if self._folder is not None and self._children is not None:
                self._end(self._folder, self._children)
        except BaseException:
            self.abandon()
            raise
        finally:
            folder, self._folder = self._folder, None
            if folder is not None:
                folder.close()
            if self._teller is not None:
                self._teller.close()
            if self._gateway is not None:
                self._gateway.close()
            if self._perception is not None:
                self._perception.close()
            for writer in self._writers.values():
                writer.close()
            for reader in self._readers.values():
                reader.close()

    def _end(self, folder: RunFolder, children: Children) -> None:
        channels.quit_flag(folder).beat()
        while not children.how_ended("control") and self._hear_control() < _SILENCE:
            time.sleep(_POLL)
        children.end()
        self._follow_readers()
        result = folder.path("result.json")
        with contextlib.suppress(OSError, ValueError):  # not there if control was killed
            told = json.loads(result.read_text(encoding="utf-8"))
            self.external_force_max = told["external_force_max"]
            self.touches = [Touch(**touch) for touch in told["touches"]]

    # ---- the loop ---------------------------------------------------------------------------------------------------

    def sense(self) -> tuple[State, dict[str, Percept]]:
        """Wait for the next tick; return the latest state and percepts.

        Raises:
            ControlLost: control is gone.
        """
        assert self._children is not None
        self._schedule.wait()
        silent = self._hear_control()
        self._check_control(self._children)
        if silent > _SILENCE:
            raise ControlLost(f"the control process has been silent for more than {_SILENCE:g} s")
        assert self._state is not None
        self.clock.time = self._state.time
        if self._perception is not None and (told := self._perception.look()):
            self.unseen = dict.fromkeys(self.unseen, told)
            self.notices.append(Event(self.clock.now(), "error", told))
        if self._gateway is not None and self._gateway_plan is not None:
            self._hear_gateway(self._gateway, self._gateway_plan.percepts)
        return self._state, dict(self._percepts)

    @property
    def hold(self) -> Pause | None:
        """Why the tree is to stand still and control to hold the robot: the gateway is gone; None while it is there."""
        return self._gateway.hold if self._gateway is not None else None

    def _hear_gateway(self, gateway: GatewayLife, names: Collection[str]) -> None:
        """Take what came from outside: of the percepts of these names nothing else counts."""
        gateway.look()
        for name in names:
            self._percepts.pop(name, None)
        self._percepts |= gateway.percepts
        others = {name: why for name, why in self.unseen.items() if name not in names}
        self.unseen = {**others, **gateway.unseen}
        for number, answer in self.calls.take_news() if self.calls is not None else ():
            if answer.final:
                self.inputs.append((self.clock.now(), "answer", [number, plain(answer)]))
        for level, text in gateway.take_news():
            self.notices.append(Event(self.clock.now(), level, text))

    def request_reset(self, source: str) -> None:
        """Ask control for a reset; its answer comes as a notice."""
        self.supervisor.request_reset(source)

    def submit(self, command: Command) -> None:
        """Give a command to control. It counts as decision's sign of life, so it comes after a whole tick."""
        for source, reason in self.supervisor.take_requests():
            self._writers["request"].write(encode_event(Event(self.clock.now(), "error", f"{source}: {reason}")))
        self._commands = bool(command.targets)
        self._writers["command"].write(encode_command(command))

    def advance(self) -> None:
        """Nothing: the wall clock goes on by itself, and :meth:`sense` waits for the next tick."""

    def push(self, body: str, force: Array, duration: float) -> None:
        """Refuse: only in lockstep somebody pushes the simulated robot.

        Raises:
            UserError: always.
        """
        raise UserError("the robot cannot be pushed in realtime mode", hint="valid: mode='lockstep'")

    def publish(self, status: Mapping[str, object], tree: Tree) -> None:
        """Tell ``humanoid-bt status`` and ``show --live`` what the tree does."""
        if self._teller is not None:
            self._teller.tell(status, tree)

    @property
    def shows_parameters(self) -> bool:
        """Whether other programs see the parameters of the tree, through the gateway."""
        return self._gateway_plan is not None and self._gateway_plan.parameters

    def show_parameters(self, shown: Sequence[Mapping[str, Any]]) -> None:
        """Show them the parameters of the tree, as data for JSON."""
        if self._gateway is not None:
            self._gateway.show_parameters(shown)

    def take_settings(self) -> list[dict[str, Any]]:
        """Return which parameters they want to be set, since the last time."""
        return self._gateway.take_settings() if self._gateway is not None else []

    @property
    def takes_orders(self) -> bool:
        """Whether the tree runs once for every goal from outside, and not from the start."""
        return self._gateway_plan is not None and self._gateway_plan.orders

    def take_orders(self) -> list[dict[str, Any]]:
        """Return the goals that came, or were canceled, since the last time."""
        return self._gateway.take_orders() if self._gateway is not None else []

    def announce(self, kind: str, values: Mapping[str, object]) -> None:
        """Tell programs outside of the run what happened, if a gateway joins it with any."""
        if self._gateway is not None:
            self._gateway.tell(kind, values)

    def _hear_control(self) -> float:
        """Read what the other processes say; return how long control had been silent when this looked [s].

        Not how long that is ago by now: this process may have stood still since.
        """
        looked = time.monotonic()
        self._follow_readers()
        return looked - self._state_at

    def _follow_readers(self) -> None:
        for payload in self._new("state"):
            self._state = frozen(decode_state(payload))
            self._state_at = time.monotonic()
        for payload in self._new("stop"):
            if self._commands or not self._over:  # else decision is silent because it has done its work
                self.supervisor.note(StopRecord.from_bytes(payload))
        for payload in self._new("percept"):
            seen, self.unseen = decode_percepts(payload)
            self._percepts |= {percept.name: percept for percept in seen}
        for payload in (*self._new("notice"), *self._new("source")):
            self.notices.append(decode_event(payload))
        for payload in self._new("refusal"):
            self.supervisor.rejected.append(payload.decode(errors="replace"))
        latest = self._readers["truth"].latest()
        if latest is not None:
            self.truth = decode_truth(latest[1])
        latest = self._readers["timing"].latest()
        if latest is not None:
            self.timing = Timing.from_bytes(latest[1])

    def _new(self, name: str) -> list[bytes]:
        entries, _ = self._readers[name].since(self._read[name])
        if entries:
            self._read[name] = entries[-1][0]
        return [payload for _, payload in entries]

    def _check_control(self, children: Children) -> None:
        if how := children.how_ended("control"):
            raise self._lost("control", how)

    def _lost(self, role: str, how: str) -> ControlLost:
        """Return that nobody controls the robot any more: why control could not go on, or how a process ended."""
        why = channels.why_lost(self._folder) if self._folder is not None else ""
        return ControlLost(why or f"the {role} process ended ({how})")
