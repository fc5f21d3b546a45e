from __future__ import annotations

import pytest
from py_trees.common import Status

from humanoid_bt.core import forks
from humanoid_bt.core.errors import ResourceConflict, UserError
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.ticking.executor import NodeError
from tests.tree.helpers import Run, load, run, seen


def test_a_tick_commits_one_command_with_its_sources(workspace: Workspace) -> None:
    idle = run(workspace, "{emergency_stop: idle}")
    first, second = idle.tick(), idle.tick()
    assert dict(first.sources) == {"gaze": "t/emergency_stop/idle"}
    assert (first.sequence, second.sequence) == (0, 1)
    assert second.stamp == pytest.approx(0.1)
    assert idle.executor.status is Status.RUNNING


def test_a_halted_tree_commands_nothing(workspace: Workspace) -> None:
    idle = run(workspace, "{emergency_stop: idle}")
    idle.tick()
    idle.executor.halt("Ctrl-C")
    assert idle.robot.commit().targets == {}
    assert idle.executor.status is Status.INVALID
    assert idle.changes[-1].feedback == "halted: Ctrl-C"


def test_only_changes_are_told_and_with_the_time_of_the_tick(workspace: Workspace) -> None:
    sequence = run(workspace, "{sequence: [{act: {name: a, script: s}}, {act: {name: b, script: rrs}}]}")
    sequence.tick()
    assert sequence.told() == [("a", "SUCCESS"), ("b", "RUNNING"), ("sequence", "RUNNING")]
    sequence.tick()
    assert sequence.changes == []
    sequence.tick()
    assert sequence.told() == [("b", "SUCCESS"), ("sequence", "SUCCESS")]
    assert [change.time for change in sequence.changes] == pytest.approx([0.2, 0.2])


def test_the_preempted_owner_of_a_resource_loses_it_within_the_tick(workspace: Workspace) -> None:
    taken = run(
        workspace,
        "{emergency_stop: {reactive_selector: [{sequence: [{inverter: {act: {script: ssf}}}, {idle: {name: new}}]}, "
        "{idle: {name: old}}]}}",
    )
    assert taken.tick().sources["gaze"].endswith("/old")
    taken.tick()
    assert taken.tick().sources["gaze"].endswith("/new")


ERROR = """
name: broken
root:
  parallel:
    - act: {name: before}
    - sequence:
        - act: {name: bad, script: rx}
    - act: {name: after}
"""


def test_an_exception_halts_the_tree_in_order_and_says_where(workspace: Workspace) -> None:
    broken = Run(load(workspace, ERROR))
    broken.tick()
    broken.log.clear()
    with pytest.raises(NodeError) as caught:
        broken.tick()
    error = caught.value
    assert broken.log == [("INVALID", "bad"), ("INVALID", "before"), ("INVALID", "after")]
    assert error.path == "broken/parallel/sequence/bad"
    assert (error.place.line, error.place.column) == (8, 11)
    assert isinstance(error.error, RuntimeError)
    assert error.where is not None and error.where.file.endswith("test_skills.py")
    source = (workspace.root / "skills" / "test_skills.py").read_text().splitlines()
    assert 'raise RuntimeError("out of order")' in source[error.where.line - 1]
    assert "out of order" in str(error) and "t.yaml:8:11" in str(error)
    assert all(node.status is Status.INVALID for node in broken.tree.root.iterate())
    feedback = {change.path.rpartition("/")[2]: change.feedback for change in broken.changes}
    assert feedback["bad"] == "raised RuntimeError: out of order"
    assert feedback["after"] == "halted: 'bad' raised an exception"


def test_an_exception_in_the_first_tick_still_tells_the_node_to_let_go(workspace: Workspace) -> None:
    broken = run(workspace, "{parallel: [{act: {name: a}}, {act: {name: b, script: x}}]}")
    with pytest.raises(NodeError):
        broken.tick()
    assert broken.log == [("start", "a"), ("start", "b"), ("INVALID", "b"), ("INVALID", "a")]
    assert ("b", "INVALID") in broken.told()


