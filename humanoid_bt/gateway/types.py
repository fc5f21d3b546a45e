"""Types of messages by name, from whichever packages of ROS 2 are installed."""

from __future__ import annotations

import functools
import importlib
import importlib.util
from typing import Any, Literal

from humanoid_bt.core.errors import Place, UserError, nearest
from humanoid_bt.gateway.interfaces.package import KNOWN

Interface = Literal["msg", "srv", "action"]

_WHEELS = ("diagnostic_msgs", "geometry_msgs", "nav_msgs", "sensor_msgs", "std_msgs", "std_srvs")
_HINT = "pip install 'humanoid-bt[ros]', or source the setup of a ROS 2 that has a Python of this version"


def check_installed() -> None:
    """Refuse if there is no ROS 2 for this Python.

    Raises:
        UserError: there is none, and how to get it.
    """
    if importlib.util.find_spec("rclpy") is None:
        raise UserError("a gateway needs ROS 2: there is no 'rclpy'", hint=_HINT, code="no-file")


@functools.cache
def interface(name: str, kind: Interface = "msg", place: Place | None = None) -> Any:
    """Return a type of messages, services or actions.

    Args:
        name: PACKAGE/TYPE, or PACKAGE/msg/TYPE.
        kind: what it is.
        place: where it is named.

    Raises:
        UserError: its package is not installed, or has no such type.
    """
    package, _, short = name.replace(f"/{kind}/", "/").partition("/")
    try:
        module = importlib.import_module(f"{package}.{kind}")
    except ImportError as error:
        wheel = package.replace("_", "-")
        hint = f"pip install ros-kilted-{wheel}, or apt install ros-$ROS_DISTRO-{wheel} and source its setup"
        if package not in _WHEELS:
            build = package if (KNOWN / package).is_dir() else "FOLDER of its definitions"
            hint = f"there may be no wheel of it: humanoid-bt interfaces {build} builds one; or source a ROS 2 with it"
        why = "is not installed" if isinstance(error, ModuleNotFoundError) else f"cannot be imported: {error}"
        raise UserError(f"the package {package!r} of ROS 2, of {name!r}, {why}", place, hint, "no-file") from None
    if (found := getattr(module, short, None)) is None:
        known = [one for one in dir(module) if one[0].isupper()]
        raise UserError(f"{package!r} has no {kind} {short!r}", place, nearest(short, known), "unknown-key")
    return found
