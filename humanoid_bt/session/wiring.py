"""The loops below the tree, wired as a run asks for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.core.sources import Sources
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.gateway.plan import planned
from humanoid_bt.perception.choice import Chosen, choose
from humanoid_bt.perception.senses import new_perception
from humanoid_bt.perception.source_files import TRACKER
from humanoid_bt.plant.scene import Scene
from humanoid_bt.realtime.decision_side import Realtime
from humanoid_bt.realtime.gateway_life import GatewayPlan
from humanoid_bt.session.engine import Engine
from humanoid_bt.session.options import RunOptions


def new_engine(
    options: RunOptions, robot_path: Path, scene: Scene, *, sources: Sources | None, workspace: Workspace
) -> Engine:
    """Return control, plant and perception of a run, not yet started.

    Args:
        options: in which mode.
        robot_path: the ``robot.yaml``.
        scene: what surrounds the robot.
        sources: of percepts; None for the simulated tracker.
        workspace: where they are found.

    Raises:
        UserError: the robot or a source has mistakes.
    """
    robot, start = load_robot(robot_path, options.body)
    chosen = choose(sources, workspace, scene.config)
    if options.mode == "realtime":
        gateway = _gateway(workspace.find_gateway(options.gateway), sources, chosen) if options.gateway else None
        written = (sources.written if sources else None, str(workspace.root))
        plant = options.plant, options.plant_key
        return Realtime(robot, scene, options.hold, sources=written, chosen=chosen, plant=plant, gateway=gateway)
    from humanoid_bt.session.lockstep import Lockstep  # noqa: PLC0415 (control, which a realtime run has elsewhere)

    return Lockstep(robot, start, scene, new_perception(chosen, robot, scene, waits=True))


def _gateway(path: Path, sources: Sources | None, chosen: Sequence[Chosen]) -> GatewayPlan:
    """Return the plan of a gateway.

    Raises:
        UserError: it has mistakes, or a source that is named publishes one of its percepts; the simulated tracker
            leaves them to it.
    """
    plan = planned(path)
    for one in chosen if sources is not None else ():
        if one.name != TRACKER and (twice := sorted(set(one.names) & set(plan.percepts))):
            message = f"the source {one.name!r} and the gateway publish the percept {twice[0]!r}"
            raise UserError(message, sources.place if sources else None, f"see {relative(path)}", "duplicate-percept")
    return replace(plan, pictures=plan.pictures and any("camera" in one.cls.needs for one in chosen))
