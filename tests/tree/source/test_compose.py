"""Trees made in Python, and trees written as files."""

from __future__ import annotations

import random
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from humanoid_bt.core.errors import Problem, UserError
from humanoid_bt.decision.blackboard import Key, are_keys
from humanoid_bt.decision.skill_files import load_skills
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.tree.expressions.expression import Expression
from humanoid_bt.tree.nodes import (
    Condition,
    EmergencyStop,
    ForEach,
    If,
    Log,
    Parallel,
    Repeat,
    Retry,
    Selector,
    Sequence,
    SetBlackboard,
    Switch,
    Timeout,
    Wait,
    Watchdog,
    Within,
)
from humanoid_bt.tree.nodes.registry import Registry
from humanoid_bt.tree.source.compose import make_tree
from humanoid_bt.tree.source.load import load_tree
from humanoid_bt.tree.tree import Tree
from tests.tree.helpers import Run, load, seen, write
from tests.tree.ticking.test_random_trees import KEY, random_tree


def plain(value: Any) -> Any:
    if are_keys(value):
        return [key.name for key in value]
    return value.name if isinstance(value, Key) else value.syntax if isinstance(value, Expression) else value


def shape(tree: Tree) -> list[Any]:
    """Return what makes two trees the same."""
    nodes = []
    for node in tree.nodes:
        defaults = {name: spec.default for name, spec in node.type.params.items() if not spec.required}
        values = {name: plain(value) for name, value in {**defaults, **node.values}.items()}
        nodes.append((node.path, node.type_name, values, node.parent, node.branch))
    return [tree.name, tree.description, tree.robot, tree.scene, nodes]


@pytest.fixture
def again(workspace: Workspace) -> Callable[[Tree], Tree]:
    """Return what writes a tree and loads it again."""

    def write_and_load(tree: Tree) -> Tree:
        path = workspace.root / "trees" / "again.yaml"
        path.write_text(tree.to_yaml())
        return load_tree(path, workspace)

    return write_and_load


@pytest.fixture
def skills(workspace: Workspace) -> dict[str, Any]:
    return dict(load_skills(workspace))


def mistakes(root: Any, workspace: Workspace) -> list[Problem]:
    with pytest.raises(UserError) as raised:
        make_tree(root, workspace)
    return list(raised.value.problems)


def test_a_tree_made_in_python_is_the_one_of_the_file(workspace: Workspace, skills: dict[str, Any]) -> None:
    made = make_tree(
        EmergencyStop(
            "emergency_stop",
            Watchdog(
                "watchdog",
                Selector(
                    "selector",
                    [
                        Sequence(
                            "get it", [Within("within", percept="ball", distance=0.5), skills["reach"](target="ball")]
                        ),
                        If(
                            "if",
                            condition=Condition("condition", expression="distance(ball) < 1 m"),
                            then=Wait("wait", duration=0.5),
                            else_=skills["idle"](name="rest"),
                        ),
                    ],
                ),
                on_stale=skills["idle"](),
                percept="ball",
                max_age=0.5,
            ),
        ),
        workspace,
        name="play",
        description="Play.",
    )
    loaded = load(
        workspace,
        textwrap.dedent(
            """\
            name: play
            description: Play.
            root:
              emergency_stop:
                watchdog:
                  percept: ball
                  max_age: 0.5 s
                  on_stale: idle
                  selector:
                    - sequence:
                        name: get it
                        children: [{within: {percept: ball, distance: 0.5}}, {reach: {target: ball}}]
                    - if: {condition: distance(ball) < 1 m, then: {wait: 0.5}, else: {idle: {name: rest}}}
            """
        ),
    )
    assert shape(made) == shape(loaded)
    run = Run(made)
    command = run.tick({"ball": seen(0.0, distance=0.3)["target"]})
    assert run.told()[:2] == [("within", "SUCCESS"), ("reach", "RUNNING")]
    assert command.sources == {"left_hand": "play/emergency_stop/watchdog/selector/get it/reach"}


