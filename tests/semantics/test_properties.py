"""What holds for every tree, whatever its nodes mean."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable
from typing import Any

import py_trees
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.strategies import DrawFn
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.core.errors import UserError
from humanoid_bt.decision.skill import Skill
from humanoid_bt.files.workspace import Workspace
from tests.semantics.lives import Life, random_lives, shown
from tests.semantics.model import COMMANDS, INVALID, RUNNING, Model, Node
from tests.semantics.random_trees import SKILLS, Story, changed, moments, snapshots, stories, text_of, trees
from tests.tree.helpers import load, make_workspace


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    return make_workspace(tmp_path_factory.mktemp("trees") / "project", SKILLS)


@st.composite
def broken_stories(draw: DrawFn) -> Story:
    """Return a story in which one skill raises, sooner or later."""
    tree = draw(trees(caught=False))
    skills = [node for node in tree.all() if node.kind in COMMANDS]
    assume(skills)
    leaf = draw(st.sampled_from(skills))
    where = draw(st.sampled_from(["update", "start", "end", "halt"]))
    script = leaf.values["script"]
    values = {"script": script[: draw(st.integers(0, 2))] + "x"} if where == "update" else {"raises": where}
    return Story(changed(tree, leaf.name, **values), draw(moments()), leaf.name)


@random_lives
@given(story=stories(raising=True))
def test_each_node_is_started_ticked_and_ended_in_turn_and_owners_run(workspace: Workspace, story: Story) -> None:
    life = WatchedLife(story.tree, workspace)
    told = dict.fromkeys(life.nodes, INVALID)
    for moment, now in zip(story.moments, snapshots(story.moments), strict=True):
        if moment.halt:
            life.stop(now.time)
            assert set(life.statuses.values()) == {INVALID}
            check(life, told)
        life.step(now)
        check(life, told)


@random_lives
@given(story=broken_stories())
def test_an_exception_anywhere_ends_everything(workspace: Workspace, story: Story) -> None:
    life = WatchedLife(story.tree, workspace)
    told = dict.fromkeys(life.nodes, INVALID)
    for moment, now in zip(story.moments, snapshots(story.moments), strict=True):
        if moment.halt:
            life.stop(now.time)
            check(life, told)
            assert life.raised in (None, story.culprit)
        life.step(now)
        check(life, told)
        if life.raised is not None:
            assert life.raised == story.culprit
            assert set(life.statuses.values()) == {INVALID}
            assert life.robot.commit().targets == {}


@pytest.mark.trials
@random_lives
@given(story=stories())
def test_py_trees_own_functions_work_on_the_trees(workspace: Workspace, story: Story) -> None:
    life, model = Life(story.tree, workspace), Model(story.tree)
    root = life.tree.root
    managed = py_trees.trees.BehaviourTree(root)
    for moment, now in zip(story.moments, snapshots(story.moments), strict=True):
        life.clock.cycle = now.time
        if moment.halt:
            model.stop(now.time)
            root.stop(Status.INVALID)
        if root.status is not Status.RUNNING:  # the executor's part
            for key in life.tree.keys:
                key.reset()
        life.robot.begin_tick(*shown(now))
        if model.step(now):  # a node raises, such as one that reads a key before anything has written it
            with pytest.raises(Exception, match=r".+"):
                managed.tick()
            return
        managed.tick()
        assert life.log == model.events
        assert life.statuses == drawn_statuses(root) == model.status
        assert len(list(root.iterate())) == len(life.tree.nodes)
        tip = root.tip()
        assert tip is not None
        assert tip.status is not Status.INVALID


@random_lives
@given(tree=trees(overlaps=True))
def test_children_of_a_parallel_never_share_a_resource(workspace: Workspace, tree: Node) -> None:
    shared = any(overlap(node) for node in tree.all())
    codes: set[str] = set()
    try:
        load(workspace, text_of(tree))
    except UserError as error:
        codes = {problem.code for problem in error.problems if problem.severity == "error"}
    assert codes == ({"resource-overlap"} if shared else set())


class WatchedLife(Life):
    """A life in which each call of a node's own functions is checked as it comes.

    Attributes:
        alive: names of nodes that were started and have not ended.
        ticked: names of the nodes ticked since the last check.
        skills: names of the skills that were started since the last check.
    """

    def __init__(self, tree: Node, workspace: Workspace) -> None:
        super().__init__(tree, workspace)
        self.alive: set[str] = set()
        self.ticked: set[str] = set()
        self.skills: set[str] = set()
        self.below = {node.name: {other.name for other in node.all()} - {node.name} for node in tree.all()}
        for node in self.tree.nodes:
            self._watch(node.behaviour, "advance" if node.kind in ("composite", "decorator") else "update")

    def _watch(self, node: Behaviour, does: str) -> None:
        name, initialise, act, terminate = node.name, node.initialise, getattr(node, does), node.terminate
        ended_with: list[Status] = []

        def start() -> None:
            assert name not in self.alive, f"{name} was started twice"
            self.alive.add(name)
            self.ticked.add(name)
            if isinstance(node, Skill):
                self.skills.add(name)
            initialise()

        def tick(*seen: Any) -> Status:
            assert name in self.alive, f"{name} was ticked without a start"
            self.ticked.add(name)
            ended_with.clear()
            try:
                status: Status = act(*seen)
            except Exception:
                if not isinstance(node, Skill) and node.status is not Status.RUNNING:
                    self.alive.discard(name)  # it has nothing to end: only skills may hold something by now
                raise
            if status is not Status.RUNNING:
                self.alive.discard(name)
                ended_with.append(status)
            return status

        def end(new_status: Status) -> None:
            if new_status is Status.INVALID:
                assert name in self.alive, f"{name} was halted and did not run"
                assert not self.alive & self.below[name], f"{name} was halted before what runs below it"
                self.alive.discard(name)
            else:
                assert ended_with == [new_status], f"{name} was told {new_status} and ended with {ended_with}"
            terminate(new_status)

        replaced: dict[str, Callable[..., Any]] = {"initialise": start, does: tick, "terminate": end}
        vars(node).update(replaced)


def check(life: WatchedLife, told: dict[str, str]) -> None:
    """Check what holds after each tick and halt; ``told`` is what changes have told so far."""
    statuses = life.statuses
    running = {name for name, status in statuses.items() if status == RUNNING}
    assert life.alive == running
    assert running <= life.ticked, "a node runs that was not ticked"
    ticked = set(life.ticked)
    life.ticked.clear()
    for node in life.tree.root.iterate():
        below = {statuses[child.name] for child in node.children}
        assert statuses[node.name] == RUNNING or RUNNING not in below
        assert statuses[node.name] != INVALID or below <= {INVALID}
    assert {owner for _, owner in life.owners} <= running
    changes = [(change.path.rpartition("/")[2], change.status.name) for change in life.changes]
    for (earlier, _), (later, _) in itertools.combinations(changes, 2):
        assert later not in life.below[earlier], "a parent's change was told before its child's"
    for name, status in changes:
        once_more = name in ticked if status == INVALID else status != RUNNING and name in life.skills
        assert told[name] != status or once_more
        told[name] = status
    assert told == statuses
    life.skills.clear()


def drawn_statuses(root: Behaviour) -> dict[str, str]:
    """Return the statuses in py_trees' own drawing."""
    signs = {"o": "SUCCESS", "x": "FAILURE", "*": "RUNNING", "-": "INVALID"}
    lines = py_trees.display.ascii_tree(root, show_status=True).splitlines()
    found = [re.search(r"(\w+) \[(.)\]", line) for line in lines]
    return {match[1]: signs[match[2]] for match in found if match}


def overlap(node: Node) -> bool:
    """Return whether two children of a parallel command one resource."""
    used = [{resource for leaf in child.all() for resource in COMMANDS.get(leaf.kind, ())} for child in node.children]
    return node.kind == "parallel" and any(one & two for one, two in itertools.combinations(used, 2))
