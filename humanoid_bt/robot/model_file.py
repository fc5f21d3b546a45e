"""Where the model of a robot is: an MJCF file, or a description of the package ``robot_descriptions``."""

from __future__ import annotations

import contextlib
import functools
import importlib
import sys
from pathlib import Path
from typing import Any

from humanoid_bt.core.errors import Place, UserError, nearest, relative
from humanoid_bt.files.reading import is_file

PREFIX = "robot_descriptions:"
"""Begins what the package of this name fetches: ``robot_descriptions:NAME``, or ``robot_descriptions:NAME/FILE``."""

INSTALL = "pip install 'humanoid-bt[descriptions]'"

_PACKAGE = "robot_descriptions"


def model_file(model: str, folder: Path, place: Place | None = None) -> Path:
    """Return the MJCF file that ``model`` of a ``robot.yaml`` means; a description is fetched when it is not there yet.

    Args:
        model: a file, or a description.
        folder: of the ``robot.yaml``.
        place: where it says so.

    Raises:
        UserError: there is no such file or description, or it cannot be fetched.
    """
    if model.startswith(PREFIX):
        return described_file(model, place)
    file = folder / model
    if not is_file(file):
        raise UserError(f"the model file {model!r} is missing", place, f"looked for {relative(file)}", "no-file")
    return file


def described_file(model: str, place: Place | None = None) -> Path:
    """Return the MJCF file of a description, as ``robot_descriptions:g1_mj_description``, after fetching it.

    Raises:
        UserError: there is none of this name, it has no MJCF, or it cannot be fetched.
    """
    name, _, other = model.removeprefix(PREFIX).partition("/")
    file = _fetched(name, place)
    if other:
        file = file.with_name(other)
    if is_file(file):
        return file
    if not file.parent.is_dir():
        message, hint = f"what was fetched for {name!r} lacks the folder of its model", f"looked for {file.parent}"
        raise UserError(message, place, hint, "no-file")
    others = (path.name for path in file.parent.glob("*.xml"))
    raise UserError(f"{name!r} has no file {file.name!r}", place, nearest(file.name, others), "no-file")


def described_name(model: str) -> str:
    """Return what a robot is called whose model is this description: ``g1`` of ``g1_mj_description``."""
    name, _, other = model.removeprefix(PREFIX).partition("/")
    return Path(other).stem or name.removesuffix("_description").removesuffix("_mj")


def _fetched(name: str, place: Place | None) -> Path:
    _check_known(name, place)
    try:
        return _imported(name)
    except Exception as error:  # of git, of the network, of a description's own code
        sys.stderr.write("\n")  # below the progress of what was begun
        message = f"the robot description {name!r} cannot be fetched: {_reason(error)}"
        hint = (
            "it is cloned with git when it is first used, into ~/.cache/robot_descriptions or the folder that"
            " ROBOT_DESCRIPTIONS_CACHE names; a model that is here already: its MJCF file in place of the description"
        )
        raise UserError(message, place, hint, "no-file") from error


@functools.cache
def _imported(name: str) -> Path:
    """Import a description, which clones what it names; it says so itself, where results are not printed."""
    with contextlib.redirect_stdout(sys.stderr):
        return Path(importlib.import_module(f"{_PACKAGE}.{name}").MJCF_PATH)


def _check_known(name: str, place: Place | None) -> None:
    descriptions = _descriptions(place)
    with_mjcf = [known for known, description in descriptions.items() if description.has_mjcf]
    if name in with_mjcf:
        return
    if name not in descriptions:
        message, hint = f"there is no robot description {name!r}", nearest(name, with_mjcf)
        raise UserError(message, place, hint, "no-file")
    same = [known for known in with_mjcf if descriptions[known].robot == descriptions[name].robot]
    hint = f"the same robot in MJCF: {', '.join(same)}" if same else "such a robot needs an MJCF model from elsewhere"
    raise UserError(f"the robot description {name!r} has no MJCF, the form of MuJoCo", place, hint, "no-file")


def _descriptions(place: Place | None) -> dict[str, Any]:
    """Return the package's list, without fetching anything."""
    try:
        descriptions: dict[str, Any] = importlib.import_module(_PACKAGE).DESCRIPTIONS
    except ImportError as error:
        message = "a model of robot_descriptions needs this package, which is not installed"
        raise UserError(message, place, INSTALL, "no-file") from error
    return descriptions


def _reason(error: Exception) -> str:
    """Return what went wrong in one line: of a command of git what it wrote, without its decoration."""
    written = str(getattr(error, "stderr", "") or error)
    text = " ".join(written.split()).removeprefix("stderr: ").strip("' ")
    return text or type(error).__name__