def test_it_runs_and_shares_keys_by_name(workspace: Workspace, skills: dict[str, Any]) -> None:
    made = make_tree(
        ForEach(
            "each",
            Sequence(
                "all",
                [
                    skills["act"](script=Key("what")),
                    SetBlackboard("note", key="last", expression="what"),
                    Condition("same", expression="last == what and is_set(what)"),
                ],
            ),
            item="what",
            items=["s", "rs"],
        ),
        workspace,
    )
    run = Run(made)
    assert run.ticks(2) == "rs"
    assert "script: $what" in made.to_yaml()


@pytest.mark.parametrize("name", Workspace(builtin_root()).trees())
def test_built_in_trees_are_written_and_load_the_same(name: str, tmp_path: Path) -> None:
    workspace = Workspace(builtin_root())
    tree = load_tree(workspace.find_tree(name), workspace)
    if not tree.complete:
        return
    path = tmp_path / f"{name}.yaml"
    path.write_text(tree.to_yaml())
    assert shape(load_tree(path, workspace)) == shape(tree)


@pytest.mark.parametrize("seed", range(40))
def test_random_trees_are_written_and_load_the_same(
    workspace: Workspace, again: Callable[[Tree], Tree], seed: int
) -> None:
    tree = load(workspace, f"blackboard: {{{KEY}: running}}\nroot: {random_tree(random.Random(seed), 4)}\n")
    written = again(tree)
    assert shape(written) == shape(tree)
    assert written.to_yaml() == tree.to_yaml()


def test_parameters_keys_and_sub_trees_stay_what_they_are(workspace: Workspace, again: Callable[[Tree], Tree]) -> None:
    (workspace.root / "trees" / "tried.yaml").write_text(
        "format: 1\nsubtree: true\nparameters: {attempts: 2, action: {type: node}}\noutputs: {n: {type: number}}\n"
        "root: {sequence: [{set_blackboard: {key: n, value: 1}}, {retry: {attempts: $attempts, $action: }}]}"
    )
    text = """\
    parameters:
      near: {type: number, unit: m, default: 50 cm, doc: How near.}
      tries: 2
    blackboard: {count: 0}
    root:
      sequence:
        - subtree: {tree: tried, attempts: $tries, n: total, action: {act: {script: fs}}}
        - guard: {condition: total == 1 and near > count * 1 m, child: {condition: count == 0}}
    """.replace("guard:", "if:").replace("child:", "then:")
    tree = load(workspace, textwrap.dedent(text), near="0.7", tries="3")
    written = again(tree)
    assert written.parameters == tree.parameters == {"near": 0.7, "tries": 3}
    assert shape(written) == shape(tree)
    assert "attempts: $tries" in tree.to_yaml()
    assert "doc: How near." in tree.to_yaml()


@pytest.mark.parametrize(
    ("text", "given"),
    [
        ("parameters: {a: s, b: f}\nroot: {for_each: {item: x, items: [$a, $b, $$c], log: '{x}'}}", {"a": "rs"}),
        ("parameters: {title: so}\nroot: {log: {name: $title, text: hi}}", {"title": "other"}),
        ("root: {log: {name: $$title, text: hi}}", {}),
        ("parameters: {it: {type: node, default: {wait: 1 s}}}\nroot: {sequence: [$it, act]}", {}),
        ("parameters: {it: {type: node, default: success}}\nroot: {guard: {condition: $it, act: }}", {}),
        ("root: {if: {condition: {failure: }, then: success, else: act}}", {}),
        ("blackboard: {x: a}\nroot: {switch: {value: x, cases: {'': act, a: {act: {script: s}}}}}", {}),
        (
            "parameters: {w: s, l: [a]}\nroot: {for_each: {item: x, items: $l, act: {script: $w}}}",
            {"w": "$x", "l": ["$y"]},
        ),
        ("parameters: {w: s}\nroot: {act: {script: $w}}", {"w": "5 cm"}),
        ("parameters: {w: s}\nroot: {act: {script: $w}}", {"w": "1e-3"}),
        (
            "parameters: {w: $$s}\nblackboard: {k: $$k}\nroot: {sequence: [{act: {script: $w}}, {log: '$$5 for {k}'}]}",
            {},
        ),
    ],
)
def test_what_is_written_loads_to_the_same_tree(
    workspace: Workspace, again: Callable[[Tree], Tree], text: str, given: dict[str, Any]
) -> None:
    tree = load(workspace, text, **given)
    written = again(tree)
    assert shape(written) == shape(tree)
    assert written.parameters == tree.parameters
    assert [key.initial for key in written.keys if key.has_initial] == [k.initial for k in tree.keys if k.has_initial]
    assert written.to_yaml() == tree.to_yaml()


