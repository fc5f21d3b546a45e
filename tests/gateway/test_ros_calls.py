"""Trees that call services and send goals to actions of real nodes of ROS 2 on this machine."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

import humanoid_bt as hbt
from tests.gateway.nodes import Peer
from tests.realtime.helpers import Live, until

pytestmark = [pytest.mark.ros, pytest.mark.realtime]

QUIET = "format: 1\npublish: {events: {topic: /events}}\n"


@pytest.fixture
def asks(project: Path) -> Callable[[str], str]:
    """Write a tree, given by its root, and the gateway that it needs; return its name."""
    (project / "gateways/quiet.yaml").write_text(QUIET)

    def write(root: str) -> str:
        parameters = "parameters: {order: 3}\n" if "$order" in root else ""
        (project / "trees/asks.yaml").write_text(f"format: 1\n{parameters}root: {{{root}}}\n")
        return "asks"

    return write


class Ends(hbt.Listener):
    """What the nodes of a run said when they ended, by their names."""

    def __init__(self) -> None:
        self.said: dict[str, tuple[str, str]] = {}

    def node_changed(self, change: hbt.NodeChange) -> None:
        if change.status.name in ("SUCCESS", "FAILURE"):
            self.said[change.path.rpartition("/")[2]] = change.status.name, change.feedback


@pytest.fixture
def ran(project: Path, asks: Callable[[str], str], tmp_path: Path) -> Callable[..., dict[str, tuple[str, str]]]:
    """Run leaves, each by its name, one after the other, whatever they answer; return what they said in the end.

    What was recorded of it is decided again, without the gateway.
    """

    def run(**leaves: str) -> dict[str, tuple[str, str]]:
        named = [leaf.replace(": {", f": {{name: {name}, ", 1) for name, leaf in leaves.items()]
        ends = Ends()
        name = asks(f"sequence: [{', '.join(f'{{force_success: {{{leaf}}}}}' for leaf in named)}]")
        file = tmp_path / "asks.rrd"
        gateway: dict[str, Any] = {"mode": "realtime", "gateway": "quiet", "record": file}
        report = hbt.Session(name, workspace=project, listener=ends, **gateway).run()
        assert report.outcome == "success", report.reason
        again = hbt.replay(file)
        assert again.identical, str(again)
        return {name: ends.said[name] for name in leaves}

    return run


def test_services_are_called_and_what_went_wrong_is_told(peer: Peer, ran: Callable[..., dict[str, Any]]) -> None:
    from std_srvs.srv import SetBool, Trigger
    from test_msgs.srv import Arrays, BasicTypes

    asked: list[Any] = []

    def answer(request: Any, response: Any) -> Any:
        asked.append(request)
        response.string_value, response.int32_value = "cup", 7
        return response

    def refuse(_request: Any, response: Any) -> Any:
        response.success, response.message = False, "it is jammed"
        return response

    peer.node.create_service(BasicTypes, "/count", answer)
    peer.node.create_service(Arrays, "/list", lambda _request, response: response)
    peer.node.create_service(Trigger, "/open", refuse)
    peer.node.create_service(SetBool, "/other", refuse)
    fields = '{int32_value: $order, float64_value: "{order / 2}", string_value: "of {order}", bool_value: true}'
    count = "ros_service: {service: /count, type: test_msgs/BasicTypes, timeout: 20 s, request: %s, response: %s}"
    trigger = "ros_service: {service: %s, type: std_srvs/Trigger, timeout: %s}"
    said = ran(
        count=count % (fields, "{int32_value: n}"),
        read="condition: {expression: n == 7}",
        large=count % ('{int8_value: "{n * 100}"}', "{}"),
        list="ros_service: {service: /list, type: test_msgs/Arrays, timeout: 20 s, response: {uint8_values: bytes}}",
        open=trigger % ("/open", "20 s"),
        nowhere=trigger % ("/nowhere", "500 ms"),
        other=trigger % ("/other", "500 ms"),
    )
    assert said == {
        "count": ("SUCCESS", "/count answered: int32_value 7"),
        "read": ("SUCCESS", "n 7 == 7"),
        "large": ("FAILURE", "/count cannot be asked: 'int8_value' cannot be 700: it is of type int8"),
        "list": ("SUCCESS", "/list answered: uint8_values [0, 0, 0]"),
        "open": ("FAILURE", "/open answered that success is false: it is jammed"),
        "nowhere": ("FAILURE", "not answered within 0.5 s: nobody offers the service /nowhere"),
        "other": (
            "FAILURE",
            "not answered within 0.5 s: nobody offers the service /other as std_srvs/srv/Trigger, "
            "but it is known as std_srvs/srv/SetBool",
        ),
    }
    (request,) = asked
    assert (request.int32_value, request.float64_value, request.bool_value) == (3, 1.5, True)
    assert request.string_value == "of 3"


class Goals:
    """What an action has been asked: the goals that last until they are canceled, and those that were."""

    def __init__(self) -> None:
        self.begun: list[bytes] = []
        self.canceled: list[bytes] = []

    @property
    def over(self) -> bool:
        """Whether every goal that was begun has been canceled."""
        return sorted(self.begun) == sorted(self.canceled)


@contextmanager
def fibonacci(peer: Peer) -> Iterator[Goals]:
    """An action: order 0 is refused, order 1 aborted, up to 9 reached, and others last until they are canceled."""
    from rclpy.action import ActionServer, CancelResponse, GoalResponse
    from rclpy.callback_groups import ReentrantCallbackGroup
    from rclpy.task import Future
    from test_msgs.action import Fibonacci

    goals, ends = Goals(), dict[bytes, Any]()

    async def execute(handle: Any) -> Any:
        order, goal = handle.request.order, bytes(handle.goal_id.uuid)
        if order == 1:
            handle.abort()
            return Fibonacci.Result()
        handle.publish_feedback(Fibonacci.Feedback(sequence=[0, 1]))
        if order > 9:
            ends[goal] = Future(executor=peer._executor)
            goals.begun.append(goal)
            await ends[goal]
            handle.canceled()
            return Fibonacci.Result()
        handle.succeed()
        return Fibonacci.Result(sequence=[0, 1, 1])

    def cancel(handle: Any) -> Any:
        goal = bytes(handle.goal_id.uuid)
        goals.canceled.append(goal)
        ends[goal].set_result(None)
        return CancelResponse.ACCEPT

    server = ActionServer(
        peer.node,
        Fibonacci,
        "/fib",
        execute,
        goal_callback=lambda goal: GoalResponse.ACCEPT if goal.order else GoalResponse.REJECT,
        cancel_callback=cancel,
        callback_group=ReentrantCallbackGroup(),
    )
    yield goals
    server.destroy()


FIB = "ros_action: {action: /fib, type: test_msgs/Fibonacci, goal: {order: %s}, timeout: %s%s}"


def test_goals_are_reached_refused_aborted_or_canceled_in_time(peer: Peer, ran: Callable[..., dict[str, Any]]) -> None:
    with fibonacci(peer) as goals:
        said = ran(
            reached=FIB % ("$order", "20 s", ", result: {sequence.2: third}"),
            read="condition: {expression: third == 1}",
            refused=FIB % (0, "20 s", ""),
            aborted=FIB % (1, "20 s", ""),
            late=FIB % (10, "500 ms", ", feedback: sequence.1"),
            brief=FIB % (10, "40 ms", ""),  # it is dropped about when the action accepts it
        )
        until("what is late is canceled", lambda: goals.begun and goals.over)
    assert said.pop("brief")[0] == "FAILURE"
    assert said == {
        "reached": ("SUCCESS", "/fib answered: sequence.2 1"),
        "read": ("SUCCESS", "third 1 == 1"),
        "refused": ("FAILURE", "/fib refused the goal"),
        "aborted": ("FAILURE", "the goal of /fib was aborted"),
        "late": ("FAILURE", "not answered within 0.5 s: sequence.1 1"),
    }


@pytest.mark.parametrize("how", ["ctrl-c", "gateway killed", "decision killed"])
def test_a_goal_that_is_not_wanted_any_more_is_canceled(
    live: Callable[..., Live], peer: Peer, asks: Callable[[str], str], how: str
) -> None:
    with fibonacci(peer) as goals:
        run = live(asks(FIB % (10, "60 s", "")), gateway="quiet")
        until("the goal is at work", lambda: bool(goals.begun))
        if how == "ctrl-c":
            run.process.send_signal(signal.SIGINT)
        elif how == "gateway killed":
            run.kill("gateway", signal.SIGKILL)
        else:
            run.process.kill()
        until("it is canceled", lambda: goals.over)
        if how == "gateway killed":
            run.ends()
            why = "nobody heard what became of /fib: the gateway was gone, its process ended (killed by signal 9)"
            assert run.report["reason"] == f"ros_action: {why}"


@pytest.mark.parametrize(
    ("call", "column", "told"),
    [
        ("service: /x, type: std_srvs/SetBol", 8, ("'std_srvs' has no srv 'SetBol'", "did you mean 'SetBool'?")),
        ("service: /x, type: nothing/SetBool", 8, ("package 'nothing' of ROS 2", "humanoid-bt interfaces")),
        ("service: /x, type: std_srvs/SetBool, request: {dat: true}", 69, ("no field 'dat'", "did you mean 'data'?")),
        (
            'service: /x, type: std_srvs/SetBool, request: {data: "{1 m}"}',
            69,
            ("'data' cannot be a number: it is of type boolean", ""),
        ),
        (
            "service: /x, type: std_srvs/SetBool, response: {massage: a}",
            8,
            ("no field 'massage'", "did you mean 'message'?"),
        ),
    ],
)
def test_calls_that_nobody_could_answer_are_refused_where_they_are_written(
    project: Path, tmp_path: Path, call: str, column: int, told: tuple[str, str]
) -> None:
    (tmp_path / "quiet.yaml").write_text(QUIET)
    (tmp_path / "asks.yaml").write_text(f"format: 1\nroot: {{ros_service: {{{call}}}}}\n")
    with pytest.raises(hbt.UserError) as raised:
        hbt.Session(tmp_path / "asks.yaml", workspace=project, mode="realtime", gateway=tmp_path / "quiet.yaml")
    (problem,) = raised.value.problems
    assert told[0] in problem.message
    assert told[1] in problem.hint
    assert problem.place is not None
    assert (problem.place.line, problem.place.column) == (2, column)
