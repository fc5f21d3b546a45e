"""A body of the user's own: a class in a Python file that ``robot.yaml`` names."""

from __future__ import annotations

from typing import Any

from humanoid_bt.control.body.body import Body
from humanoid_bt.control.body.guarded import FAULTS, GuardedBody, refusal
from humanoid_bt.control.body.yielding import Felt
from humanoid_bt.control.dynamics import RobotDynamics
from humanoid_bt.core.clock import ESTIMATE_PERIOD
from humanoid_bt.core.errors import Place, UserError, relative
from humanoid_bt.files.class_files import class_place, classes_of, load_module
from humanoid_bt.files.reading import is_file
from humanoid_bt.robot.config import RobotConfig
from humanoid_bt.robot.model import RobotModel

_CODE = "broken-body"
_SAME = 1e-9  # s


def own_body(robot: RobotModel, dynamics: RobotDynamics, contact: Felt) -> GuardedBody:
    """Return the body that the user's class makes of these, as :class:`WholeBody` is made, and guarded.

    Raises:
        UserError: there is no such file, it has not one body, or that one cannot be made or lacks what every body has.
    """
    cls = _class(robot.config)
    try:
        body: Body = cls(robot, dynamics, contact)
    except FAULTS as error:
        if isinstance(error, TypeError) and error.__traceback__ and error.__traceback__.tb_next is None:
            hint = "def __init__(self, robot, dynamics, contact)"
            raise UserError(f"{cls.__name__} cannot be made: {error}", class_place(cls), hint, _CODE) from error
        raise refusal(error, cls, "cannot be made") from error
    missing = sorted(name for name in vars(Body).keys() - set(dir(body)) if not name.startswith("_"))
    if missing:
        hint = "what each is to do: humanoid_bt.control.body.body.Body; or build on WholeBody"
        raise UserError(f"the body {cls.__name__} has no {', '.join(missing)}", class_place(cls), hint, _CODE)
    _refuse_period(body)
    return GuardedBody(body, robot.joint_names, dynamics)


def _refuse_period(body: Body) -> None:
    """Refuse a time between two updates that control has no cycles for.

    Raises:
        UserError: it is none.
    """
    cls = type(body)
    try:
        period = body.period
        times = round(period / ESTIMATE_PERIOD)
        right = times >= 1 and abs(times * ESTIMATE_PERIOD - period) < _SAME
    except FAULTS as error:
        raise refusal(error, cls, "does not say its period") from error
    if not right:
        hint = f"a whole multiple of {ESTIMATE_PERIOD:g} s, the period of the estimate"
        raise UserError(f"the body {cls.__name__} has a period of {period} s", class_place(cls), hint, _CODE)


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
