"""Jacobians of points of the robot in machine code, from the motions that MuJoCo finds for its degrees of freedom."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from humanoid_bt.core.compiled import inlined
from humanoid_bt.core.messages import Array
from humanoid_bt.robot.model import carriers

Indices = NDArray[np.int64]
"""Of degrees of freedom, sites or bodies."""


def chains(model: mujoco.MjModel, bodies: Sequence[int]) -> Indices:
    """Return for each of some bodies the degrees of freedom that move it, in rising order, and then -1."""
    found = [
        sorted(
            dof
            for link in carriers(model, body)
            for dof in range(model.body_dofadr[link], model.body_dofadr[link] + model.body_dofnum[link])
        )
        for body in bodies
    ]
    table = np.full((len(found), max(map(len, found), default=0) + 1), -1, dtype=np.int64)
    for row, dofs in zip(table, found, strict=True):
        row[: len(dofs)] = dofs
    return table


@inlined
def point_moves(
    motions: Array, origin: Array, point: Array | tuple[float, float, float], chain: Indices, rows: Array
) -> None:
    """Write how a point moves with the degrees of freedom of a chain; all other columns stay.

    Args:
        motions: MuJoCo's ``cdof``: how each degree of freedom turns what it carries, and moves what of that is at
            ``origin``, world frame, shape (nv, 6).
        origin: ``subtree_com`` of the robot, shape (3,) [m].
        point: world frame, shape (3,) [m].
        chain: one row of :func:`chains`.
        rows: shape (3, nv).
    """
    x, y, z = point[0] - origin[0], point[1] - origin[1], point[2] - origin[2]
    for dof in chain:
        if dof < 0:
            break
        a, b, c = motions[dof, 0], motions[dof, 1], motions[dof, 2]
        rows[0, dof] = motions[dof, 3] + b * z - c * y
        rows[1, dof] = motions[dof, 4] + c * x - a * z
        rows[2, dof] = motions[dof, 5] + a * y - b * x


@inlined
def link_turns(motions: Array, chain: Indices, rows: Array) -> None:
    """Write how a link turns with the degrees of freedom of its chain; as :func:`point_moves`."""
    for dof in chain:
        if dof < 0:
            break
        for axis in range(3):
            rows[axis, dof] = motions[dof, axis]
