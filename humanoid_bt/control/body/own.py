"""A body of the user's own: a class in a Python file that ``robot.yaml`` names."""

from __future__ import annotations

from typing import Any

from humanoid_bt.control.body.body import Body
from humanoid_bt.control.body.yielding import Felt
from humanoid_bt.control.dynamics import RobotDynamics
from humanoid_bt.core.errors import Place, UserError, relative
from humanoid_bt.files.class_files import class_place, classes_of, load_module
from humanoid_bt.files.reading import is_file
from humanoid_bt.robot.config import RobotConfig
from humanoid_bt.robot.model import RobotModel

_CODE = "broken-body"


def own_body(robot: RobotModel, dynamics: RobotDynamics, contact: Felt) -> Body:
    """Return the body that the user's class makes of these, as :class:`WholeBody` is made.

    Raises:
        UserError: there is no such file, it has not one body, or that one lacks what every body has.
    """
    cls = _class(robot.config)
    try:
        body: Body = cls(robot, dynamics, contact)
    except TypeError as error:
        hint = "def __init__(self, robot, dynamics, contact)"
        raise UserError(f"{cls.__name__} cannot be made: {error}", class_place(cls), hint, _CODE) from error
    missing = sorted(name for name in vars(Body).keys() - set(dir(body)) if not name.startswith("_"))
    if missing:
        hint = "what each is to do: humanoid_bt.control.body.body.Body; or build on WholeBody"
        raise UserError(f"the body {cls.__name__} has no {', '.join(missing)}", class_place(cls), hint, _CODE)
    return body


def _class(config: RobotConfig) -> type[Any]:
    named, place = config.body.own, config.place("body", "own")
    if named is None:
        raise UserError("there is no body of your own", place, "body: {walk: own, own: my_body.py}", "missing-key")
    path = config.path.parent / named
    if not is_file(path):
        raise UserError(f"the body {named!r} is missing", place, f"looked for {relative(path)}", "no-file")
    classes = [cls for cls in classes_of(load_module(path, "body"), object) if hasattr(cls, "update")]
    if len(classes) != 1:
        many = f"{len(classes)} bodies: {', '.join(cls.__name__ for cls in classes)}" if classes else "no body"
        hint = "one class with def update(self, estimate, targets, hold); a leading underscore for those it builds on"
        raise UserError(f"this file has {many}", Place(relative(path), 1, 1), hint, _CODE)
    return classes[0]
