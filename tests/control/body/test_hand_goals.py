"""Where commanded palms are brought: what of one command lasts into the next."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from humanoid_bt.control.body.hand_goals import HandGoals
from humanoid_bt.core.messages import SIDES, Array, HandTarget
from humanoid_bt.robot.model import RobotModel

DT = 0.005
PALMS = {side: np.array([0.3, y, 1.0]) for side, y in zip(SIDES, (0.2, -0.2), strict=True)}
PRESSING = {"left_hand": HandTarget(np.array([0.6, 0.2, 1.0]), press=40.0)}
LEADS = {"right_hand": HandTarget(PALMS["right"])}
LED = {"left_hand": HandTarget(np.array([0.0, 0.6, 0.0]), relative=True)}


@pytest.fixture
def arms() -> SimpleNamespace:
    return SimpleNamespace(sides=frozenset(), away=lambda side: None)


@pytest.fixture
def goals(robot: RobotModel, arms: Any) -> HandGoals:
    """Those of palms that do not move, the left one of which touches something."""
    palms: Any = SimpleNamespace(palm=lambda side: PALMS[side], palm_frame=lambda side: np.eye(3))
    touched: Any = SimpleNamespace(forces={"left_arm": np.array([-10.0, 0.0, 0.0]), "right_arm": np.zeros(3)})
    return HandGoals(robot, palms, palms, contact=touched, arms=arms, dt=DT)


def goes_on(goals: HandGoals, targets: dict[str, HandTarget], hold: bool = False, periods: int = 1) -> Array | None:
    """Return where the left palm is to go in the end, None if nowhere."""
    for _ in range(periods):
        positions, _ = goals.update(targets, hold, np.zeros(3), False)
    return positions.get("left")


@pytest.mark.parametrize(
    ("targets", "hold", "yields"),
    [
        ({}, False, False),
        ({"left_hand": HandTarget(PALMS["left"])}, False, False),
        ({**LEADS, "left_hand": HandTarget(np.array([0.0, 0.4, 0.0]), relative=True)}, False, False),
        (PRESSING, True, False),
        ({}, False, True),
    ],
    ids=["let go", "elsewhere", "led by the other one", "held", "it yielded"],
)
def test_a_palm_that_is_to_press_again_begins_gently_where_it_is(
    goals: HandGoals, arms: SimpleNamespace, targets: dict[str, HandTarget], hold: bool, yields: bool
) -> None:
    pressed = goes_on(goals, PRESSING, periods=200)
    assert pressed is not None
    assert pressed[0] > PALMS["left"][0] + 0.01
    arms.sides = frozenset({"left"} if yields else ())
    goes_on(goals, targets, hold, periods=200)
    arms.sides = frozenset()
    again = goes_on(goals, PRESSING, periods=20)
    assert again is not None
    assert again[0] <= PALMS["left"][0]  # what it feels is more than it begins with


def test_all_palms_are_let_go_of_at_the_beginning_of_a_run(goals: HandGoals) -> None:
    goes_on(goals, PRESSING, periods=200)
    goals.reset()
    again = goes_on(goals, PRESSING, periods=20)
    assert again is not None
    assert again[0] <= PALMS["left"][0]


@pytest.mark.parametrize("yields", [True, False], ids=["it yielded", "a run begins"])
def test_a_palm_goes_on_from_where_it_is_when(goals: HandGoals, arms: SimpleNamespace, yields: bool) -> None:
    reaching = {"left_hand": HandTarget(np.array([0.6, 0.2, 1.0]))}
    far = goes_on(goals, reaching, periods=200)
    assert far is not None
    if yields:
        arms.sides = frozenset({"left"})
        assert goes_on(goals, {}) is None
        arms.sides = frozenset()
    else:
        goals.reset()
    again = goes_on(goals, reaching)
    assert again is not None
    assert again[0] < far[0] - 0.02


def test_a_palm_that_is_led_stays_so_in_a_hold(goals: HandGoals) -> None:
    led = goes_on(goals, LEADS | LED, periods=200)
    assert led is not None
    assert led[1] > PALMS["left"][1] + 0.02
    np.testing.assert_allclose(goes_on(goals, {}, hold=True, periods=20), led)


def test_a_palm_is_let_go_of_while_the_one_that_leads_it_yields(goals: HandGoals, arms: SimpleNamespace) -> None:
    led = goes_on(goals, LEADS | LED, periods=200)
    assert led is not None
    arms.sides = frozenset({"right"})
    assert goes_on(goals, LED) is None
    arms.sides = frozenset()
    again = goes_on(goals, LEADS | LED)
    assert again is not None
    assert again[1] < led[1] - 0.01  # from where it is


def test_a_palm_that_is_led_presses_on_nothing(robot: RobotModel, goals: HandGoals) -> None:
    led = goes_on(goals, LEADS | LED, periods=50)
    goals.reset()
    pressing = {"left_hand": replace(LED["left_hand"], press=20.0)}
    np.testing.assert_array_equal(goes_on(goals, LEADS | pressing, periods=50), led)
