"""The figures of control, with few cycles: what is measured, not how much it is."""

from __future__ import annotations

import pytest

from humanoid_bt.bench import control
from humanoid_bt.bench.promises import ESTIMATE, LOG, LOG_USUAL, OWN_LINKS


def test_each_part_of_control_has_a_figure_and_a_promise(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(control, "_CYCLES", 60)
    figures = list(control.measure_control(2))
    promises = [ESTIMATE, OWN_LINKS, LOG_USUAL, LOG, LOG_USUAL, LOG]
    assert [figure.promise for figure in figures] == promises
    assert all(0 < figure.low <= figure.ratio <= figure.high for figure in figures)


@pytest.mark.trials
def test_its_robots_do_what_is_measured() -> None:
    walking, pressing = control.CommandedRobot(dict(control._FAR)), control.CommandedRobot(dict(control._HANDS))
    for robot in (walking, pressing):
        robot.run(1500)
    assert walking.controller.state().base_position[0] > 0.1
    assert set(pressing.controller.state().hand_obstacles) == {"left", "right"}
