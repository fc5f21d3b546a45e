"""mink's tasks and limits as one quadratic program, in buffers that stay, solved by daqp."""

from __future__ import annotations

import math
from collections.abc import Sequence

import daqp
import mink
import numpy as np

from humanoid_bt.control.body.rows_task import RowsTask
from humanoid_bt.core.compiled import compiled, inlined
from humanoid_bt.core.messages import Array

_NO_BOUND = 1e30  # for the solver
_ROWS = 32  # of limits that there is room for at first


class QuadraticProgram:
    """The step x that serves the tasks best: it minimizes x' H x / 2 + c' x, with G x <= h and low <= x <= high.

    These are the H, c, G and h of ``mink.build_ik``, and the solver is that of ``mink.solve_ik``. What these two and
    qpsolvers check and copy in between takes four times as long as the solver: too long for every control period.

    Args:
        nv: degrees of freedom.
        damping: added to the diagonal of H.

    Attributes:
        hessian, gradient: H and c, shape (nv, nv) and (nv,).
        rows, rooms: G and h, shape (n, nv) and (n,).
        low, high: shape (nv,).
        pressures: how hard each of the rows had to hold back the last step, its multipliers, shape (n,).
    """

    def __init__(self, nv: int, damping: float) -> None:
        self._nv, self._damping = nv, damping
        self.hessian, self.gradient = np.zeros((nv, nv)), np.zeros(nv)
        self._row = np.zeros(nv)
        self.pressures: Array = np.zeros(0)
        self._rows: Array = np.zeros((0, nv))
        self._low: Array = np.zeros(0)
        self._high: Array = np.zeros(0)
        self._make_room(_ROWS)

    def aim(self, configuration: mink.Configuration, tasks: Sequence[mink.BaseTask]) -> None:
        """Take the tasks, each of which has a residual."""
        self.hessian.fill(0.0)
        self.gradient.fill(0.0)
        damping = self._damping
        for task in tasks:
            if isinstance(task, RowsTask):
                _add_rows(self.hessian, self.gradient, task.jacobian, task.error, task.cost, self._row)
                damping += task.damping
            else:
                jacobian, error, own_damping = task.compute_qp_residual(configuration)
                _add_weighted(self.hessian, self.gradient, np.ascontiguousarray(jacobian), error)
                damping += own_damping
        _add_damping(self.hessian, damping)

    def limit(self, configuration: mink.Configuration, limits: Sequence[mink.Limit], dt: float) -> None:
        """Take the limits."""
        end = 0
        for limit in limits:
            rows, rooms = limit.compute_qp_inequalities(configuration, dt)
            if rows is None or rooms is None:
                continue
            begin, end = end, end + len(rooms)
            if end > len(self._rows):
                self._make_room(2 * end)
            self._rows[begin:end] = rows
            self._high[self._nv + begin : self._nv + end] = rooms
        if end != len(self.rooms):
            self._take(end)

    def solve(self) -> Array | None:
        """Return the step, shape (nv,); None if there is none."""
        step, _, found, told = daqp.solve(self.hessian, self.gradient, self.rows, *self._bounds)
        if found <= 0 or not math.isfinite(step.dot(step)):
            return None
        self.pressures = told["lam"][self._nv :]
        return np.asarray(step)

    def _take(self, count: int) -> None:
        """Take so many of the rows that there is room for."""
        end = self._nv + count
        self.rows, self.rooms = self._rows[:count], self._high[self._nv : end]
        self._bounds = self._high[:end], self._low[:end], self._kinds[:end]

    def _make_room(self, most: int) -> None:
        """Make buffers for so many rows, whose bounds stand behind those of the step, as the solver wants it."""
        nv, had = self._nv, len(self._rows)
        rows, low, high = np.zeros((most, nv)), np.full(nv + most, -_NO_BOUND), np.full(nv + most, _NO_BOUND)
        if had:
            rows[:had], low[: nv + had], high[: nv + had] = self._rows, self._low, self._high
        self._rows, self._low, self._high = rows, low, high
        self._kinds = np.zeros(nv + most, dtype=np.intc)  # all of them inequalities
        self.low, self.high = low[:nv], high[:nv]
        self._take(had)


@inlined
def _add(hessian: Array, gradient: Array, row: Array, error: float) -> None:
    """Add the normal equations of a weighted row most of whose numbers are zeros: J^T J, and -J^T e."""
    size = len(row)
    for i in range(size):
        share = row[i]
        if share != 0.0:
            gradient[i] -= share * error
            for j in range(size):
                hessian[i, j] += share * row[j]


@compiled("void(f8[:, ::1], f8[::1], f8[:, ::1], f8[::1])")
def _add_weighted(hessian: Array, gradient: Array, jacobian: Array, error: Array) -> None:
    """Add weighted rows.

    Args:
        hessian, gradient: are added to.
        jacobian, error: J and e.
    """
    for place in range(len(error)):
        _add(hessian, gradient, jacobian[place], error[place])


@compiled("void(f8[:, ::1], f8[::1], f8[:, ::1], f8[::1], f8[::1], f8[::1])")
def _add_rows(hessian: Array, gradient: Array, jacobian: Array, error: Array, cost: Array, weighted: Array) -> None:
    """Add rows, weighted by their cost.

    Args:
        hessian, gradient: are added to.
        jacobian, error, cost: of the task.
        weighted: scratch, shape (nv,).
    """
    for place in range(len(error)):
        for i in range(len(weighted)):
            weighted[i] = cost[place] * jacobian[place, i]
        _add(hessian, gradient, weighted, cost[place] * error[place])


@compiled("void(f8[:, ::1], f8)")
def _add_damping(hessian: Array, damping: float) -> None:
    """Add to the diagonal of a matrix."""
    for dof in range(len(hessian)):
        hessian[dof, dof] += damping
