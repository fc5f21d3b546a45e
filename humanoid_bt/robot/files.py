"""The files that a robot is made of, but for meshes and textures."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

from humanoid_bt.files.reading import is_file
from humanoid_bt.robot.config import RobotConfig
from humanoid_bt.robot.policy.policy import policy_files


def files_of(config: RobotConfig) -> set[Path]:
    """Return the files of a robot: its ``robot.yaml``, its model with all that this includes, and what walks it.

    Raises:
        UserError: there is no model, or the description of its learned walker has mistakes.
    """
    folder, body = config.path.parent, config.body
    files = {config.path, *_included(config.model_file)}
    if body.walk == "own" and body.own is not None:
        files.add(folder / body.own)
    if body.walk == "policy" and body.policy is not None and is_file(folder / body.policy):
        files.update(policy_files(folder / body.policy))
    return files


def _included(model: Path) -> Iterator[Path]:
    """Yield an MJCF file and those that it includes, whose names are relative to it, also in one another."""
    found, left = set[Path](), [model]
    while left:
        file = left.pop()
        if file in found or not is_file(file):
            continue
        found.add(file)
        yield file
        try:
            includes = ElementTree.parse(file).iter("include")
            left += [model.parent / name for one in includes if (name := one.get("file"))]
        except (ElementTree.ParseError, ValueError, LookupError, OSError):
            continue  # loading it tells what is wrong
