"""The tree's parameters as parameters of the gateway's node."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.gateway.nodes import Peer
from tests.realtime.helpers import Live, until

pytestmark = [pytest.mark.ros, pytest.mark.realtime]

TREE = """
format: 1
parameters:
  patience: {default: 60 s, doc: How long it is patient.}
  level: 2
  places: [[1 m, 0 m], [2 m, 0 m]]
  many: {type: integer, default: 99999999999999999999}
root:
  sequence:
    - condition: level > 1 and many > 1
    - for_each: {item: [x, y], items: $places, log: "{x} {y}"}
    - timeout: {duration: $patience, wait_until: state.time > 1000 s}
"""


@pytest.fixture
def patient(project: Path) -> str:
    (project / "trees/patient.yaml").write_text(TREE)
    for what in ("set", "read"):
        (project / f"gateways/{what}.yaml").write_text(f"format: 1\nparameters: {what}\n")
    return "patient"


class Remote:
    """The parameters of the gateway's node, as another node has them."""

    def __init__(self, peer: Peer) -> None:
        from rcl_interfaces import srv

        self._peer, self._srv = peer, srv

    def call(self, kind: str, name: str, **request: Any) -> Any:
        of = getattr(self._srv, kind)
        return self._peer.client(of, f"/humanoid_bt/{name}").call(of.Request(**request), timeout_sec=10)

    def get(self, *names: str) -> list[Any]:
        from rclpy.parameter import parameter_value_to_python

        values = self.call("GetParameters", "get_parameters", names=list(names)).values
        return [parameter_value_to_python(value) for value in values]

    def shows(self, name: str, value: Any) -> bool:
        """Return whether it has this value; a call may be lost to a node that was killed a moment ago."""
        try:
            return self.get(name) == [value]
        except TimeoutError:
            return False

    def set(self, name: str, value: Any) -> str:
        """Return why it is not set, "" if it is."""
        from rclpy.parameter import Parameter

        one = Parameter(name, value=value).to_parameter_msg()
        (result,) = self.call("SetParameters", "set_parameters", parameters=[one]).results
        return "" if result.successful else str(result.reason)


def test_parameters_are_shown_and_set_while_the_tree_runs(live: Callable[..., Live], peer: Peer, patient: str) -> None:
    run, remote = live(patient, gateway="set"), Remote(peer)
    until("they are shown", lambda: remote.shows("tree.patience", 60.0))
    names = ["tree.patience", "tree.level"]
    first, second = remote.call("DescribeParameters", "describe_parameters", names=names).descriptors
    assert first.description == "How long it is patient. [s]"
    (between,) = first.floating_point_range
    assert between.from_value == 0
    assert second.additional_constraints.startswith("read-only: the parameter 'level' must be known before the run")

    assert "must be known before the run" in remote.set("tree.level", 3)
    assert remote.set("tree.patience", -1.0)
    assert "'duration' must be" in remote.set("tree.patience", "soon")
    assert "'duration' must be" in remote.set("tree.patience", "🤖" * 300)
    assert remote.set("tree.patience", "y" * 5000).startswith("patience is not set: the value is too long: ")
    assert "'duration' must be" in remote.set("tree.patience", [b"\1"])
    assert remote.get(*names) == [60.0, 2]
    assert remote.set("tree.patience", 50) == ""
    until("it is told", lambda: "set patience = 50 s by ROS 2" in run.output)
    run.kill("gateway", 9)  # another one shows what holds by then
    until("it shows them again", lambda: run.folder.info.processes["gateway"] != run.pids["gateway"])
    until("it is there", lambda: "is there again" in run.output)
    until("what was set is shown", lambda: remote.shows("tree.patience", 50.0))
    remote.set("tree.patience", 0.1)
    assert run.ends() == 1, run.output


def test_parameters_that_are_only_shown_are_not_set(live: Callable[..., Live], peer: Peer, patient: str) -> None:
    live(patient, gateway="read")
    remote = Remote(peer)
    until("they are shown", lambda: remote.shows("tree.patience", 60.0))
    assert remote.set("tree.patience", 1.0) == "patience is not set: the gateway's file says 'parameters: read'"
    shown = remote.get("tree.patience", "tree.places", "tree.many")
    assert shown == [60.0, '[["1 m", "0 m"], ["2 m", "0 m"]]', "99999999999999999999"]
