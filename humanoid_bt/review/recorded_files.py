"""The files of a recorded run, laid out once more as the workspace that they were."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace, builtin_root

_FOLDERS = {"tree": "trees", "skill": "skills", "scene": "sim/scenes", "perception": "perception"}
"""Of files that were in no workspace."""


class RecordedFiles(NamedTuple):
    """Where the files of a recorded run are now.

    Attributes:
        workspace: with them.
        tree, robot, scene: the files that the run was started with.
    """

    workspace: Workspace
    tree: Path
    robot: Path
    scene: Path


def lay_out(setup: Mapping[str, Any], folder: Path) -> RecordedFiles:
    """Write the files of a recorded run into an empty folder.

    Args:
        setup: of the run.
        folder: for its workspace.

    Raises:
        UserError: the recording does not hold them all, and they are not where they were, or have changed.
    """
    names = started_with(setup)
    places, missing = dict[str, Path](), list[str]()
    roots = (Path(setup["workspace"]), builtin_root())
    for file in setup["files"]:
        place = places[file["name"]] = folder / _inside(file["name"], file["role"])
        try:
            content = file["text"].encode() if "text" in file else _found(file["name"], file["sha256"], roots)
            if content is None:
                missing.append(file["name"])
                continue
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(content)
        except (ValueError, OSError) as error:
            raise UserError(f"the file {file['name']!r} of the run cannot be laid out: {error}") from None
    if missing:
        message = f"{len(missing)} files of the run are not in the recording, and not as they were: {missing[0]!r}"
        raise UserError(message, hint="meshes are not recorded: run it where they are")
    if gone := [name for name in names if name not in places]:
        raise UserError(f"the recording does not hold {gone[0]!r}", hint="a tree made in Python is not recorded")
    return RecordedFiles(Workspace(folder), *(places[name] for name in names))


def started_with(setup: Mapping[str, Any]) -> list[str]:
    """Return the names of the files of tree, robot and scene that a run was started with.

    Raises:
        UserError: the recording does not say.
    """
    names = [setup[kind]["file"] for kind in ("tree", "robot", "scene")]
    if not all(names):
        raise UserError("the recording does not say what was run", hint="its beginning is damaged")
    return names


def _inside(name: str, role: str) -> PurePosixPath:
    """Return where a file goes in the folder, whatever its name says."""
    path = PurePosixPath(name)
    if path.is_absolute() or ".." in path.parts:
        return PurePosixPath(_FOLDERS.get(role, "sim/robot")) / path.name
    return path


def _found(name: str, sha256: str, roots: tuple[Path, ...]) -> bytes | None:
    """Return the content of a file that is where it was, None if it is not, or has changed."""
    for root in roots:
        file = root / name
        if file.is_file() and hashlib.sha256(content := file.read_bytes()).hexdigest() == sha256:
            return content
    return None
