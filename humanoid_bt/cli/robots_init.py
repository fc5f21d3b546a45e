"""``humanoid-bt robots init``: a first robot.yaml for a model."""

from __future__ import annotations

import os
import re
import shlex
from pathlib import Path

from humanoid_bt.core.errors import Place, UserError, relative
from humanoid_bt.files.whole import write_whole
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.robot.model_file import PREFIX, described_file, described_name
from humanoid_bt.robot.published import model_problems, read_model
from humanoid_bt.robot.survey.description import Description, describe
from humanoid_bt.robot.survey.limbs import NoHumanoidError
from humanoid_bt.session.report import ExitCode

_USAGE = "humanoid-bt robots init MODEL.xml|robot_descriptions:NAME [--name NAME]"
_NO_NAMES = ("model", "scene", "robot")  # what files are called whose folder says what is in them


def robots_init(arguments: list[str], name: str | None, workspace: Workspace) -> int:
    """Write ``sim/NAME/robot.yaml`` for a model.

    Args:
        arguments: what stood behind ``init``: the model's file, or its description.
        name: the robot's; by default the model's.
        workspace: where it is written.

    Raises:
        UserError: there is no such model, it is no humanoid, or the file is there already.
    """
    if len(arguments) != 1:
        raise UserError(f"robots init takes one model, not {len(arguments)}", hint=_USAGE)
    given = arguments[0]
    described = given.startswith(PREFIX)
    model = described_file(given) if described else Path(given)
    if not model.is_file():
        hint = f"a model in MJCF or URDF, as robots/my_robot.xml, or {PREFIX}NAME"
        if model.is_dir():
            inside = sorted(file.name for kind in ("*.xml", "*.urdf") for file in model.glob(kind))
            hint = f"it has: {', '.join(inside)}" if inside else hint
            raise UserError(f"{str(model)!r} is a folder, not a model's file", hint=hint, code="no-file")
        raise UserError(f"there is no file {str(model)!r}", hint=hint, code="no-file")
    name = name or (described_name(given) if described else _name_of(model))
    if not re.fullmatch(r"[\w-]+", name):
        raise UserError(f"{name!r} is no name for a robot", hint="letters, digits, _ and -, as in --name my_robot")
    path = workspace.root / "sim" / name / "robot.yaml"
    if os.path.lexists(path):
        raise UserError(f"{relative(path)!r} is there already", hint="another name: --name NAME")
    description = _described(model, name, given if described else _seen_from(path.parent, model))
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, description.text.encode())
    except OSError as error:
        raise UserError(f"{relative(path)!r} cannot be written: {error.strerror}") from error
    _tell(description, path)
    return ExitCode.SUCCESS


def _described(model: Path, name: str, written: str) -> Description:
    """Return what is found in a model that robot.yaml is to name like this."""
    spec = read_model(model)
    if problems := list(model_problems(spec, Place(relative(model)))):
        raise UserError(problems)
    try:
        compiled = spec.compile()
    except ValueError as error:
        message = f"the model does not compile: {' '.join(str(error).split())}"
        raise UserError(message, Place(relative(model)), code="model") from error
    try:
        return describe(compiled, name, written)
    except NoHumanoidError as error:
        raise UserError(str(error), Place(relative(model)), code="model") from error


def _seen_from(folder: Path, model: Path) -> str:
    """Return the path of a model from a folder, or its whole path if it is far from there."""
    file = os.path.relpath(model.resolve(), folder.resolve())
    return str(model.resolve()) if file.count("..") > 3 else file


def _name_of(model: Path) -> str:
    """Return a name for the robot of a model: the file's, or its folder's if the file's says nothing."""
    name = model.resolve().parent.name if model.stem.lower() in _NO_NAMES else model.stem
    return re.sub(r"[^\w-]+", "_", name)


def _tell(description: Description, path: Path) -> None:
    print(f"{relative(path)}: a first description of the robot")
    for title, lines in (
        ("found", description.found),
        ("guessed", description.guessed),
        ("missing", description.missing),
    ):
        for line in lines:
            print(f"  {title:8} {line}")
    what = "add what is missing, look at" if description.missing else "look at"
    print(f"next: {what} what is guessed, then let it stand, reach and walk")
    print(f"  humanoid-bt check {shlex.quote(relative(path))}")
