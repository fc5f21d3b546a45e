"""In random trees no node answers what the checks take for impossible."""

from __future__ import annotations

from typing import Any
from unittest import mock

import pytest
from hypothesis import given
from hypothesis import strategies as st
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree import checks
from humanoid_bt.tree.checks.facts import Facts
from humanoid_bt.tree.draft import Draft
from humanoid_bt.tree.results import Results
from tests.semantics.lives import Life, random_lives
from tests.semantics.model import COMMANDS, Node
from tests.semantics.random_trees import SKILLS, Story, moments, snapshots, trees
from tests.tree.helpers import make_workspace


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    return make_workspace(tmp_path_factory.mktemp("trees") / "project", SKILLS)


@random_lives
@given(story=st.builds(Story, trees(caught=False), moments()))
def test_nodes_answer_only_what_the_checks_expect(workspace: Workspace, story: Story) -> None:
    life = AnsweringLife(story.tree, workspace)
    for moment, now in zip(story.moments, snapshots(story.moments), strict=True):
        if moment.halt:
            life.stop(now.time)
        life.step(now)
        assert life.raised is None


class AnsweringLife(Life):
    """A life in which each answer of a node is compared with what the checks know of the node.

    Attributes:
        results: what each node can answer.
        at_once: what it can answer without starting anything that runs.
        runs: how often a skill was ticked, or another node was RUNNING.
    """

    def __init__(self, tree: Node, workspace: Workspace) -> None:
        self.results: dict[str, Results] = {}
        self.at_once: dict[str, Results] = {}
        self.runs = 0
        with mock.patch.object(checks, "Facts", self._facts):
            super().__init__(tree, workspace)
        for node in self.tree.nodes:
            self._watch(
                node.behaviour, "advance" if node.kind in ("composite", "decorator") else "update", node.type_name
            )

    def _facts(self, root: Draft) -> Facts:
        facts = Facts(root)
        for draft in root.iterate():
            self.results[draft.name], self.at_once[draft.name] = facts.results(draft), facts.at_once(draft)
        return facts

    def _watch(self, node: Behaviour, does: str, kind: str) -> None:
        name, act = node.name, getattr(node, does)

        def answer(*seen: Any) -> Status:
            starts, before = node.status is not Status.RUNNING, self.runs
            status: Status = act(*seen)
            self.runs += status is Status.RUNNING or kind in COMMANDS
            assert status in self.results[name], f"{name} cannot answer {status}"
            if starts and self.runs == before:
                assert status in self.at_once[name], f"{name} cannot answer {status} at once"
            return status

        vars(node)[does] = answer