def test_a_default_node_that_is_given_to_a_sub_tree_is_written(
    workspace: Workspace, again: Callable[[Tree], Tree]
) -> None:
    write(
        workspace,
        "both",
        "subtree: true\nparameters: {action: {type: node}, other: {type: node}}\nroot: {sequence: [$action, $other]}",
    )
    text = """\
    parameters:
      a: {type: node, default: {inverter: $b}}
      b: {type: node, default: act}
      action: {type: node, default: act}
    root:
      sequence:
        - subtree: {tree: both, action: {retry: {attempts: 2, $a: }}, other: $b}
        - $action
    """
    tree = load(workspace, textwrap.dedent(text))
    written = again(tree)
    assert shape(written) == shape(tree)
    assert written.to_yaml() == tree.to_yaml()


def test_text_that_begins_with_a_dollar_is_written_with_two(workspace: Workspace) -> None:
    run = Run(load(workspace, "blackboard: {k: $$k}\nroot: {log: '$$5 for {k}'}"))
    run.tick()
    assert [text for *_, text in run.events] == ["$5 for $k"]


def test_values_may_be_written_as_in_a_file(workspace: Workspace, again: Callable[[Tree], Tree]) -> None:
    made = make_tree(
        Sequence(
            "s",
            [
                Wait("w", duration="100 ms"),
                Timeout("t", Wait("v", duration=1), duration="2 min"),
                Log("l", text=5),
                Condition("c", expression=True),
            ],
        ),
        workspace,
    )
    values = [node.values for node in made.nodes]
    assert (values[1]["duration"], values[2]["duration"], values[3]["duration"]) == (0.1, 120.0, 1.0)
    assert shape(again(made)) == shape(made)
    run = Run(make_tree(Sequence("s", [Wait("w", duration="100 ms"), Log("l", text=5)]), workspace))
    assert (run.ticks(2), run.events) == ("rs", [("tree/s/l", "info", "5")])


def test_a_key_begins_with_its_initial_value(workspace: Workspace, again: Callable[[Tree], Tree]) -> None:
    made = make_tree(
        ForEach(
            "each",
            Sequence("s", [Log("l", text="{n}"), SetBlackboard("b", key=Key("n", 5), expression="n + 1")]),
            item="i",
            items=[1],
        ),
        workspace,
    )
    for tree in (made, again(made)):
        run = Run(tree)
        assert run.ticks(2) == "ss"
        assert [text for _, _, text in run.events] == ["5", "5"]


def test_an_initial_value_may_begin_with_a_dollar(workspace: Workspace, again: Callable[[Tree], Tree]) -> None:
    made = make_tree(
        Sequence("s", [SetBlackboard("b", key=Key("k", "$x"), value="y"), Log("l", text="{k}")]), workspace
    )
    assert [key.initial for key in again(made).keys] == [key.initial for key in made.keys] == ["$x"]


def test_a_case_may_be_what_the_value_is(workspace: Workspace, again: Callable[[Tree], Tree]) -> None:
    cases: list[tuple[str, Any]] = [("1 < 2", True), ("1 + 1", 2), ("0.5", 0.5), ("'a'", "a")]
    made = make_tree(
        Sequence("s", [Switch(value, {case: Wait("w", duration=0)}, value=value) for value, case in cases]), workspace
    )
    assert Run(made).ticks(1) == Run(again(made)).ticks(1) == "s"


def test_a_child_that_is_called_like_a_parameter_is_written_as_child(workspace: Workspace) -> None:
    tree = load(workspace, "root: {inverter: {name: x, child: {condition: true}}}")
    assert tree.nodes[1].type_name == "condition"


