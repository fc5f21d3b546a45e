"""Sub-trees of files in trees made in Python."""

from __future__ import annotations

from typing import Any

import pytest

from humanoid_bt.core.errors import Problem, UserError
from humanoid_bt.decision.blackboard import Key
from humanoid_bt.decision.skill_files import load_skills
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.nodes import Condition, ForEach, Retry, Sequence, SubTree
from humanoid_bt.tree.source.compose import make_tree
from humanoid_bt.tree.source.load import load_tree
from humanoid_bt.tree.tree import Tree
from tests.tree.helpers import COUNTED, Run, write

ACT = "subtree: true\nparameters:\n  script: {type: text, doc: What it does.}\nroot: {act: {script: $script}}\n"
TRIED = """\
subtree: true
parameters:
  attempts: 2
  action: {type: node, doc: What is tried.}
root: {retry: {attempts: $attempts, $action: }}
"""


@pytest.fixture
def act(workspace: Workspace) -> Any:
    """The class of a skill that does what its script says."""
    write(workspace, "acting", ACT)
    write(workspace, "tried", TRIED)
    write(workspace, "counted", COUNTED)
    return load_skills(workspace)["act"]


def again(tree: Tree, workspace: Workspace) -> Tree:
    """Write a tree and load it."""
    path = workspace.root / "trees" / "again.yaml"
    path.write_text(tree.to_yaml(), encoding="utf-8")
    return load_tree(path, workspace)


def mistakes(root: Any, workspace: Workspace) -> list[Problem]:
    with pytest.raises(UserError) as raised:
        make_tree(root, workspace)
    return list(raised.value.problems)


def test_values_go_in_and_a_file_holds_the_same(workspace: Workspace, act: Any) -> None:
    made = make_tree(SubTree("go", tree="acting", script="rrs"), workspace)
    assert [node.path for node in made.nodes] == ["tree/go", "tree/go/act"]
    assert [file.name for file in made.files] == ["acting.yaml"]
    assert Run(made).ticks(3) == "rrs"
    assert Run(again(made, workspace)).ticks(3) == "rrs"


def test_text_that_looks_like_a_reference_is_text(workspace: Workspace, act: Any) -> None:
    made = make_tree(SubTree("go", tree="acting", script="$x"), workspace)
    assert made.nodes[1].values["script"] == "$x"
    assert again(made, workspace).nodes[1].values["script"] == "$x"


def test_outputs_come_out_and_keys_go_in(workspace: Workspace, act: Any) -> None:
    def root() -> ForEach:
        counted = SubTree("count", tree="counted", total=Key("n"))
        acting = SubTree("go", tree="acting", script=Key("what"))
        return ForEach("each", Sequence("all", [counted, Condition("one", expression="n == 1"), acting]), **EACH)

    made = make_tree(root(), workspace)
    assert Run(made).ticks(2) == Run(again(made, workspace)).ticks(2) == "rs"


EACH = {"item": "what", "items": ["s", "s"]}


def test_nodes_are_given_with_sub_trees_of_their_own(workspace: Workspace, act: Any) -> None:
    inner = SubTree("inner", tree="tried", attempts=2, action=act("mine", script="ff"))
    made = make_tree(SubTree("outer", tree="tried", action=inner), workspace)
    assert [node.path.removeprefix("tree/outer/retry") for node in made.nodes[1:]] == [
        "",
        "/inner",
        "/inner/retry",
        "/inner/retry/mine",
    ]
    assert Run(made).ticks(5) == Run(again(made, workspace)).ticks(5)
    assert again(made, workspace).to_yaml() == made.to_yaml()
    assert "action:" in made.to_yaml() and "name: mine" in made.to_yaml()


@pytest.mark.parametrize(
    ("arguments", "message", "code"),
    [
        ({"tree": "actin", "script": "s"}, "no tree named 'actin', in 'go'", "unknown-tree"),
        ({"tree": "acting"}, "the parameter 'script' of 'subtree' is missing, in 'go'", "missing-parameter"),
        ({"tree": "acting", "script": "s", "scrip": 1}, "unknown parameter 'scrip'", "unknown-parameter"),
        ({"tree": "acting", "script": 3}, "'script' must be text, not a number 3, in 'go'", "wrong-type"),
        ({"tree": "acting", "script": object}, "'script' cannot be <class 'object'>, in 'go'", "wrong-type"),
        ({"tree": "acting", "script": Key("nothing")}, "unknown parameter or key '$nothing'", "unknown-reference"),
        ({"tree": "tried"}, "the node 'action' of 'subtree' is missing, in 'go'", "missing-parameter"),
        (
            {"tree": "tried", "action": "act", "attempts": Key("n")},
            "'attempts' of 'retry' must be known before",
            "not-dynamic",
        ),
        ({"tree": 3}, "'tree' must be text, not a number 3, in 'go'", "wrong-type"),
    ],
)
def test_mistakes_are_those_of_a_file(
    workspace: Workspace, act: Any, arguments: dict[str, Any], message: str, code: str
) -> None:
    problem = mistakes(SubTree("go", **arguments), workspace)[0]
    assert message in problem.message
    assert problem.code == code
    assert problem.place is not None
    assert problem.place.file.endswith("test_compose_subtrees.py")


def test_one_node_or_sub_tree_stands_in_one_place(workspace: Workspace, act: Any) -> None:
    twice = SubTree("go", tree="acting", script="s")
    root = Sequence("s", [Retry("a", twice, attempts=1), Retry("b", twice, attempts=1)])
    assert "stands in the tree twice" in mistakes(root, workspace)[0].message
    node = act("mine")
    both = [SubTree("a", tree="tried", action=node), SubTree("b", tree="tried", action=node)]
    assert "the node 'mine' stands in the tree twice" in mistakes(Sequence("s", both), workspace)[0].message


def test_a_sub_tree_may_use_a_node_that_it_is_given_several_times(workspace: Workspace, act: Any) -> None:
    write(workspace, "twice", "subtree: true\nparameters: {it: {type: node}}\nroot: {sequence: [$it, $it]}\n")
    given = Sequence(
        "both", [act("mine", script="rs"), Condition("known", expression="state.time > 0 s hysteresis 1 s")]
    )
    made = make_tree(SubTree("go", tree="twice", it=given), workspace)
    assert len({id(node.behaviour) for node in made.nodes}) == len(made.nodes) == 8
    first, second = (vars(node.behaviour)["expression"] for node in made.nodes if node.name == "known")
    assert first is not second
    assert Run(made).ticks(4) == Run(again(made, workspace)).ticks(4) == "rrss"


def test_its_file_must_be_given() -> None:
    with pytest.raises(TypeError, match="tree"):
        SubTree("go")  # type: ignore[call-arg]  # the mistake that is tried