def test_what_is_no_status_is_an_error(workspace: Workspace) -> None:
    broken = run(workspace, "{sequence: [{act: {script: n}}]}")
    with pytest.raises(NodeError, match="must be SUCCESS, FAILURE or RUNNING, not None"):
        broken.tick()


def test_a_node_that_raises_when_halted_does_not_keep_others_from_being_halted(workspace: Workspace) -> None:
    broken = run(workspace, "{parallel: [{act: {name: a}}, bad_end, {act: {name: c}}]}")
    broken.tick()
    broken.log.clear()
    with pytest.raises(NodeError, match="cannot stop"):
        broken.executor.halt("test")
    assert broken.log == [("INVALID", "a"), ("INVALID", "bad_end"), ("INVALID", "c")]
    assert all(node.status is Status.INVALID for node in broken.tree.root.iterate())


def test_of_several_that_raise_when_halted_the_first_is_told(workspace: Workspace) -> None:
    broken = run(workspace, "{parallel: [{bad_end: {name: first}}, {bad_end: {name: second}}]}")
    broken.tick()
    with pytest.raises(NodeError) as caught:
        broken.executor.halt("test")
    assert caught.value.path.endswith("/first")


def test_what_a_node_raises_while_it_is_stopped_for_what_it_raised_is_told_with_that(workspace: Workspace) -> None:
    broken = run(workspace, "{bad_end: {script: x}}")
    with pytest.raises(NodeError, match="out of order") as caught:
        broken.tick()
    assert caught.value.error.__notes__ == ["and then, while it was stopped: RuntimeError: cannot stop"]
    assert vars(broken.tree.root)["halt_reason"] == "raised an exception"


def test_of_a_built_in_node_its_own_place_is_told_and_no_line_of_the_engine(workspace: Workspace) -> None:
    text = "blackboard: {n: 0}\nroot:\n  set_blackboard: {key: n, expression: 1 / n}\n"
    with pytest.raises(NodeError, match=r"raised ZeroDivisionError: in '1 / n': 'n' is 0$") as caught:
        Run(load(workspace, text)).tick()
    assert caught.value.where is None
    assert caught.value.place.line == 4


def test_a_node_that_raises_when_preempted_is_told_once(workspace: Workspace) -> None:
    broken = run(workspace, "{reactive_selector: [{act: {script: fs}}, {parallel: [bad_end, {act: {name: other}}]}]}")
    broken.tick()
    with pytest.raises(NodeError) as caught:
        broken.tick()
    assert caught.value.path.endswith("/bad_end")
    assert broken.log.count(("INVALID", "bad_end")) == 1
    assert broken.log.count(("INVALID", "other")) == 1


def test_two_living_owners_of_a_resource_halt_the_tree(workspace: Workspace) -> None:
    (workspace.root / "skills" / "thief.py").write_text(
        "from humanoid_bt import RobotHandle, Skill, Status\n"
        "class Thief(Skill):\n"
        "    def setup(self, **kwargs):\n"
        "        self.robot = RobotHandle(kwargs['robot'], self.path, ('gaze',))\n"
        "    def update(self):\n"
        "        self.robot.look_at([0, 0, 0])\n"
        "        return Status.RUNNING\n"
    )
    thief = run(workspace, "{emergency_stop: {parallel: [idle, thief]}}")
    with pytest.raises(ResourceConflict, match=r"idle.*thief"):
        thief.tick()
    assert thief.executor.status is Status.INVALID
    assert {("idle", "INVALID"), ("thief", "INVALID")} <= set(thief.told())


