"""``humanoid-bt interfaces``: wheels of message packages for a ROS 2 from wheels."""

from __future__ import annotations

import argparse
import shlex

from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.gateway.interfaces.package import find
from humanoid_bt.gateway.interfaces.wheel import build_wheels
from humanoid_bt.session.report import ExitCode


def interfaces(arguments: argparse.Namespace) -> int:
    """Build the wheels, and say how they are installed."""
    wheels = []
    try:
        for wheel in build_wheels([find(named) for named in arguments.packages], arguments.output):
            print(f"{relative(wheel)}: built", flush=True)
            wheels.append(wheel)
    except OSError as error:
        raise UserError(f"the wheels cannot be written to {str(arguments.output)!r}: {error.strerror}") from error
    print(f"next: {shlex.join(['pip', 'install', *map(relative, wheels)])}")
    return ExitCode.SUCCESS
