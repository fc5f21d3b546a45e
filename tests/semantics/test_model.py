"""The engine does what the reference model says, in every tick of random trees."""

from __future__ import annotations

import pytest
from hypothesis import given

from humanoid_bt.files.workspace import Workspace
from tests.semantics.lives import Life, random_lives
from tests.semantics.model import Model
from tests.semantics.random_trees import SKILLS, Story, long_stories, snapshots, stories
from tests.tree.helpers import make_workspace


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    return make_workspace(tmp_path_factory.mktemp("trees") / "project", SKILLS)


@random_lives
@given(story=stories())
def test_the_engine_does_what_the_model_says(workspace: Workspace, story: Story) -> None:
    compare(workspace, story)


@pytest.mark.trials
@random_lives
@given(story=stories(raising=True))
def test_the_engine_and_the_model_agree_on_exceptions(workspace: Workspace, story: Story) -> None:
    compare(workspace, story)


@random_lives
@given(story=long_stories())
def test_the_engine_and_the_model_remember_the_same(workspace: Workspace, story: Story) -> None:
    compare(workspace, story)


def compare(workspace: Workspace, story: Story) -> None:
    """Let the engine and the model live through a story side by side."""
    life, model = Life(story.tree, workspace), Model(story.tree)
    for moment, now in zip(story.moments, snapshots(story.moments), strict=True):
        if moment.halt:
            life.stop(now.time)
            raised = model.stop(now.time)
            agree(life, model, raised)
        life.step(now)
        raised = model.step(now)
        agree(life, model, raised)
        assert life.owners == (set() if raised else model.owners)


def agree(life: Life, model: Model, raised: str | None) -> None:
    """Check all that can be seen from outside."""
    assert life.log == model.events
    assert life.raised == raised
    assert life.statuses == model.status
    assert life.executor.status.name == model.status[model.tree.name]
    assert sorted(life.caught) == sorted(model.caught)
    assert life.logged == model.told
    kinds = {node.name: node.kind for node in model.tree.all()}
    asking = [name for name, status in model.status.items() if status == "RUNNING" and kinds[name].startswith("ros_")]
    assert life.asking == len(asking)
    board = {key.name: key.value for key in life.tree.keys if key.is_set}
    assert board == (model.board or board)  # the model has none before the first tick
