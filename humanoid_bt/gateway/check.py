"""Whether what a gateway file names is installed, before a run begins."""

from __future__ import annotations

from humanoid_bt.core.errors import Problem, UserError
from humanoid_bt.files import document
from humanoid_bt.gateway.action import check_action
from humanoid_bt.gateway.estop import EStopEars
from humanoid_bt.gateway.file import GatewayFile
from humanoid_bt.gateway.publishing import wanted
from humanoid_bt.gateway.types import check_installed, interface


def check_types(config: GatewayFile) -> None:
    """Refuse a gateway for which something is not installed.

    Raises:
        UserError: with everything that is missing, and where the file asks for it.
    """
    check_installed()
    item = document.load(config.path)
    problems: list[Problem] = []

    def look(*keys: str, types: tuple[str, ...]) -> None:
        for name in types:
            try:
                interface(name, "msg", item.place_of(*keys))
            except UserError as error:
                problems.extend(error.problems)

    for name, topic in config.percepts.items():
        look("percepts", name, "type", types=(topic.type,))
    for name, kind, _ in wanted(config):
        look("publish", name, types=(kind.type,))
    if config.frames.tf:
        look("frames", "tf", types=("tf2_msgs/TFMessage",))
    if config.estop is not None:
        try:
            EStopEars.check(config.estop)
        except UserError as error:
            problems.extend(error.problems)
    try:
        check_action(config, item.place_of)
    except UserError as error:
        problems.extend(error.problems)
    if problems:
        raise UserError(problems)
