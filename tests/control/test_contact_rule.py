"""What follows when something touches the robot, without a robot."""

from __future__ import annotations

import numpy as np
import pytest

from humanoid_bt.control.contact_rule import ContactRule
from humanoid_bt.core.messages import Array, BaseTarget, Command, HandTarget, Target
from humanoid_bt.robot.config import ContactConfig

PERIOD = 5  # servo cycles
HAND = HandTarget(np.array([0.4, 0.1, 0.9]))


class Touched:
    """A rule, and what pushes the robot."""

    def __init__(self) -> None:
        self.rule = ContactRule(ContactConfig())
        self.cycle = 0
        self.targets: dict[str, Target] = {}
        self.source = "root/reach"

    def push(self, seconds: float, **forces: tuple[float, float, float]) -> ContactRule:
        """Push for a while with forces on groups of links [N]."""
        pushed: dict[str, Array] = {
            group: np.array(forces.get(group, (0.0, 0.0, 0.0))) for group in ("left_arm", "right_arm", "torso")
        }
        command = Command(0, 0.0, self.targets, dict.fromkeys(self.targets, self.source))
        for _ in range(round(seconds * 1000) // PERIOD):
            self.cycle += PERIOD
            self.rule.look(self.cycle, pushed, command, np.zeros(2))
        return self.rule


@pytest.fixture
def touched() -> Touched:
    return Touched()


def test_an_arm_that_is_pushed_hard_yields_and_says_how_hard(touched: Touched) -> None:
    assert not touched.push(0.1, left_arm=(20.0, 0.0, 0.0)).yielding
    contact = touched.rule.contacts["left_arm"]
    assert not contact.yields
    rule = touched.push(0.1, left_arm=(0.0, 30.0, 0.0))
    assert rule.yielding == {"left"}
    touched.push(0.1, left_arm=(0.0, 43.0, 0.0))
    rule = touched.push(0.1, left_arm=(0.0, 9.0, 0.0))
    contact = rule.contacts["left_arm"]
    assert contact.yields
    assert contact.largest == 43.0
    assert contact.force.tolist() == [0.0, 9.0, 0.0]
    assert list(rule.contacts) == ["left_arm"]
    touched.push(0.1)
    assert touched.push(0.1, left_arm=(10.0, 0.0, 0.0)).contacts["left_arm"].largest == 43.0  # since it yields


def test_it_is_soft_until_its_node_has_let_go_and_nothing_touches_it(touched: Touched) -> None:
    touched.targets = {"left_hand": HAND}
    touched.push(0.1, left_arm=(30.0, 0.0, 0.0))
    assert touched.push(5.0).yielding  # the node still wants the hand there
    touched.targets = {}
    touched.push(0.02)
    touched.targets = {"left_hand": HAND}  # asked anew
    assert not touched.push(0.02).yielding
    touched.targets = {}
    touched.push(0.1, left_arm=(30.0, 0.0, 0.0))
    assert touched.push(1.0, left_arm=(10.0, 0.0, 0.0)).yielding  # something still touches it
    assert touched.push(0.45).yielding
    assert not touched.push(0.1).yielding


def test_another_node_that_wants_the_hand_asks_anew(touched: Touched) -> None:
    touched.targets = {"left_hand": HAND}
    touched.push(0.1, left_arm=(30.0, 0.0, 0.0))
    touched.source = "root/wave"
    assert not touched.push(0.6).yielding


def test_a_hand_that_is_to_press_yields_later_and_is_noticed_sooner(touched: Touched) -> None:
    touched.targets = {"left_hand": HandTarget(np.zeros(3), press=20.0)}
    assert not touched.push(0.1, left_arm=(35.0, 0.0, 0.0)).yielding
    assert touched.rule.pressed == {"left_arm"}
    assert touched.push(0.1, left_arm=(45.0, 0.0, 0.0)).yielding
    other = Touched()
    assert not other.push(0.1, left_arm=(5.0, 0.0, 0.0)).contacts
    other.targets = {"left_hand": HandTarget(np.zeros(3), press=5.0)}
    assert other.push(0.1, left_arm=(5.0, 0.0, 0.0)).contacts
    other.targets = {}
    assert other.push(0.1).pressed == frozenset()
    other.targets = {"left_hand": HandTarget(np.zeros(3), press=50.0)}
    assert other.push(0.1, left_arm=(10.0, 0.0, 0.0)).contacts  # never later than one that is not to press


def test_a_push_on_the_torso_is_only_told(touched: Touched) -> None:
    touched.targets = {"base": BaseTarget(np.array([2.0, 0.0]), 0.0)}
    rule = touched.push(0.2, torso=(-150.0, 0.0, 0.0))
    assert rule.contacts["torso"].largest == 150.0
    assert rule.pressed == {"torso"}
    assert not rule.held
    assert not rule.yielding
    assert not touched.push(5.0, torso=(60.0, 10.0, 0.0)).held  # from behind
    assert rule.contacts["torso"].largest == 150.0


def test_a_contact_ends_at_less_than_it_begins_with(touched: Touched) -> None:
    assert not touched.push(0.1, left_arm=(7.0, 0.0, 0.0)).contacts
    assert touched.push(0.1, left_arm=(9.0, 0.0, 0.0)).contacts
    assert touched.push(0.1, left_arm=(7.0, 0.0, 0.0)).contacts
    assert not touched.push(0.1, left_arm=(4.0, 0.0, 0.0)).contacts


@pytest.mark.parametrize("force", [10.0, 30.0])
def test_a_contact_that_was_told_does_not_change_afterwards(force: float) -> None:
    rule, pushes = ContactRule(ContactConfig()), np.array([force, 0.0, 0.0])
    rule.look(PERIOD, {"left_arm": pushes}, None, np.zeros(2))
    contact = rule.contacts["left_arm"]
    pushes[:] = 0.0
    assert contact.force.tolist() == [force, 0.0, 0.0]


def test_what_is_in_the_way_stops_the_robot_until_it_is_gone_for_a_while(touched: Touched) -> None:
    touched.targets = {"base": BaseTarget(np.array([2.0, 0.0]), 0.0)}
    for _ in range(4):  # it comes and goes with the robot's steps
        touched.push(0.2, torso=(-60.0, 0.0, 0.0))
        touched.push(0.2)
    assert touched.rule.held == "something is in the way of the torso: 60 N"
    assert touched.push(0.7).held
    assert not touched.push(0.2).held
    assert not touched.push(0.4, torso=(-60.0, 0.0, 0.0)).held  # it counts anew


def test_short_contacts_far_apart_do_not_stop_the_robot(touched: Touched) -> None:
    touched.targets = {"base": BaseTarget(np.array([2.0, 0.0]), 0.0)}
    for _ in range(5):
        assert not touched.push(0.2, torso=(-60.0, 0.0, 0.0)).held
        touched.push(1.0)


def test_what_is_in_the_way_again_and_again_blocks_the_robot_until_a_person_lets_it_go_on(touched: Touched) -> None:
    touched.targets = {"base": BaseTarget(np.array([2.0, 0.0]), 0.0)}
    for _ in range(2):
        touched.push(0.6, torso=(-60.0, 0.0, 0.0))
        assert not touched.push(4.0).blocked
    rule = touched.push(0.6, torso=(-60.0, 0.0, 0.0))
    assert rule.blocked == "something is in the way of the torso: 60 N, 3 times within 20 s"
    touched.push(11.0, torso=(-60.0, 0.0, 0.0))  # which is too long as well
    assert rule.blocked.endswith(", 3 times within 20 s")
    assert touched.push(30.0).blocked
    for _ in range(3):
        rule.forgive()
        assert not touched.push(0.6, torso=(-60.0, 0.0, 0.0)).blocked


def test_what_is_in_the_way_now_and_then_does_not_block_it(touched: Touched) -> None:
    touched.targets = {"base": BaseTarget(np.array([2.0, 0.0]), 0.0)}
    for _ in range(5):
        touched.push(0.6, torso=(-60.0, 0.0, 0.0))
        assert not touched.push(10.0).blocked


def test_what_stays_in_the_way_blocks_it(touched: Touched) -> None:
    touched.targets = {"base": BaseTarget(np.array([2.0, 0.0]), 0.0)}
    assert not touched.push(10.0, torso=(-60.0, 0.0, 0.0)).blocked
    rule = touched.push(1.0, torso=(-60.0, 0.0, 0.0))
    assert rule.blocked == "something is in the way of the torso: 60 N, for more than 10 s"


def test_an_arm_on_its_way_home_yields_sooner(touched: Touched) -> None:
    assert not touched.push(0.1, left_arm=(18.0, 0.0, 0.0)).yielding
    touched.rule.homeward = frozenset({"left"})
    assert touched.push(0.1, left_arm=(18.0, 0.0, 0.0)).yielding


def test_an_arm_that_yields_is_in_the_way_too(touched: Touched) -> None:
    touched.targets = {"base": BaseTarget(np.array([2.0, 0.0]), 0.0)}
    assert not touched.push(0.6, left_arm=(-20.0, 0.0, 0.0)).held  # it does not yield yet
    assert "the left arm: 30 N" in touched.push(0.6, left_arm=(-30.0, 0.0, 0.0)).held


def test_it_begins_anew_with_a_robot_that_nothing_touches(touched: Touched) -> None:
    touched.targets = {"base": BaseTarget(np.array([2.0, 0.0]), 0.0), "left_hand": HandTarget(np.zeros(3), press=10.0)}
    rule = touched.push(12.0, torso=(-60.0, 0.0, 0.0), left_arm=(-45.0, 0.0, 0.0))
    assert rule.yielding
    assert rule.blocked
    rule.reset()
    assert not rule.pressed
    rule.look(0, {"left_arm": np.zeros(3), "torso": np.zeros(3)}, None, np.zeros(2))
    assert not (rule.yielding or rule.pressed or rule.contacts or rule.held or rule.blocked)
    touched.cycle = 0
    touched.push(12.0, torso=(-60.0, 0.0, 0.0))
    rule.reset()
    touched.cycle = 0
    assert not touched.push(0.4, torso=(-60.0, 0.0, 0.0)).held
    assert touched.push(0.2, torso=(-60.0, 0.0, 0.0)).held