def test_texts_that_yaml_would_take_for_something_else_are_quoted(
    workspace: Workspace, skills: dict[str, Any], again: Callable[[Tree], Tree]
) -> None:
    scripts = ["true", "1e-3", "null", "0x1", "a: b", "$x y", "- s", "é\n", "", "2026-01-01", "yes", "#s"]
    tree = make_tree(
        Sequence("all", [skills["act"](f"act {i}", script=text) for i, text in enumerate(scripts)]), workspace
    )
    assert [node.values["script"] for node in again(tree).nodes[1:]] == scripts


@pytest.mark.parametrize(
    ("root", "message", "code"),
    [
        (lambda s: s["idle"](), "'idle' commands gaze, posture outside an emergency_stop", "outside-emergency-stop"),
        (lambda s: Retry("r", s["act"](), attempts=2.5), "'attempts' must be a whole number", ""),
        (lambda s: Wait("w", duration=-1.0), "'duration' must be >= 0", ""),
        (lambda s: Condition("c", expression="count > 1"), "unknown name 'count'", "expression"),
        (lambda s: Parallel("p", [s["act"](), s["act"]()], success="2"), "'success' must be all | one or whole", ""),
        (
            lambda s: Sequence("s", [SetBlackboard("a", key=Key("n", value), value=1) for value in (2, 3)]),
            "the key 'n' has two initial values",
            "taken-name",
        ),
        (
            lambda s: ForEach("f", s["act"](script=Key("n")), item="n", items="ab"),
            "'items' must be a list, not text",
            "",
        ),
        (
            lambda s: ForEach("f", s["act"](script=Key("n")), item="n", items=[1, 2]),
            "'script' must be text, and the key 'n' is a plain number",
            "wrong-type",
        ),
        (
            lambda s: Sequence("s", [SetBlackboard("b", key=Key("n", 2), value="x"), Log("l", text="{n}")]),
            "'n' must be a number, not text 'x'",
            "wrong-type",
        ),
        (lambda s: s["act"](script=Key("what", {1})), "'what' cannot be {1}", "wrong-type"),
        (lambda s: s["act"](script=Key("what")), "unknown parameter or key '$what'", "unknown-reference"),
        (lambda s: Sequence("a/b", [s["act"]()]), "'a/b' cannot be a name", "bad-name"),
    ],
)
def test_mistakes_are_those_of_a_file(
    workspace: Workspace, skills: dict[str, Any], root: Callable[[Any], Any], message: str, code: str
) -> None:
    (problem,) = mistakes(root(skills), workspace)
    assert message in problem.message
    assert problem.code == code or not code
    assert problem.place is not None
    assert problem.place.file.endswith("test_compose.py")


def test_an_expression_that_is_none_is_told_where_it_is_made() -> None:
    with pytest.raises(UserError, match="'1 \\+' is no expression"):
        Condition("c", expression="1 +")


def test_nodes_that_are_not_ours_are_refused(workspace: Workspace, skills: dict[str, Any]) -> None:
    import py_trees

    theirs = py_trees.composites.Sequence("theirs", memory=True, children=[skills["act"]()])
    assert "is none of our nodes" in mistakes(theirs, workspace)[0].message
    other = load_skills(Workspace(builtin_root()))["idle"]
    assert "is not the workspace's 'idle'" in mistakes(EmergencyStop("e", other()), workspace)[0].message
    assert "no skill 'dummy'" in mistakes(py_trees.behaviours.Dummy("x"), workspace)[0].message
    act = skills["act"]()
    assert (
        "stands in the tree twice"
        in mistakes(Sequence("s", [Repeat("a", act), Repeat("b", act)]), workspace)[0].message
    )


def test_nodes_without_what_must_stand_below_them_are_refused(workspace: Workspace) -> None:
    empty, without = Sequence("s", []), Switch("w", value="1", cases={})
    assert [(p.message, p.code) for p in mistakes(Sequence("root", [empty, without]), workspace)] == [
        ("'sequence' 's' needs at least one child", "missing-child"),
        ("'cases' of 'switch' 'w' is empty", "missing-parameter"),
    ]


def test_every_built_in_type_is_in_nodes() -> None:
    from humanoid_bt.tree import nodes

    registry = Registry.of(Workspace(builtin_root()))
    ours = {node_type.cls.__name__ for node_type in registry.values() if node_type.kind != "skill"}
    assert ours | {"BUILTIN"} == set(nodes.__all__)
