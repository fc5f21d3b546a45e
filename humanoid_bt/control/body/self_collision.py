"""A limit of the whole-body inverse kinematics: own links come no nearer to each other than a margin."""

from __future__ import annotations

from collections.abc import Sequence

import mink
import mujoco
import numpy as np
from numpy.typing import NDArray

from humanoid_bt.control.body.own_links import OwnLinks
from humanoid_bt.core.compiled import compiled
from humanoid_bt.core.messages import Array
from humanoid_bt.robot.model import RobotModel

_NEAR = 0.02  # m beyond the margin at which two links begin to slow down
_BRAKE_TIME = 0.05  # s in which two links that approach each other come to rest at the margin
_PART_SPEED = 0.1  # m/s at most at which two that are nearer move apart
_LOOKS = 3  # while no link is near another one, every third time is enough: the fastest arm gets 2 cm in between
_FREE = mink.Constraint()  # of none that are near
_HELD_BACK = 1e-3  # of a pull against a link; less is no obstacle: a hand at its target leans on others a little


class SelfCollisionLimit(mink.Limit):  # type: ignore[misc]  # mink has no types
    """Keeps own links apart, whose shapes are capsules.

    Two links may approach each other in proportion to what is left between them: the velocity damper of Faverjon and
    Tournassoud ("A local based approach for path planning of manipulators with a high number of degrees of freedom",
    ICRA 1987). Two that are nearer than the margin move apart, slowly, as far as other limits let them.

    mink's own limit asks for one distance after the other, and takes half as long as the whole rest of a step; here
    MuJoCo's collision detection finds all of them at once.

    Args:
        robot: the robot.

    Attributes:
        model: in which it looks for them; the configuration must be one of it.
        pressures: how much the targets press each two that are near against each other, the problem's multipliers.
    """

    def __init__(self, robot: RobotModel) -> None:
        self._links = OwnLinks(robot, _NEAR)
        self.model = self._links.model
        self._geoms: NDArray[np.int32] = np.empty((0, 2), dtype=np.int32)  # of the links that are near each other
        self._pair = np.array([self.model.ngeom, 1], dtype=np.int32)
        self._approach: Array = np.empty((0, self.model.nv))
        self.pressures: Array = np.empty(0)
        self._rests = 0

    def are_apart(self, data: mujoco.MjData, links: Sequence[int]) -> bool:
        """Return whether links keep their margin to all others in a configuration.

        Args:
            data: its kinematics are up to date.
            links: their bodies.
        """
        mujoco.mj_collision(self.model, data)
        geoms = data.contact.geom
        near = data.contact.dist < self._links.margins.take(geoms.dot(self._pair))
        return not np.isin(self.model.geom_bodyid[geoms[near]], links).any()

    def look(self) -> None:
        """Look at the links the next time, in any case: the configuration has jumped."""
        self._rests = 0

    def compute_qp_inequalities(self, configuration: mink.Configuration, dt: float) -> mink.Constraint:
        """Return how far those that are near each other may approach in ``dt``."""
        self._rests -= 1
        if self._rests > 0:
            return _FREE
        data = configuration.data
        mujoco.mj_collision(self.model, data)
        contact = data.contact
        distances, links = contact.dist, self._links
        geoms, rooms = np.empty((len(distances), 2), dtype=np.int32), np.empty(len(distances))
        count = _find_near(contact.geom, distances, contact.exclude, links.begins, links.margins, dt, geoms, rooms)
        self._geoms = geoms[:count]
        self.pressures = np.zeros(count)
        if not count:
            self._rests = _LOOKS
            return _FREE
        mujoco.mj_makeConstraint(self.model, data)  # gives how each contact opens that is not excluded
        self._approach = -data.efc_J.reshape(-1, self.model.nv)
        return mink.Constraint(self._approach, rooms[:count])

    def obstacle(self, arm: Sequence[int], pull: Array) -> str:
        """Return the body that holds an arm back most, "" for none.

        Args:
            arm: its bodies, the hand first.
            pull: how the degrees of freedom would bring the hand nearer to its target, shape (nv,).
        """
        if not len(self.pressures):
            return ""
        against = self.pressures * (self._approach @ pull)
        pressed: dict[int, float] = {}
        for (one, other), pressure in zip(self.model.geom_bodyid[self._geoms].tolist(), against.tolist(), strict=True):
            if pressure > 0 and (inside := [body for body in (one, other) if body in arm]):
                outer = min(inside, key=arm.index)
                inner = other if outer == one else one
                pressed[inner] = pressed.get(inner, 0.0) + pressure
        most = max(pressed, key=pressed.__getitem__, default=0)
        return self.model.body(most).name if pressed.get(most, 0.0) > _HELD_BACK else ""


@compiled("i8(i4[:, :], f8[:], i4[:], f8[:, ::1], f8[:, ::1], f8, i4[:, ::1], f8[::1])")
def _find_near(
    geoms: NDArray[np.int32],
    distances: Array,
    excluded: NDArray[np.int32],
    begins: Array,
    margins: Array,
    dt: float,
    near: NDArray[np.int32],
    rooms: Array,
) -> int:
    """Exclude the contacts of links that are not near each other; return how many are left.

    Args:
        geoms, distances: of all contacts, shapes (n, 2) and (n,) [m].
        excluded: whether MuJoCo is to pass over them, shape (n,); is written.
        begins, margins: as :class:`OwnLinks` has them.
        dt: [s].
        near, rooms: geoms of those that are near, and how far they may approach in ``dt`` [m], in the first of their
            rows; shapes (n, 2) and (n,); are written.
    """
    count = 0
    for contact in range(len(distances)):
        one, other, distance = geoms[contact, 0], geoms[contact, 1], distances[contact]
        far = distance >= begins[one, other]
        excluded[contact] = far
        if not far:
            near[count, 0], near[count, 1] = one, other
            rooms[count] = max((distance - margins[one, other]) * (dt / _BRAKE_TIME), -_PART_SPEED * dt)
            count += 1
    return count
