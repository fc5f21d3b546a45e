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


@inlined
def momenta(
    motions: Array,
    origin: Array,
    places: Array,
    turns: Array,
    masses: Array,
    inertias: Array,
    whole: float,
    moved_by: Indices,
    moves: Array,
    spins: Array,
) -> None:
    """Write how a robot's momentum changes with its degrees of freedom.

    It is what ``mj_jacSubtreeCom`` and ``mj_angmomMat`` write. They take five times as long: each makes whole Jacobians
    of all links, and the second one rows that nobody asks for.

    Args:
        motions: as in :func:`point_moves`.
        origin: the robot's centre of mass, which is their origin, shape (3,) [m].
        places, turns: of all links the centre of mass, and the rotation matrix of the principal axes of inertia, world
            frame, shapes (n, 3) and (n, 9).
        masses, inertias: of all links, shapes (n,) [kg] and (n, 3) [kg m^2].
        whole: mass of the robot [kg].
        moved_by: the degrees of freedom of all links: their :func:`chains`.
        moves: how the robot's centre of mass moves, shape (3, nv); is written.
        spins: the angular momentum about the vertical, shape (nv,), or (0,) if nobody asks for it; is written.
    """
    moves[:], spins[:] = 0.0, 0.0
    for link in range(len(masses)):
        mass, turn = masses[link], turns[link]
        x, y, z = places[link, 0] - origin[0], places[link, 1] - origin[1], places[link, 2] - origin[2]
        along, across, up = turn[6] * inertias[link, 0], turn[7] * inertias[link, 1], turn[8] * inertias[link, 2]
        about_x = along * turn[0] + across * turn[1] + up * turn[2]  # of the inertia the row of the vertical
        about_y = along * turn[3] + across * turn[4] + up * turn[5]
        about_z = along * turn[6] + across * turn[7] + up * turn[8]
        for dof in moved_by[link]:
            if dof < 0:
                break
            a, b, c = motions[dof, 0], motions[dof, 1], motions[dof, 2]
            move_x, move_y = motions[dof, 3] + (b * z - c * y), motions[dof, 4] + (c * x - a * z)
            moves[0, dof] += mass * move_x
            moves[1, dof] += mass * move_y
            moves[2, dof] += mass * (motions[dof, 5] + (a * y - b * x))
            if len(spins):
                spins[dof] += about_x * a + about_y * b + about_z * c
                spins[dof] += mass * (x * move_y - y * move_x)
    moves *= 1 / whole
