"""What a run needs to know of a gateway before it begins."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.gateway.calls import check_call
from humanoid_bt.gateway.check import check_types
from humanoid_bt.gateway.file import load_gateway
from humanoid_bt.gateway.publishing import wants_pictures
from humanoid_bt.realtime.gateway_life import GatewayPlan


def planned(path: Path) -> GatewayPlan:
    """Return what a gateway file plans, after a look whether what it names is installed.

    Raises:
        UserError: it has mistakes, or ROS 2 or a type is not installed.
    """
    config = load_gateway(path)
    check_types(config)
    return GatewayPlan(
        path,
        tuple(config.percepts),
        stops=config.estop is not None,
        orders=config.action is not None,
        parameters=config.parameters != "none",
        pictures=wants_pictures(config),
        check_call=check_call,
    )
