"""The program of the inverse kinematics is mink's, and so is its solution."""

from __future__ import annotations

import mink
import numpy as np
import pytest
import qpsolvers

from humanoid_bt.control.body.mink_terms import SOLVER, frame_task
from humanoid_bt.control.body.quadratic_program import QuadraticProgram
from humanoid_bt.core.messages import Array
from humanoid_bt.robot.model import RobotModel, palm_site

DT, DAMPING = 0.005, 1e-4


class SlowJoints(mink.Limit):  # type: ignore[misc]  # mink has no types
    """Some directions in which the body moves no farther than a millimetre, or a milliradian."""

    def __init__(self, nv: int, count: int) -> None:
        ways = np.random.default_rng(count).normal(size=(count, nv))
        self.rows = np.concatenate([ways, -ways])

    def compute_qp_inequalities(self, configuration: mink.Configuration, dt: float) -> mink.Constraint:
        return mink.Constraint(self.rows, np.full(len(self.rows), 1e-3))


class Nothing(mink.Limit):  # type: ignore[misc]  # mink has no types
    def compute_qp_inequalities(self, configuration: mink.Configuration, dt: float) -> mink.Constraint:
        return mink.Constraint()


@pytest.fixture
def configuration(robot: RobotModel, standing: Array) -> mink.Configuration:
    return mink.Configuration(robot.model, standing)


@pytest.fixture
def tasks(robot: RobotModel, configuration: mink.Configuration) -> list[mink.BaseTask]:
    """A posture, and a palm 10 cm off, which has a damping of its own."""
    posture = mink.PostureTask(robot.model, cost=0.3)
    posture.set_target(configuration.q + 0.01)
    palm = frame_task(palm_site("left"), "site", 8.0, 0.0, lm_damping=1.0)
    where = configuration.get_transform_frame_to_world(palm_site("left"), "site").translation()
    palm.set_target(mink.SE3.from_translation(where + 0.1))
    return [posture, palm]


@pytest.mark.parametrize("counts", [[], [0], [2], [1, 3], [10, 14]])
def test_it_is_minks(
    robot: RobotModel, configuration: mink.Configuration, tasks: list[mink.BaseTask], counts: list[int]
) -> None:
    nv = robot.model.nv
    limits = [SlowJoints(nv, count) if count else Nothing() for count in counts]
    program = QuadraticProgram(nv, DAMPING)
    program.low[6:], program.high[6:] = -0.02, 0.02
    for _ in range(2):  # the second time nothing is left of the first
        program.aim(configuration, tasks)
        program.limit(configuration, limits, DT)
        step = program.solve()
    wanted = mink.build_ik(configuration, tasks, DT, DAMPING, limits)
    np.testing.assert_allclose(program.hessian, wanted.P, atol=1e-9)
    np.testing.assert_allclose(program.gradient, wanted.q, atol=1e-9)
    if sum(counts):
        np.testing.assert_array_equal(program.rows, wanted.G)
        np.testing.assert_array_equal(program.rooms, wanted.h)
    wanted.lb, wanted.ub = program.low, program.high
    solution = qpsolvers.solve_problem(wanted, SOLVER)
    np.testing.assert_allclose(step, solution.x, atol=1e-9)
    if sum(counts):
        np.testing.assert_allclose(program.pressures, solution.z, atol=1e-6)
        assert (program.pressures > 0).any()


def test_fewer_limits_than_before_leave_nothing_behind(
    robot: RobotModel, configuration: mink.Configuration, tasks: list[mink.BaseTask]
) -> None:
    program = QuadraticProgram(robot.model.nv, DAMPING)
    program.aim(configuration, tasks)
    free = program.solve()
    program.limit(configuration, [SlowJoints(robot.model.nv, 20)], DT)
    held = program.solve()
    program.limit(configuration, [Nothing()], DT)
    np.testing.assert_array_equal(program.solve(), free)
    assert free is not None
    assert held is not None
    assert np.abs(held - free).max() > 1e-3
    assert not len(program.pressures)


def test_what_has_no_solution_is_none(
    robot: RobotModel, configuration: mink.Configuration, tasks: list[mink.BaseTask]
) -> None:
    program = QuadraticProgram(robot.model.nv, DAMPING)
    program.aim(configuration, tasks)
    program.low[8], program.high[8] = 0.01, -0.01
    assert program.solve() is None
