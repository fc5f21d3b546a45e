"""Runs that a gateway joins with real nodes of ROS 2 on this machine."""

from __future__ import annotations

import contextlib
import json
import re
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from humanoid_bt.core.messages import Mode
from humanoid_bt.gateway.file import Qos
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.timing import StopRecord
from tests.gateway.nodes import Peer, ball, punctual
from tests.realtime.helpers import Live, until

pytestmark = [pytest.mark.ros, pytest.mark.realtime]

LATCHED = Qos(reliability="reliable", durability="transient_local", depth=1)
STOPS = 15


def said(messages: list[Any]) -> list[dict[str, Any]]:
    return [json.loads(message.data) for message in list(messages)]


def changes(peer: Peer) -> dict[str, str]:
    """Return the last status of every node whose status changed, by the end of its path."""
    return {change["path"].rpartition("/")[2]: change["status"] for change in said(peer.heard["/nodes"])}


def test_fetch_is_driven_by_a_node_and_told_to_others(live: Callable[..., Live], peer: Peer) -> None:
    from diagnostic_msgs.msg import DiagnosticArray
    from nav_msgs.msg import Odometry
    from sensor_msgs.msg import JointState
    from std_msgs.msg import String

    peer.hears(JointState, "/joint_states")
    peer.hears(Odometry, "/odom")
    peer.hears(DiagnosticArray, "/diagnostics")
    for topic in ("/status", "/command", "/nodes", "/events"):
        peer.hears(String, topic)
    peer.hears(String, "/robot_description", LATCHED)
    run = live("fetch", "--duration", "60")
    until("the gateway is heard", lambda: all(peer.heard[topic] for topic in ("/odom", "/status", "/command")))
    with ball():
        code = run.ends()
    assert code == 0, run.output
    assert run.report["percepts"]["target"]["confidence"] == 0.9
    assert run.report["odometry"]["off"] < 0.1

    joints = peer.heard["/joint_states"]
    assert len(joints) > 100
    assert len(joints[-1].position) == len(joints[-1].velocity) == len(joints[-1].name)
    assert abs(joints[-1].header.stamp.sec - time.time()) < 20
    way = peer.heard["/odom"]
    assert (way[-1].header.frame_id, way[-1].child_frame_id) == ("odom", "base_link")
    assert way[-1].pose.pose.position.x - way[0].pose.pose.position.x > 1.0  # it walked there
    assert max(message.twist.twist.linear.x for message in way) > 0.2
    statuses = peer.heard["/diagnostics"][-1].status
    parts = [one.name.removeprefix("humanoid_bt: ") for one in statuses]
    assert parts == ["supervisor", "tree", "percepts", "control"]
    assert any("RUNNING" in status["nodes"].values() for status in said(peer.heard["/status"]))
    done = [(change["path"].rpartition("/")[2], change["status"]) for change in said(peer.heard["/nodes"])]
    assert done.index(("approach", "RUNNING")) < done.index(("reach", "SUCCESS"))  # a busy machine may stop it near by
    assert "base" in {name for command in said(peer.heard["/command"]) for name in command["targets"]}
    assert "the tree ended: success" in [event["text"] for event in said(peer.heard["/events"])]
    assert "<mujoco" in peer.heard["/robot_description"][0].data


def test_an_estop_of_a_node_is_in_force_within_10_ms(live: Callable[..., Live], peer: Peer) -> None:
    from rclpy.duration import Duration
    from std_msgs.msg import Bool
    from std_srvs.srv import Trigger

    run = live("stand", "--duration", "120")
    for role in ("gateway", "gateway_estop"):
        until("it listens on this machine alone", lambda role=role: listening(run.pids[role]) == {"127.0.0.1"})
    stop, reset = peer.publisher(Bool, "/estop"), peer.client(Trigger, "/reset")
    stops = channels.reader(run.folder, "stop")
    took = []
    with punctual():
        for number in range(STOPS):
            until("the robot is free", lambda: run.state.mode is Mode.RUN)
            read, began = stops.sequence, time.monotonic_ns()
            stop.publish(Bool(data=True))
            until("the stop", lambda read=read: stops.sequence > read)
            record = StopRecord.from_bytes(stops.since(read)[0][-1][1])
            assert (record.source, record.reason) == ("ROS 2", "/estop is true")
            took.append((record.at - began) / 1e6)
            stop.publish(Bool(data=False))
            assert stop.wait_for_all_acked(Duration(seconds=5))
            later = run.state.time + 0.1
            until("control has gone on", lambda later=later: run.state.time > later)
            assert run.state.mode is Mode.EMERGENCY_STOP, f"false is no reset ({number})"
            assert reset.call(Trigger.Request(), timeout_sec=5).success
    assert np.percentile(took, 80) < 10, took  # a virtual machine stands still now and then


