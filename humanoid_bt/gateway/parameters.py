"""Parameters of the tree as parameters of the gateway's node."""

from __future__ import annotations

import json
import math
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.gateway.fields import plain
from humanoid_bt.gateway.node import Ears
from humanoid_bt.gateway.types import interface
from humanoid_bt.link.ring import RingReader
from humanoid_bt.link.segment import LinkError

PREFIX = "tree."
"""What the names of the tree's parameters have before them: the node has some of its own."""

SOURCE = "ROS 2"
_PATIENCE = 0.4  # s that decision gets to answer; the thread that hears stands still meanwhile
_SILENCE = 2.0  # s in which it is not asked again when it did not answer


class TreeParameters:
    """Shows the tree's parameters, and has those set that others set.

    Args:
        ears: whose node has them.
        shown: where decision shows them.
        ask: asks decision to set one.
        settable: whether others may set any.
    """

    def __init__(self, ears: Ears, shown: RingReader, ask: Callable[[bytes], object], settable: bool) -> None:
        from rclpy.parameter import Parameter  # noqa: PLC0415 (part of the extra)

        self._parameter = Parameter
        self._node, self._shown, self._ask, self._settable = ears.node, shown, ask, settable
        self._known: dict[str, dict[str, Any]] = {}
        self._seen = 0
        self._own = False  # it is this that sets
        self._number, self._silent_until = 0, 0.0
        self._answers: dict[int, str] = {}
        self._answered = threading.Condition()
        self._node.add_on_set_parameters_callback(self._set)
        ears.every(DECISION_PERIOD, self._look)

    def told(self, values: Mapping[str, Any]) -> None:
        """Take what decision answers: why a parameter is not set, "" if it is. From any thread."""
        with self._answered:
            self._answers[values["number"]] = values["why"]
            self._answered.notify_all()

    def _look(self) -> None:
        """Show what has changed."""
        latest = self._shown.latest()
        if latest is None or latest[0] == self._seen:
            return
        self._seen = latest[0]
        new = {PREFIX + one["name"]: one for one in json.loads(latest[1]) if one["value"] is not None}
        self._own = True
        try:
            for name in self._known.keys() - new.keys():
                self._node.undeclare_parameter(name)
            for name, one in new.items():
                self._show(name, one)
        finally:
            self._own = False
        self._known = new

    def _show(self, name: str, one: Mapping[str, Any]) -> None:
        value = _as_parameter(one["value"])
        if name not in self._known:
            self._node.declare_parameter(name, value, self._descriptor(name, one), ignore_override=True)
        elif self._known[name] != one:
            self._node.set_descriptor(name, self._descriptor(name, one))
            self._node.set_parameters([self._parameter(name, value=value)])

    def _descriptor(self, name: str, one: Mapping[str, Any]) -> Any:
        unit = f" [{one['unit']}]" if one["unit"] else ""
        fixed = self._why_fixed(one)
        descriptor = interface("rcl_interfaces/ParameterDescriptor")(
            name=name,
            description=f"{one['doc']}{unit}".strip(),
            additional_constraints=f"read-only: {fixed}" if fixed else "",
            dynamic_typing=True,  # 1 may become 0.5, and decision knows what goes
        )
        if isinstance(one["value"], float) and (one["least"] is not None or one["most"] is not None):
            least, most = (-math.inf if one["least"] is None else one["least"]), one["most"]
            most = math.inf if most is None else most
            between = interface("rcl_interfaces/FloatingPointRange")(from_value=float(least), to_value=float(most))
            descriptor.floating_point_range = [between]
        return descriptor

    def _why_fixed(self, one: Mapping[str, Any]) -> str:
        return one["fixed"] or ("" if self._settable else "the gateway's file says 'parameters: read'")

    def _set(self, parameters: list[Any]) -> Any:
        why = "" if self._own else self._refusal(parameters)
        return interface("rcl_interfaces/SetParametersResult")(successful=not why, reason=why)

    def _refusal(self, parameters: list[Any]) -> str:
        """Have parameters set; return why not, "" if they are."""
        ours = [one for one in parameters if one.name in self._known]
        if len(ours) > 1:
            return "the parameters of a tree are set one by one"
        for one in ours:
            known = self._known[one.name]
            why = self._why_fixed(known) or self._asked(known["name"], one.value)
            if why:
                return f"{known['name']} is not set: {why}"
        return ""

    def _asked(self, name: str, value: Any) -> str:
        if value is None:
            return "the tree needs it"
        if time.monotonic() < self._silent_until:
            return "the tree's process does not answer"
        self._number += 1
        number = self._number
        wanted = {"number": number, "name": name, "value": plain(value), "source": SOURCE, "at": time.monotonic()}
        try:
            self._ask(json.dumps(wanted).encode())
        except LinkError as error:
            return f"the value is too long: {error}"
        with self._answered:
            if not self._answered.wait_for(lambda: number in self._answers, _PATIENCE):
                self._silent_until = time.monotonic() + _SILENCE
                return "the tree's process does not answer"
            return self._answers.pop(number)


def _as_parameter(value: Any) -> Any:
    """Return a value as a parameter of ROS 2 can have it: what there is no type for as JSON."""
    parts = value if isinstance(value, list) else [value]
    kinds = {type(part) for part in parts}
    held = len(kinds) == 1 and (kinds <= {bool, float, str} or (kinds == {int} and all(map(_fits, parts))))
    return value if held else json.dumps(value)


def _fits(number: int) -> bool:
    return -(1 << 63) <= number < 1 << 63
