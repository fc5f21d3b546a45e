"""The gateway process: from topics to the channels of a run, and back, until the run ends or decision dies."""

from __future__ import annotations

import queue
import time
from contextlib import ExitStack
from functools import partial
from pathlib import Path

from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.messages import Level
from humanoid_bt.files import document
from humanoid_bt.gateway.action import ActionServer
from humanoid_bt.gateway.calls import Caller
from humanoid_bt.gateway.check import check_types
from humanoid_bt.gateway.clock import EngineClock
from humanoid_bt.gateway.file import GatewayFile, load_gateway
from humanoid_bt.gateway.frames import FrameTree
from humanoid_bt.gateway.inbox import Inbox
from humanoid_bt.gateway.node import Ears, confine
from humanoid_bt.gateway.parameters import TreeParameters
from humanoid_bt.gateway.publishing import Publishers, wants_pictures
from humanoid_bt.gateway.qos import SENSOR, profile
from humanoid_bt.gateway.snapshot import RunView
from humanoid_bt.gateway.transforms import listen_to_transforms
from humanoid_bt.link.run_folder import RunFolder
from humanoid_bt.link.wire import Event, Sight, encode_event, encode_percepts
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.channels import RunSpec
from humanoid_bt.realtime.children import GATEWAY_PARTING
from humanoid_bt.realtime.side_process import take_part, turns
from humanoid_bt.robot.model_file import model_file


class Gateway:
    """One gateway at work.

    Args:
        folder: of the run.
        spec: of the run.
        config: the gateway file.
        stack: closes what it opens.

    Raises:
        UserError: ROS 2 or a type is not installed.
    """

    def __init__(self, folder: RunFolder, spec: RunSpec, config: GatewayFile, stack: ExitStack) -> None:
        import rclpy  # noqa: PLC0415 (part of the extra)
        from rclpy.context import Context  # noqa: PLC0415 (likewise)

        self._news: queue.SimpleQueue[tuple[Level, str]] = queue.SimpleQueue()
        self._percepts = channels.writer(folder, "gateway_percept")
        self._events = channels.writer(folder, "gateway_news")
        context = Context()
        rclpy.init(args=[], context=context)
        stack.callback(context.try_shutdown)
        shows = config.parameters != "none"
        self._ears = ears = Ears(context, config.node, self._note, parameters=shows)
        node = ears.node
        self._clock = EngineClock(lambda: node.get_clock().now().nanoseconds * 1e-9)
        self._frames = FrameTree(config.frames)
        self._inbox = Inbox(config.percepts, self._frames, self._clock, config.frames.base, self._note)
        for percept, topic in config.percepts.items():
            qos = profile(topic.qos, SENSOR)
            ears.listen(topic.topic, topic.type, qos, partial(self._inbox.take, percept))
        if config.frames.tf:
            listen_to_transforms(ears, self._frames, self._clock)
        self._view = RunView(folder, spec.joints, config.frames, self._clock)
        self._action: ActionServer | None = None
        if config.action is not None:
            orders = channels.writer(folder, "gateway_order")
            self._action = ActionServer(ears, config.action, orders, self._note)
        calls, answers = channels.reader(folder, "gateway_call"), channels.writer(folder, "gateway_answer")
        self._caller = Caller(ears, calls, answers, str(folder.path("spec.json")), self._note)
        self._parameters: TreeParameters | None = None
        if shows:
            shown, ask = channels.reader(folder, "gateway_parameters"), channels.writer(folder, "gateway_setting")
            self._parameters = TreeParameters(ears, shown, ask.write, config.parameters == "set")
        self._publishers = Publishers(node, config)
        if config.publish.robot_description is not None:
            self._publishers.latch("robot_description", _description(Path(spec.robot)))
        if wants_pictures(config) and not channels.has_pictures(folder):
            self._note("warning", "no percept source of this run looks with the head camera: no pictures are published")
        ears.begin()
        stack.callback(ears.end)
        stack.callback(self._cancel_goals)

    def turn(self) -> None:
        """Pass on what has come, publish what is due, and give a sign of life.

        Raises:
            RuntimeError: the node does not hear any more.
        """
        self._ears.check()
        state = self._view.state()
        if state is not None:
            if jump := self._clock.look(state.time):
                self._inbox.forget_stamps()
                self._note("warning", f"ROS time jumped by {jump:+.2f} s; stamps are taken by the new time")
            self._frames.base_at(state.time, state.base_position, state.base_quaternion)
        self._percepts.write(encode_percepts(Sight(self._inbox.flush(), dict(self._inbox.unseen))))
        while not self._news.empty():
            level, text = self._news.get()
            self._events.write(encode_event(Event(self._clock.engine_time, level, f"gateway: {text}")))
        for values in self._view.told():
            kind = values.pop("kind")
            if kind == "goal" and self._action is not None:
                self._action.told(values)
            if kind == "setting" and self._parameters is not None:
                self._parameters.told(values)
            self._publishers.tell(f"{kind}s", {"stamp": self._clock.ros(values["time"]), **values})
        if (picture := self._view.picture()) is not None:
            self._publishers.show(picture, self._clock.ros(picture.time))
        if state is not None:
            now = self._view.snapshot(state)
            self._publishers.publish(now)
            if self._action is not None:
                self._action.feed_back(now)

    def _cancel_goals(self) -> None:
        """Let no goal of others go on that the tree has asked for: the run is over, or decision is gone."""
        self._caller.end()
        deadline = time.monotonic() + GATEWAY_PARTING
        while not self._caller.idle and time.monotonic() < deadline:
            time.sleep(DECISION_PERIOD)

    def _note(self, level: Level, text: str) -> None:
        self._news.put((level, text))


def _description(robot: Path) -> str:
    """Return the text of a robot's model."""
    model: str = document.load(robot).value["model"].value
    return model_file(model, robot.parent).read_text(encoding="utf-8", errors="replace")


def run(folder: RunFolder) -> None:
    """Work until decision ends the run or dies.

    Raises:
        UserError: ROS 2 or a type is not installed, or the file has mistakes.
    """
    spec = RunSpec.read(folder)
    config = load_gateway(Path(spec.gateway))
    check_types(config)
    confine(config.network)
    with ExitStack() as stack:
        gateway = Gateway(folder, spec, config, stack)
        for _ in turns(folder, spec, DECISION_PERIOD):
            gateway.turn()


if __name__ == "__main__":
    raise SystemExit(take_part(run))
