"""What people write Python with: the robot as a skill sees it, and the rig of its tests."""

from __future__ import annotations

from humanoid_bt.core.messages import State
from humanoid_bt.decision.hand_route import HandRoute
from humanoid_bt.decision.robot_handle import RobotHandle
from humanoid_bt.decision.route import Route
from humanoid_bt.perception.track import Track
from humanoid_bt.testing.rig import Rig
from humanoid_bt.testing.rig_result import RigResult
from parts.markdown import attributes, code, members


def handle() -> str:
    """Return what a skill finds in ``self.robot``."""
    return members(RobotHandle, hidden=("release",))


def route() -> str:
    """Return what a way round obstacles offers."""
    return _whole(Route)


def hand_route() -> str:
    """Return what a way of a palm over obstacles offers."""
    return _whole(HandRoute)


def _whole(cls: type) -> str:
    """Return the members and the attributes of a class in one table."""
    return members(cls) + "\n" + attributes(cls).partition("| --- | --- |\n")[2]


def track() -> str:
    """Return what is known of something seen."""
    return attributes(Track)


def state() -> str:
    """Return what a state holds."""
    return attributes(State)


def rig() -> str:
    """Return what the rig offers."""
    return members(Rig)


def rig_result() -> str:
    """Return what the rig answers."""
    short = [name for name, member in vars(RigResult).items() if isinstance(member, property)]
    return f"{attributes(RigResult)}\n\nAnd, for short: {code(short)}."