def test_an_estop_topic_that_is_silent_stops_the_robot(live: Callable[..., Live], peer: Peer) -> None:
    from std_msgs.msg import Bool
    from std_srvs.srv import Trigger

    run = live("stand", "--duration", "120", gateway="silence")
    stops = channels.reader(run.folder, "stop")
    reasons = lambda: [StopRecord.from_bytes(data).reason for _, data in stops.since(0)[0]]  # noqa: E731 (read thrice)
    never, silent = "nobody has been heard yet on /estop, for more than 1 s", "/estop has been silent for more than 1 s"
    until("a stop, for nobody is there", lambda: never in reasons())
    stop, reset = peer.publisher(Bool, "/estop"), peer.client(Trigger, "/reset")

    def free() -> bool:
        stop.publish(Bool(data=False))
        return run.state.mode is Mode.RUN

    assert not free(), "a word is no reset"
    assert reset.call(Trigger.Request(), timeout_sec=5).success
    until("the robot is free", free)
    assert silent not in reasons()
    until("a stop, for it is silent again", lambda: silent in reasons())


def listening(process: int) -> set[str]:
    """Return the addresses on which a process has UDP sockets at the ports of DDS."""
    files = [Path(f"/proc/{process}/fd/{name.name}") for name in Path(f"/proc/{process}/fd").iterdir()]
    own = set[str]()
    for file in files:
        with contextlib.suppress(FileNotFoundError):  # it was closed meanwhile
            own.add(str(file.readlink()))
    found = set()
    for line in Path(f"/proc/{process}/net/udp").read_text().splitlines()[1:]:
        parts = line.split()
        address, port = parts[1].split(":")
        if f"socket:[{parts[9]}]" in own and 7000 <= int(port, 16) < 32768:
            found.add(".".join(str(int(address[at : at + 2], 16)) for at in (6, 4, 2, 0)))
    return found


def test_a_node_that_dies_leaves_percepts_that_are_stale(live: Callable[..., Live]) -> None:
    with ball() as node:
        run = live("fetch", "--duration", "60")
        run.walks()
        node.kill()
        until("the watchdog's answer", lambda: re.search(r"approach +halted: ", run.output) is not None)
        until("the robot stands", lambda: run.state.base_settled)
        until("it is told", lambda: "gateway: no message on /ball for 1 s" in run.output)


def test_without_its_gateway_the_robot_is_held_and_then_the_run_goes_on(live: Callable[..., Live]) -> None:
    run = live("walk", "--duration", "60")
    for role, number in (("gateway", signal.SIGKILL), ("gateway", signal.SIGSTOP), ("gateway_estop", signal.SIGKILL)):
        run.walks()
        run.kill(role, number)
        until("control holds the robot", lambda: run.state.mode is Mode.PAUSED)
        until("it goes on", lambda: run.state.mode is Mode.RUN)
        assert run.folder.info.processes[role] != run.pids[role]
        run.pids = dict(run.folder.info.processes)
    run.walks()
    run.process.send_signal(signal.SIGINT)
    run.ends()
    texts = [event["text"] for event in run.report["events"]]
    gone = [text.partition(" is back: ")[2] for text in texts if "is gone, and control holds the robot" in text]
    assert {"its process ended (killed by signal 9)", "it does not answer"} == set(gone)
    back = [f"the {role} is there again: the tree goes on" for role in ("gateway", "gateway_estop")]
    assert {text for text in texts if "is there again" in text} == set(back)


