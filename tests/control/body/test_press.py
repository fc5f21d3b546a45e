from __future__ import annotations

import numpy as np
import pytest

from humanoid_bt.control.body.press import Press

DT = 0.005
STIFFNESS = 1000.0  # N/m of a wall where the palm begins


def test_it_presses_harder_no_faster_than_the_body_leans() -> None:
    press, point, force = Press(DT), np.zeros(3), 0.0
    felt = []
    for _ in range(round(4 / DT)):
        point = press.aim(np.array([0.3, 0.0, 0.0]), 50.0, point, np.array([-force, 0.0, 0.0]))
        force = STIFFNESS * point[0]
        felt.append(force)
    assert max(np.diff(felt[round(0.2 / DT) :])) < 25 * DT
    assert felt[-1] == pytest.approx(50, abs=1)
    assert max(felt) < 51


def test_it_begins_anew_for_another_target_and_moves_no_faster_than_ever() -> None:
    press, point, touches = Press(DT), np.zeros(3), np.array([-10.0, 0.0, 0.0])
    for target, force, meets in (
        ([0.3, 0.0, 0.0], touches, False),
        ([0.0, 0.3, 0.0], np.zeros(3), True),
        ([0.0, 0.26, 0.0], touches, True),  # nearer than where it is
        ([-0.2, 0.0, 0.0], np.zeros(3), True),
    ):
        for _ in range(round(5 / DT)):
            before, point = point, press.aim(np.array(target), 10.0, point, force)
            assert np.linalg.norm(point - before) <= 0.1 * DT + 1e-9
        assert (np.linalg.norm(point - target) < 1e-6) == meets


def test_it_gives_way_to_a_blow_no_faster_than_ever_and_keeps_to_its_way() -> None:
    press, point = Press(DT), np.zeros(3)
    for target in ([0.3, 0.0, 0.0], [0.3, 0.04, 0.0]):  # a little aside: it does not slide there
        for _ in range(10):
            before, point = point, press.aim(np.array(target), 10.0, point, np.array([-60.0, 0.0, 0.0]))
            assert before[0] - point[0] == pytest.approx(0.1 * DT)
            assert point[1] == 0.0
    for _ in range(10):  # nor where it has bounced off
        assert press.aim(np.array([0.3, 0.04, 0.0]), 10.0, point, np.zeros(3))[1] == 0.0


@pytest.mark.parametrize("elsewhere", [0.0, 0.1], ids=["after it was let go", "elsewhere"])
def test_it_presses_gently_whenever_it_begins(elsewhere: float) -> None:
    press, point, touches = Press(DT), np.zeros(3), np.array([-10.0, 0.0, 0.0])
    for _ in range(round(1.5 / DT)):
        point = press.aim(np.array([0.3, 0.0, 0.0]), 50.0, point, touches)
    if not elsewhere:
        press.reset()
    palm = np.array([0.0, 0.02, 0.02])
    after = press.aim(palm + np.array([0.3 + elsewhere, 0.0, 0.0]), 50.0, palm, touches)
    assert -0.1 * DT <= after[0] < 0.0  # 10 N are more than it begins with
    np.testing.assert_array_equal(after[1:], palm[1:])
