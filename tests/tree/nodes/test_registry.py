from __future__ import annotations

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.params import PerceptName
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.nodes.registry import Registry


def test_every_type_says_what_it_is(workspace: Workspace) -> None:
    registry = Registry.of(workspace)
    for name in ("sequence", "selector", "parallel", "inverter", "retry", "repeat", "timeout"):
        assert registry[name].doc
    for node_type in registry.values():
        assert node_type.doc.endswith("."), node_type
        if node_type.kind != "skill":
            assert all(spec.doc for spec in node_type.params.values())
    approach = registry["approach"]
    assert (approach.kind, approach.resources) == ("skill", ("base", "gaze"))
    assert approach.params["target"].type is PerceptName
    assert registry["watchdog"].branches


def test_a_plain_behaviours_parameters_are_its_constructors(workspace: Workspace) -> None:
    count = Registry.of(workspace)["plain"].params["count"]
    assert (count.type, count.default) == (int, 2)


def test_an_unknown_type_is_answered_with_the_nearest(workspace: Workspace) -> None:
    with pytest.raises(UserError, match="unknown node 'aproach'") as caught:
        Registry.of(workspace).find("aproach")
    assert "did you mean 'approach'?" in str(caught.value)


@pytest.mark.parametrize("name", ["Sequence", "Watchdog", "Children", "OnStale", "MaxAge"])
def test_a_skill_cannot_take_a_name_that_trees_use_otherwise(workspace: Workspace, name: str) -> None:
    path = workspace.root / "skills" / "clash.py"
    path.write_text(
        "from humanoid_bt.decision.skill import Skill, Status\n\n"
        f"class {name}(Skill):\n    def update(self): return Status.SUCCESS\n"
    )
    with pytest.raises(UserError, match=r"clash.py:3:1: error: the skill .* has the name of"):
        Registry.of(workspace)
