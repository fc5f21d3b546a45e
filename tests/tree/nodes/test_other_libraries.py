from __future__ import annotations

import re

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.nodes.other_libraries import FOREIGN
from humanoid_bt.tree.nodes.registry import ALIASES, Registry
from tests.tree.helpers import run


def hint_for(registry: Registry, name: str) -> str:
    with pytest.raises(UserError, match=f"unknown node '{name}'") as caught:
        registry.find(name)
    return caught.value.problems[0].hint


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        (
            "ReactiveSequence",
            "ReactiveSequence (BehaviorTree.CPP) is here: reactive_sequence",
        ),
        ("Sequence", "is here: sequence; py_trees' with memory=False is reactive_sequence"),
        ("IfThenElse", "is here: if"),
        ("WhileDoElse", "is here: reactive_if"),
        ("AlwaysFailure", "failure"),
        ("OneShot", "once"),
        ("oneshot", "once"),
        ("Sleep", "is here: wait"),
        ("Switch3", "is here: reactive_switch"),
        ("ForceSuccess", "here it is written 'force_success'"),
        ("ForEach", "for_each"),
        ("Inverter", "here it is written 'inverter'"),
        ("Approach", "here it is written 'approach'"),  # a skill
    ],
)
def test_a_name_from_elsewhere_is_answered_with_ours(workspace: Workspace, name: str, hint: str) -> None:
    assert hint in hint_for(Registry.of(workspace), name)


def test_every_name_from_elsewhere_gets_a_hint_unless_it_is_valid_here(workspace: Workspace) -> None:
    registry = Registry.of(workspace)
    for foreign in FOREIGN:
        for name in foreign.names:
            assert foreign.here.split(";")[0].replace("`", "") in hint_for(registry, name)


def test_what_it_is_called_here_exists(workspace: Workspace) -> None:
    registry = Registry.of(workspace)
    keys = {key for kind in registry.values() for key in (*kind.params, *kind.branches)} | {"completion"}
    for foreign in FOREIGN:
        first, *others = [re.split(r"[:\s]", code)[0] for code in re.findall(r"`([^`]+)`", foreign.here)] or ["success"]
        assert first in registry
        assert {*others} <= {*registry, *keys, *ALIASES, "--set"}


def test_a_child_from_elsewhere_gets_the_hint_too(workspace: Workspace) -> None:
    with pytest.raises(UserError, match=r"AlwaysSuccess \(BehaviorTree.CPP\) is here: success"):
        run(workspace, "{inverter: {AlwaysSuccess: }}")
    with pytest.raises(UserError, match=r"AlwaysSuccess \(BehaviorTree.CPP\) is here: success"):
        run(workspace, "{inverter: AlwaysSuccess}")