@pytest.mark.parametrize("above", ["inverter", "on_error"])
def test_a_hand_that_follows_one_without_a_place_is_an_error_of_its_skill(workspace: Workspace, above: str) -> None:
    (workspace.root / "skills" / "follow.py").write_text(
        "from humanoid_bt import Skill, Status\n"
        "class Follow(Skill):\n"
        "    resources = ('left_hand', 'right_hand')\n"
        "    def update(self):\n"
        "        if self.status is not Status.RUNNING:\n"
        "            self.robot.move_hand('left', (0.3, 0.2, 1))\n"
        "        self.robot.move_hand('right', (0, 0, 0.3), relative=True)\n"
        "        return self.running('following')\n"
    )
    broken = run(workspace, f"{{emergency_stop: {{{above}: {{parallel: [act, follow, idle]}}}}}}")
    broken.tick()
    why = "it moves the right hand relative to the left one, which it does not move to a place in the world"
    if above == "on_error":
        assert not broken.tick().targets
        assert broken.feedback("on_error") == f"'follow' raised HumanoidBtError: {why}"
    else:
        with pytest.raises(
            NodeError, match=rf"t.yaml:2:52: the node 't/emergency_stop/inverter/parallel/follow' raised .*{why}"
        ):
            broken.tick()
    assert ("follow", "INVALID") in broken.told()
    assert ("INVALID", "act") in broken.log


def test_what_setup_does_not_find_is_an_error_at_the_node(workspace: Workspace) -> None:
    (workspace.root / "skills" / "picky.py").write_text(
        "from humanoid_bt.core.errors import UserError\n"
        "from humanoid_bt.decision.skill import Skill, Status\n"
        "class Picky(Skill):\n"
        "    def setup(self, **kwargs):\n"
        "        raise UserError('there is no tail')\n"
        "    def update(self):\n"
        "        return Status.RUNNING\n"
        "class Rude(Picky):\n"
        "    def setup(self, **kwargs):\n"
        "        raise KeyError('tail')\n"
    )
    with pytest.raises(
        UserError, match=r"t.yaml:2:19: error: there is no tail\n.*t.yaml:2:26: error: there is no tail"
    ):
        run(workspace, "{sequence: [picky, picky]}")
    with pytest.raises(NodeError, match="KeyError"):
        run(workspace, "rude")


def test_every_node_is_set_up_once_and_so_is_what_a_leaf_hides(workspace: Workspace) -> None:
    (workspace.root / "skills" / "hides.py").write_text(
        "import py_trees\n"
        "class Inner(py_trees.behaviours.Running):\n"
        "    setups = 0\n"
        "    def setup(self, **kwargs):\n"
        "        self.setups += 1\n"
        "class Hides(py_trees.composites.Sequence):\n"
        "    def __init__(self, name):\n"
        "        super().__init__(name, True, [Inner('hidden')])\n"
    )
    hides = run(workspace, "{sequence: [{inverter: {inner: {name: shown}}}, hides]}")
    inner = [vars(node) for node in hides.tree.root.iterate() if hasattr(node, "setups")]
    assert [(node["name"], node["setups"]) for node in inner] == [("shown", 1), ("hidden", 1)]


def test_a_tree_that_ended_starts_again(workspace: Workspace) -> None:
    again = run(workspace, "{sequence: [plain]}")
    assert again.ticks(3) == "rss"


def test_the_blackboard_of_a_tree_that_ended_starts_again_too(workspace: Workspace) -> None:
    text = "blackboard: {n: 0}\nroot: {sequence: [{set_blackboard: {key: n, expression: n + 1}}, {condition: n < 2}]}\n"
    assert Run(load(workspace, text)).ticks(3) == "sss"


