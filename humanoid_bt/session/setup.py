"""What is run, as data for the recording: all that it takes to find out about the run, and to run it again."""

from __future__ import annotations

import functools
import hashlib
import math
import os
import platform
import sys
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import mujoco

from humanoid_bt.core.errors import UserError, relative, resolved
from humanoid_bt.core.items import Item
from humanoid_bt.core.messages import SIDES
from humanoid_bt.core.plain import plain
from humanoid_bt.core.sources import Sources
from humanoid_bt.core.units import spaced
from humanoid_bt.files import document
from humanoid_bt.files.class_files import class_file
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.perception.choice import sources_of
from humanoid_bt.perception.source_files import files_of
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.robot.model_file import model_file
from humanoid_bt.session.engine import Engine
from humanoid_bt.session.options import RunOptions
from humanoid_bt.session.report import versions
from humanoid_bt.tree.node import Node
from humanoid_bt.tree.tree import Tree
from humanoid_bt.tree.write import written

_MOST_TEXT = 1 << 20  # bytes of a file that is kept whole; of a larger one the hash is
_ENDINGS = (".yaml", ".yml", ".xml", ".mjcf", ".urdf", ".py")  # of files that are text


def run_setup(tree: Tree, engine: Engine, options: RunOptions, robot: Path, scene: Path) -> dict[str, Any]:
    """Return what is run.

    Args:
        tree: the first tree.
        engine: what it runs on.
        options: as they were asked for.
        robot, scene: their files.
    """
    sources = sources_of(options.perception, tree.perception, engine.scene.config)
    return {
        "format": 1,
        "began": datetime.now(UTC).isoformat(timespec="seconds"),
        "mode": options.mode,
        "body": engine.robot.config.body.walk,
        "seed": options.seed,
        "duration": options.duration,
        "on_estop": options.on_estop,
        "watch": options.watch,
        "staged": options.staged,
        "perception": plain(sources.written) if sources else None,
        "workspace": str((tree.workspace or Workspace()).root),
        "tree": tree_setup(tree, options.parameters),
        "robot": {"name": engine.robot.config.name, "file": _name(robot, tree), **_body(engine.robot)},
        "scene": {"name": engine.scene.config.name, "file": _name(scene, tree)},
        "files": list(_files(tree, robot, scene, sources, options.gateway)),
        "versions": versions(),
        "machine": _machine(),
    }


def _body(robot: RobotModel) -> dict[str, Any]:
    """Return a robot's joints and what limits each (soft limits, torque, speed), arms, mass, when it falls; SI."""
    limits = {"lower": robot.lower, "upper": robot.upper, "torque": robot.torque_limit, "speed": robot.speed_limit}
    # JSON has no infinity: a joint that turns without end has no limit
    finite = {name: [value if math.isfinite(value) else None for value in of.tolist()] for name, of in limits.items()}
    fall = {"tilt": robot.config.fall.tilt, "height": robot.config.fall.height}
    arms = {f"{side}_hand": [robot.joint_names[number] for number in robot.arm_joints(side)] for side in SIDES}
    return {"joints": list(robot.joint_names), "limits": finite, "arms": arms, "mass": robot.mass, "fall": fall}


def tree_setup(tree: Tree, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is kept of a tree.

    Args:
        tree: it.
        given: the parameters that were given from outside.
    """
    return {
        "name": tree.name,
        "file": _name(tree.path, tree),
        "source": tree.source,
        "parameters": dict(_parameters(tree, given)),
        "nodes": [
            {
                "path": node.path,
                "type": node.type_name,
                "kind": node.kind,
                "place": str(node.place),
                "parent": node.parent,
                "branch": node.branch,
                "values": dict(_values(node)),
            }
            for node in tree.nodes
        ],
    }


def _values(node: Node) -> Iterator[tuple[str, Any]]:
    """Yield every parameter that a node was given, as a file holds it, with its unit."""
    for name, value in {**node.values, **node.written}.items():
        spec = node.type.params.get(name)
        unit = spec.unit if spec is not None else ""
        yield name, plain(written(spaced(value) if name in node.written else value, unit))


def _parameters(tree: Tree, given: Mapping[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield every parameter of a tree: its value in SI units, as it was written, and where it is from."""
    declared = tree.header.get("parameters") or {}
    places = _places(tree)
    for name, value in tree.parameters.items():
        default = declared.get(name)
        if isinstance(default, dict):
            default = default.get("default")
        origin = _origin(given[name]) if name in given else places.get(name, "")
        yield name, {"value": plain(value), "written": plain(default), "from": origin}


def _origin(given: Any) -> str:
    return f"given in {given.place}" if isinstance(given, Item) else "given"


def _places(tree: Tree) -> dict[str, str]:
    """Return where a tree's file declares its parameters."""
    try:
        item = document.parse(tree.source, relative(tree.path)).value["parameters"]
        return {name: str(declared.place) for name, declared in item.value.items()}
    except (UserError, KeyError, TypeError, AttributeError):  # it has none, or no file
        return {}


def _files(
    tree: Tree, robot: Path, scene: Path, sources: Sources | None, gateway: str | None
) -> Iterator[dict[str, Any]]:
    """Yield every file that the run is made of: its name in its workspace, what it is, its hash, and its text."""
    skills = (class_file(node.type.cls) for node in tree.nodes if node.kind == "skill")
    model = model_file(document.load(robot).value["model"].value, robot.parent)
    roles = {
        "tree": tree.files,
        "skill": [file for file in skills if file is not None],
        "perception": files_of(sources, tree.workspace or Workspace()),
        "scene": [scene],
        "gateway": [(tree.workspace or Workspace()).find_gateway(gateway)] if gateway else [],
        "robot": [robot],
        "policy": list(_policy_files(robot)),
        "body": list(_own_body(robot)),
        "model": [model, *(model.parent / name for name in mujoco.mju_getXMLDependencies(str(model)))],
    }
    seen = set[Path]()
    for role, files in roles.items():
        for file in map(resolved, files):
            if file not in seen and file.is_file():
                seen.add(file)
                yield {"role": role, "name": _name(file, tree), **_content(file)}


def _policy_files(robot: Path) -> Iterator[Path]:
    """Yield the description of a robot's learned walker, and its model."""
    body = document.load(robot).plain().get("body") or {}
    if named := body.get("policy"):
        description = robot.parent / named
        yield description
        if description.is_file() and (model := document.load(description).plain().get("model")):
            yield description.parent / model


def _own_body(robot: Path) -> Iterator[Path]:
    """Yield the file of a body that is the user's own."""
    body = document.load(robot).plain().get("body") or {}
    if named := body.get("own"):
        yield robot.parent / named


def _content(file: Path) -> dict[str, str]:
    data = file.read_bytes()
    found = {"sha256": hashlib.sha256(data).hexdigest()}
    if file.suffix in _ENDINGS and len(data) <= _MOST_TEXT:
        found["text"] = data.decode(errors="replace")
    return found


def _name(file: Path, tree: Tree) -> str:
    """Return a file's name in its workspace, or its whole path if it is in none."""
    for root in (tree.workspace or Workspace()).layers:
        if resolved(file).is_relative_to(root):
            return str(resolved(file).relative_to(root))
    return str(resolved(file))


@functools.cache
def _machine() -> dict[str, Any]:
    return {
        "system": platform.platform(),
        "processor": platform.machine(),
        "cores": os.cpu_count(),
        "python": sys.version.split()[0],
        "host": platform.node(),
    }