def test_messages_that_cannot_be_used_are_told_and_move_nothing(live: Callable[..., Live], peer: Peer) -> None:
    from geometry_msgs.msg import PoseStamped
    from std_msgs.msg import Bool

    run = live("fetch", "--duration", "60", "--on-estop", "end")
    publisher = peer.publisher(PoseStamped, "/ball")
    message = PoseStamped()
    message.header.frame_id = "base_link"
    message.header.stamp = peer.node.get_clock().now().to_msg()
    message.pose.position.x = float("nan")

    def told() -> bool:
        publisher.publish(message)
        return "a message on /ball is refused" in run.output

    until("the message is refused", told)
    unfit = Qos(reliability="best_effort", durability="volatile", depth=1)
    peer.publisher(Bool, "/estop", unfit, heard=False)
    assert run.ends() == 3, run.output
    texts = [event["text"] for event in run.report["events"]]
    assert len([text for text in texts if text.startswith("gateway: a message on /ball is refused")]) == 1, texts
    assert any("a publisher of /estop is not heard: its reliability" in text for text in texts)
    assert "target" not in run.report["percepts"]


def test_the_tree_runs_for_every_goal_of_an_action(live: Callable[..., Live], peer: Peer) -> None:
    from action_msgs.msg import GoalStatus
    from test_msgs.action import Fibonacci

    run = live("rest", gateway="action")
    client, heard = peer.action_client(Fibonacci, "/rest"), []

    def send(duration: int) -> Any:
        return done(client.send_goal_async(Fibonacci.Goal(order=duration), feedback_callback=heard.append))

    first = send(1)
    assert first.accepted
    assert not send(1).accepted  # another one is at work
    assert done(first.get_result_async()).status == GoalStatus.STATUS_SUCCEEDED
    assert heard
    assert done(send(0).get_result_async()).status == GoalStatus.STATUS_ABORTED  # a duration is above 0
    endless = send(1000)
    assert done(endless.cancel_goal_async()).goals_canceling
    assert done(endless.get_result_async()).status == GoalStatus.STATUS_CANCELED
    assert done(send(1).get_result_async()).status == GoalStatus.STATUS_SUCCEEDED
    run.process.send_signal(signal.SIGINT)
    run.ends()
    texts = [event["text"] for event in run.report["events"]]
    assert texts.count("the tree ended: success; waiting for a goal") == 2
    client.destroy()


def done(future: Any) -> Any:
    """Return what a future holds once it does."""
    until("an answer", future.done)
    return future.result()


def test_types_that_are_not_installed_are_told_before_the_run(project: Path, tmp_path: Path) -> None:
    import humanoid_bt as hbt

    file = tmp_path / "gateway.yaml"
    file.write_text(
        "format: 1\npercepts:\n"
        "  cup: {topic: /cups, type: lab_msgs/Cup, fields: {x: a, y: b, z: c}}\n"
        "  ball: {topic: /ball, type: geometry_msgs/PoseStampt, fields: {x: a, y: b, z: c}}\n"
    )
    with pytest.raises(hbt.UserError) as told:
        hbt.Session("fetch", mode="realtime", gateway=file)
    first, second = told.value.problems
    assert "package 'lab_msgs' of ROS 2, of 'lab_msgs/Cup', is not installed" in first.message
    assert str(first.place).endswith("gateway.yaml:3:29")
    assert "humanoid-bt interfaces FOLDER of its definitions builds one" in first.hint
    assert "did you mean 'PoseStamped'?" in second.hint


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ("feedback: {sequence: node}", "the feedback does not take the node: 'sequence' cannot be text: it is of type"),
        ("result: {sequnce: reason}", "the result does not take the reason: there is no field 'sequnce'"),
    ],
)
def test_fields_that_an_action_does_not_have_are_told_before_the_run(tmp_path: Path, fields: str, message: str) -> None:
    import humanoid_bt as hbt

    file = tmp_path / "gateway.yaml"
    file.write_text(f"format: 1\naction: {{name: /rest, type: test_msgs/action/Fibonacci, {fields}}}\n")
    with pytest.raises(hbt.UserError) as told:
        hbt.Session("fetch", mode="realtime", gateway=file)
    (problem,) = told.value.problems
    assert message in problem.message
    assert str(problem.place).partition("gateway.yaml:")[2].startswith("2:")