def test_a_child_that_came_back_from_an_earlier_skill_is_none_of_the_next_tick(
    workspace: Workspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    def left(error: BaseException) -> None:
        raise AssertionError("this process was taken for a child") from error

    acts = run(workspace, "{sequence: [{act: {script: r}}]}")
    monkeypatch.setattr(forks, "leave", left)
    monkeypatch.setattr(forks, "astray", True)
    acts.tick()
    assert acts.executor.status is Status.RUNNING
    monkeypatch.setattr(forks, "astray", True)
    acts.tree.root.tick_once()
    assert acts.executor.status is Status.RUNNING


@pytest.mark.parametrize(
    ("under_test", "told"),
    [
        ("{reactive_sequence: [{act: {name: a, script: s}}, act]}", ["INVALID"]),  # it was only asked again
        ("{repeat: {times: 9, act: {name: a, script: s}}}", ["SUCCESS", "INVALID"]),
        ("{sequence: [{act: {name: b, script: rs}}, {act: {name: a, script: s}}, act]}", ["SUCCESS", "INVALID"]),
    ],
)
def test_how_a_skill_ended_that_is_reset_in_the_same_tick_is_told_if_it_was_started(
    workspace: Workspace, under_test: str, told: list[str]
) -> None:
    again = run(workspace, "{parallel: [" + under_test + ", {act: {name: other, script: rf}}]}")
    again.ticks(2)
    assert [status for name, status in again.told() if name == "a"] == told


def test_results_are_told_with_the_end_of_a_node_and_neither_before_nor_after(workspace: Workspace) -> None:
    (workspace.root / "skills" / "counts.py").write_text(
        "from humanoid_bt import Skill, Status, result\n"
        "class Counts(Skill):\n"
        "    n: int = result(doc='How often it was ticked.')\n"
        "    def initialise(self):\n"
        "        self.n = 0\n"
        "    def update(self):\n"
        "        self.n += 1\n"
        "        return self.succeed('') if self.n == 2 else self.running('')\n"
    )
    counts = run(workspace, "{parallel: [{sequence: [counts, act]}, {act: {name: other, script: rrf}}]}")
    told = []
    for _ in range(3):
        counts.tick()
        told += [
            (change.status.name, [found.value for found in change.results])
            for change in counts.changes
            if change.path.endswith("/counts")
        ]
    assert told == [("RUNNING", []), ("SUCCESS", [2]), ("INVALID", [])]


def test_the_same_inputs_give_the_same_changes(workspace: Workspace) -> None:
    def trace() -> list[str]:
        under_test = run(
            workspace,
            "{emergency_stop: {watchdog: {percept: target, max_age: 0.3, on_stale: idle, "
            "reactive_selector: [{reactive_sequence: [{confident: {percept: target, above: 0.6}}, "
            "{approach: {target: target}}]}, idle]}}}",
        )
        lines: list[str] = []
        for step in range(30):
            percepts = seen(under_test.time, 2 - step * 0.1, (step * 7 % 10) / 10) if step % 9 < 5 else {}
            command = under_test.tick(percepts)
            lines += [str(change) for change in under_test.changes] + [str(dict(command.sources))]
        return lines

    assert trace() == trace()


def test_children_of_a_branch_that_raises_are_told_before_it(workspace: Workspace) -> None:
    choice = "{reactive_switch: {value: n, cases: {0: running}}}"
    root = f"{{parallel: {{failure: all, children: [{choice}, {{clear_blackboard: n}}]}}}}"
    under_test = Run(load(workspace, f"blackboard: {{n: 0}}\nroot: {root}\n"))
    under_test.tick()
    with pytest.raises(NodeError, match="'n' is read before anything has written it"):
        under_test.tick()
    names = ["running", "reactive_switch", "clear_blackboard", "parallel"]
    assert under_test.told() == [(name, "INVALID") for name in names]


def test_a_child_that_had_ended_is_told_before_its_halted_parent(workspace: Workspace) -> None:
    slow = "{min_duration: {duration: 1 s, success: }}"
    under_test = run(workspace, f"{{parallel: {{success: one, children: [{slow}, {{act: {{script: rs}}}}]}}}}")
    under_test.ticks(2)
    told = [("act", "SUCCESS"), ("success", "INVALID"), ("min_duration", "INVALID"), ("parallel", "SUCCESS")]
    assert under_test.told() == told
