"""mink's tasks and limits as one quadratic program, solved by daqp."""

from __future__ import annotations

import math
from collections.abc import Sequence

import daqp
import mink
import numpy as np

from humanoid_bt.core.messages import Array

_NO_BOUND = 1e30  # for the solver


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
        self._no_rows = np.zeros((0, nv)), np.zeros(0)
        self.hessian, self.gradient = np.zeros((nv, nv)), np.zeros(nv)
        self.rows, self.rooms = self._no_rows
        self.low, self.high = np.full(nv, -_NO_BOUND), np.full(nv, _NO_BOUND)
        self.pressures: Array = np.zeros(0)

    def aim(self, configuration: mink.Configuration, tasks: Sequence[mink.BaseTask]) -> None:
        """Take the tasks, each of which has a residual."""
        hessian, gradient, damping = self.hessian, self.gradient, self._damping
        hessian[:] = 0.0
        gradient[:] = 0.0
        for task in tasks:
            jacobian, error, own_damping = task.compute_qp_residual(configuration)
            hessian += jacobian.T @ jacobian
            gradient -= error @ jacobian
            damping += own_damping
        hessian.reshape(-1)[:: self._nv + 1] += damping

    def limit(self, configuration: mink.Configuration, limits: Sequence[mink.Limit], dt: float) -> None:
        """Take the limits."""
        found = [limit.compute_qp_inequalities(configuration, dt) for limit in limits]
        active = [one for one in found if not one.inactive]
        self.rows, self.rooms = (
            (np.concatenate([one.G for one in active]), np.concatenate([one.h for one in active]))
            if active
            else self._no_rows
        )

    def solve(self) -> Array | None:
        """Return the step, shape (nv,); None if there is none."""
        count = len(self.rooms)
        high, low = np.concatenate((self.high, self.rooms)), np.concatenate((self.low, np.full(count, -_NO_BOUND)))
        kinds = np.zeros(len(high), dtype=np.intc)
        step, _, found, told = daqp.solve(self.hessian, self.gradient, self.rows, high, low, kinds)
        if found <= 0 or not math.isfinite(step @ step):
            return None
        self.pressures = told["lam"][self._nv :]
        return np.asarray(step)
