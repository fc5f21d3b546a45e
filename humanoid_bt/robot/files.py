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
    files = {config.path, *model_files(config.model_file)}
    if body.walk == "own" and body.own is not None:
        files.add(folder / body.own)
    if body.walk == "policy" and body.policy is not None and is_file(folder / body.policy):
        files.update(policy_files(folder / body.policy))
    return files


def model_files(model: Path) -> Iterator[Path]:
    """Yield an MJCF file, those that it includes, whose names are relative to it, also in one another, and models."""
    found, left = set[Path](), [(model, model.parent)]
    while left:
        file, folder = left.pop()
        if file in found or not is_file(file):
            continue
        found.add(file)
        yield file
        try:
            root = ElementTree.parse(file)
        except (ElementTree.ParseError, ValueError, LookupError, OSError):
            continue  # loading it tells what is wrong
        left += [(folder / name, folder) for one in root.iter("include") if (name := one.get("file"))]
        models = [folder / name for one in root.iter("model") if (name := one.get("file"))]
        left += [(attached, attached.parent) for attached in models]
