"""A task of mink's whose rows stay in arrays of its own."""

from __future__ import annotations

from abc import abstractmethod

import mink
import numpy as np
from mink.tasks import BaseTask

from humanoid_bt.core.messages import Array


class RowsTask(BaseTask):  # type: ignore[misc]  # mink has no types
    """Rows of a least-squares problem: the program takes them as they are, anybody else weighted, as mink wants them.

    Args:
        count: how many rows.
        nv: degrees of freedom.

    Attributes:
        jacobian: shape (count, nv).
        error: shape (count,).
        cost: of an error, shape (count,).
    """

    def __init__(self, count: int, nv: int) -> None:
        self.jacobian: Array = np.zeros((count, nv))
        self.error: Array = np.zeros(count)
        self.cost: Array = np.zeros(count)

    @property
    @abstractmethod
    def damping(self) -> float:
        """How much it damps now."""

    def compute_qp_residual(self, configuration: mink.Configuration) -> tuple[Array, Array, float]:
        """Return the weighted Jacobian, the weighted error, and how much it damps."""
        return self.cost[:, None] * self.jacobian, self.cost * self.error, self.damping

    def compute_qp_objective(self, configuration: mink.Configuration) -> mink.Objective:
        """Return the same as a quadratic objective."""
        jacobian, error, damping = self.compute_qp_residual(configuration)
        return mink.Objective(jacobian.T @ jacobian + damping * np.eye(len(jacobian.T)), -(error @ jacobian))
