"""The arguments of ``humanoid-bt interfaces``."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.cli.arguments.parsing import Commands

_EXAMPLES = """\
examples:
  humanoid-bt interfaces vision_msgs tf2_msgs
  humanoid-bt interfaces ../lab_interfaces -o wheels
"""


def add_interfaces(commands: Commands) -> None:
    """Declare ``interfaces``."""
    interfaces = commands.add(
        "interfaces",
        "build messages of ROS 2 that there are no wheels of",
        "Build packages of messages, services and actions for the ROS 2 that pip installed here (humanoid-bt[ros]), "
        "a wheel of each. It takes a C++ compiler and the headers of Python, and some seconds for each package.",
        _EXAMPLES,
    )
    interfaces.add_argument(
        "packages",
        nargs="+",
        metavar="PACKAGE",
        help="folder of a package, with msg/, srv/ or action/ in it; vision_msgs and tf2_msgs come along; one that "
        "needs another comes after it",
    )
    interfaces.add_argument(
        "-o", "--output", type=Path, default=Path(), metavar="DIR", help="write the wheels there; default: here"
    )
