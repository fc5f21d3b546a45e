"""Trees inside trees: parameters in and out, names of their own, nodes as parameters, no cycles."""

from __future__ import annotations

import textwrap

import pytest

from humanoid_bt.core.errors import Problem, UserError
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.show import unicode_tree
from humanoid_bt.tree.source.load import load_tree
from tests.tree.helpers import COUNTED, Run, load, seen, write

ACT = """\
subtree: true
parameters:
  script: {type: text, doc: What it does.}
root: {act: {script: $script}}
"""

TRIED = """\
subtree: true
parameters:
  attempts: 2
  action: {type: node, doc: What is tried.}
root: {retry: {attempts: $attempts, $action: }}
"""


def problems(workspace: Workspace, text: str) -> list[Problem]:
    with pytest.raises(UserError) as raised:
        load(workspace, textwrap.dedent(text))
    return list(raised.value.problems)


def test_parameters_go_in(workspace: Workspace) -> None:
    write(workspace, "acting", ACT)
    tree = load(workspace, "parameters: {what: s}\nroot: {subtree: {tree: acting, script: $what}}")
    assert [node.path for node in tree.nodes] == ["t/subtree", "t/subtree/act"]
    assert tree.nodes[1].values == {"script": "s"}
    assert tree.nodes[1].place.file.endswith("acting.yaml")
    assert [path.name for path in tree.files] == ["t.yaml", "acting.yaml"]
    assert tree.nodes[0].kind == "subtree"
    assert Run(tree).ticks(1) == "s"


def test_a_parameter_that_is_missing_is_named_with_its_doc_if_it_has_one(workspace: Workspace) -> None:
    write(workspace, "acting", ACT)
    (problem,) = problems(workspace, "root: {subtree: acting}")
    assert problem.hint == "script: text  # What it does."
    write(workspace, "acting", ACT.replace(", doc: What it does.", ""))
    (problem,) = problems(workspace, "root: {subtree: acting}")
    assert problem.hint == "script: text"


def test_the_short_form_names_a_tree_without_parameters(workspace: Workspace) -> None:
    write(workspace, "still", "root: {act: {script: rrs}}")
    assert Run(load(workspace, "root: {subtree: still}")).ticks(3) == "rrs"


def test_outputs_come_out_under_the_callers_name(workspace: Workspace) -> None:
    write(workspace, "counted", COUNTED)
    text = "root: {sequence: [{subtree: {tree: counted, total: n}}, {condition: n == 1}]}"
    assert Run(load(workspace, text)).ticks(1) == "s"


def test_its_keys_are_its_own_and_begin_anew_each_time(workspace: Workspace) -> None:
    write(workspace, "counted", COUNTED)
    text = """\
    blackboard: {count: 10}
    root:
      repeat:
        times: 3
        sequence:
          - subtree: {tree: counted, total: n}
          - condition: n == 1 and count == 10
    """
    assert Run(load(workspace, textwrap.dedent(text))).ticks(3) == "rrs"


def test_two_uses_share_nothing(workspace: Workspace) -> None:
    write(workspace, "counted", COUNTED)
    text = "root: {sequence: [{subtree: counted}, {subtree: {tree: counted, limit: 0}}]}"
    assert Run(load(workspace, text)).ticks(1) == "f"


def test_a_name_of_the_caller_means_nothing_in_it(workspace: Workspace) -> None:
    write(workspace, "leak", "subtree: true\nroot: {condition: secret == 1}")
    (problem,) = problems(
        workspace,
        "root: {sequence: [{set_blackboard: {key: secret, value: 1}}, {subtree: leak}, {condition: secret == 1}]}",
    )
    assert "unknown name 'secret'" in problem.message
    assert problem.place is not None
    assert problem.place.file.endswith("leak.yaml")


def test_a_key_of_the_caller_can_be_given_and_is_read_when_it_is_used(workspace: Workspace) -> None:
    write(workspace, "acting", ACT)
    text = """\
    root:
      for_each:
        item: what
        items: [rs, s, rrs]
        subtree: {tree: acting, script: $what}
    """
    run = Run(load(workspace, textwrap.dedent(text)))
    assert run.ticks(7)[-1] in "rs"
    assert run.tree.nodes[-1].name == "act"


def test_without_its_parameters_it_is_shown_with_their_names(workspace: Workspace) -> None:
    text = TRIED.replace("attempts: 2", "attempts: {type: integer}")
    tree = load_tree(write(workspace, "tried", text), workspace)
    assert not tree.complete and tree.is_subtree
    assert unicode_tree(tree).splitlines() == ["tried", "└─ retry  attempts: $attempts", "   └─ $action"]


def test_a_key_for_what_must_be_known_is_the_callers_mistake(workspace: Workspace) -> None:
    write(workspace, "tried", TRIED)
    text = "root: {for_each: {item: n, items: [1], subtree: {tree: tried, attempts: $n, action: act}}}"
    (problem,) = problems(workspace, text)
    assert problem.code == "not-dynamic"
    assert problem.place is not None and problem.place.file.endswith("t.yaml")
    assert "tried.yaml" in problem.hint


@pytest.mark.parametrize("asked", ["seen(thing)", "distance(thing) < 1 m", "thing.class == 'cup'"])
def test_a_key_cannot_name_a_percept(workspace: Workspace, asked: str) -> None:
    write(workspace, "near", f'subtree: true\nparameters: {{thing: target}}\nroot: {{condition: "{asked}"}}\n')
    text = "root: {for_each: {item: k, items: [cup], subtree: {tree: near, thing: $k}}}"
    (problem,) = problems(workspace, text)
    assert problem.code == "not-dynamic"
    assert problem.message.startswith("'thing' names a percept: it must be known before the run")
    assert problem.place is not None and problem.place.file.endswith("t.yaml")


def test_of_nothing_but_a_parameter_it_is_shown(workspace: Workspace) -> None:
    path = write(workspace, "given", "subtree: true\nparameters: {it: {type: node}}\nroot: $it\n")
    assert [node.path for node in load_tree(path, workspace).nodes] == ["given/$it"]


def test_without_its_parameters_it_cannot_be_written(workspace: Workspace) -> None:
    with pytest.raises(UserError, match="incomplete"):
        load_tree(write(workspace, "tried", TRIED), workspace).to_yaml()


def test_a_node_can_be_given_and_keeps_the_callers_names(workspace: Workspace) -> None:
    write(workspace, "tried", TRIED)
    tree = load(
        workspace,
        "parameters: {what: ff, attempts: 3}\n"
        "root: {subtree: {tree: tried, attempts: $attempts, action: {act: {script: $what, name: mine}}}}",
    )
    assert [node.path for node in tree.nodes] == ["t/subtree", "t/subtree/retry", "t/subtree/retry/mine"]
    assert Run(tree).ticks(3) == "rrf"


def test_a_sub_tree_may_stand_beside_the_file_that_uses_it(workspace: Workspace) -> None:
    folder = workspace.root / "trees" / "parts"
    folder.mkdir()
    (folder / "inner.yaml").write_text("format: 1\nroot: act")
    (folder / "outer.yaml").write_text("format: 1\nroot: {subtree: ./inner.yaml}")
    assert load_tree(folder / "outer.yaml", workspace).nodes[-1].name == "act"
    (link := workspace.root / "trees" / "link.yaml").symlink_to(folder / "outer.yaml")
    assert load_tree(link, workspace).nodes[-1].name == "act"  # beside what it leads to


def test_a_file_is_looked_for_beside_the_one_that_uses_it_alone(
    workspace: Workspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(workspace, "inner", "root: act\n")
    (outer := workspace.root / "outer.yaml").write_text("format: 1\nroot: {subtree: ./inner.yaml}")
    monkeypatch.chdir(workspace.root / "trees")
    with pytest.raises(UserError) as raised:
        load_tree(outer, workspace)
    (problem,) = raised.value.problems
    assert problem.message == "no tree file './inner.yaml' beside 'outer.yaml'"
    assert "'inner'" in problem.hint


def test_safety_looks_through_it(workspace: Workspace) -> None:
    write(workspace, "touch", "subtree: true\nparameters: {it: {type: percept}}\nroot: {reach: {target: $it}}")
    safe = "root: {emergency_stop: {watchdog: {percept: ball, max_age: 1, subtree: {tree: touch, it: ball}}}}"
    run = Run(load(workspace, safe))
    assert "left_hand" in run.tick(seen(0.0) | {"ball": seen(0.0)["target"]}).targets or run.changes
    found = problems(workspace, "root: {subtree: {tree: touch, it: ball}}")
    assert [problem.code for problem in found] == ["outside-emergency-stop", "outside-watchdog"]


def test_a_sub_tree_alone_needs_nothing_around_it_and_no_values(workspace: Workspace) -> None:
    path = write(
        workspace,
        "touch",
        "subtree: true\nparameters: {it: {type: percept}, act: {type: node}}\n"
        "root: {sequence: [{reach: {target: $it}}, $act, {condition: distance($it) < 1}]}",
    )
    assert not load_tree(path, workspace).complete


@pytest.mark.parametrize(
    ("text", "code", "message"),
    [
        ("{subtree: }", "missing-parameter", "the parameter 'tree' of 'subtree' is missing"),
        ("{subtree: {tree: actin, script: s}}", "unknown-tree", "no tree named 'actin'"),
        ("{subtree: acting}", "missing-parameter", "the parameter 'script' of 'subtree' is missing"),
        ("{subtree: {tree: acting, script: 3}}", "wrong-type", "'script' must be text"),
        ("{subtree: near}", "missing-parameter", "the parameter 'thing' of 'subtree' is missing"),
        ("{subtree: {tree: acting, script: s, scrip: s}}", "unknown-parameter", "unknown parameter 'scrip'"),
        ("{subtree: {tree: tried, attempts: 1 m, action: act}}", "wrong-unit", "'attempts' has the unit 'm'"),
        ("{subtree: {tree: tried}}", "missing-parameter", "the node 'action' of 'subtree' is missing"),
        ("{subtree: {tree: tried, action: {acct: }}}", "unknown-node", "unknown node 'acct'"),
        ("{subtree: {tree: counted, total: 3}}", "bad-name", "'total' must name a key"),
        ("$action", "unknown-reference", "'$action' is no node"),
        ("{subtree: {tree: acting, script: $what}}", "unknown-reference", "unknown parameter or key '$what'"),
    ],
)
def test_mistakes_in_its_use(workspace: Workspace, text: str, code: str, message: str) -> None:
    near = "subtree: true\nparameters: {thing: {type: percept}}\nroot: {condition: seen(thing)}\n"
    for name, tree in (("acting", ACT), ("tried", TRIED), ("counted", COUNTED), ("near", near)):
        write(workspace, name, tree)
    (problem,) = problems(workspace, f"root: {text}")
    assert message in problem.message
    assert problem.code == code
    assert problem.place is not None
    assert problem.place.line == 2


def test_a_tree_cannot_contain_itself(workspace: Workspace) -> None:
    write(workspace, "first", "root: {sequence: [act, {subtree: second}]}")
    write(workspace, "second", "root: {inverter: {subtree: first}}")
    (problem,) = problems(workspace, "root: {subtree: first}")
    assert problem.message == "the tree 'first' would contain itself"
    assert problem.hint == "t -> first -> second -> first"
    assert problem.place is not None
    assert problem.place.file.endswith("second.yaml")


def test_nodes_count_once_for_each_place_where_they_stand(
    workspace: Workspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("humanoid_bt.tree.source.load.MAX_NODES", 25)
    write(workspace, "level0", "root: {sequence: [act, act, act]}")
    for level in range(1, 4):
        write(workspace, f"level{level}", f"root: {{subtree: level{level - 1}}}")
    use = "{subtree: level3}"
    assert len(load(workspace, f"root: {{sequence: [{use}, {use}, {use}]}}").nodes) == 25
    (problem,) = problems(workspace, f"root: {{sequence: [{use}, {use}, {use}, {use}]}}")
    assert (problem.message, problem.code) == ("the tree has more than 25 nodes, its sub-trees expanded", "too-large")


def test_doubling_nodes_are_bounded(workspace: Workspace, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("humanoid_bt.tree.source.load.MAX_NODES", 500)
    pairs = [
        f"p{level}: {{type: node, default: {{sequence: [$p{level - 1}, $p{level - 1}]}}}}" for level in range(1, 30)
    ]
    text = f"parameters: {{p0: {{type: node, default: act}}, {', '.join(pairs)}}}\nroot: $p29\n"
    assert [problem.code for problem in problems(workspace, text)] == ["too-large"]


@pytest.mark.parametrize(
    ("parameters", "names"),
    [
        ("x: {type: node, default: $x}", "x -> x"),
        ("x: {type: node, default: {sequence: [act, $x]}}", "x -> x"),
        ("x: {type: node, default: $y}, y: {type: node, default: {inverter: {$x: }}}", "x -> y -> x"),
        (
            "x: {type: node, default: {subtree: {tree: tried, action: $x}}}",
            "x -> x",
        ),
    ],
)
def test_a_node_cannot_contain_itself(workspace: Workspace, parameters: str, names: str) -> None:
    write(workspace, "tried", TRIED)
    (problem,) = problems(workspace, f"parameters: {{{parameters}}}\nroot: $x\n")
    assert (problem.message, problem.hint, problem.code) == (
        "the node '$x' would contain itself",
        names,
        "subtree-cycle",
    )


def test_a_node_that_is_a_default_may_be_used_twice(workspace: Workspace) -> None:
    tree = load(workspace, "parameters: {x: {type: node, default: act}}\nroot: {sequence: [$x, {inverter: {$x: }}]}")
    assert [node.name for node in tree.nodes] == ["sequence", "act", "inverter", "act"]


def test_doubling_sub_trees_are_bounded(workspace: Workspace, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("humanoid_bt.tree.source.load.MAX_NODES", 500)
    write(workspace, "level0", "root: act")
    for level in range(1, 30):
        write(
            workspace,
            f"level{level}",
            f"root: {{sequence: [{{subtree: level{level - 1}}}, {{subtree: level{level - 1}}}]}}",
        )
    found = problems(workspace, "root: {subtree: level29}")
    assert {problem.code for problem in found} == {"too-large"}


def test_a_broken_sub_tree_is_told_once_and_with_its_own_place(workspace: Workspace) -> None:
    write(workspace, "broken", "parameters: {unused: 1}\nroot: {sequence: [idel]}")
    found = problems(workspace, "root: {sequence: [{subtree: broken}, {subtree: broken}]}")
    assert [(p.message, p.place.line if p.place else 0) for p in found] == [
        ("unknown node 'idel'", 3),
    ]
    assert all(p.place and p.place.file.endswith("broken.yaml") for p in found)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("parameters: {tree: a}\nroot: {act: {script: $tree}}", "'tree' cannot be called so"),
        ("outputs: {x: {type: text}}\nroot: act", "nothing writes the output 'x'"),
        ("outputs: {x: 1}\nroot: {set_blackboard: {key: x, value: 2}}", "the output 'x' cannot have a default"),
        (
            "outputs: {x: {type: number, default: 1}}\nroot: {set_blackboard: {key: x, value: 2}}",
            "the output 'x' cannot have a default",
        ),
        (
            "parameters: {x: 1}\noutputs: {x: {type: number}}\nroot: {set_blackboard: {key: x, value: $x}}",
            "declared twice",
        ),
        ("blackboard: {x: 1}\nparameters: {x: 1}\nroot: {condition: x == 1}", "declared twice"),
        (
            "parameters: {x: a}\nroot: {for_each: {item: x, items: [s, f], act: {script: $x}}}",
            "'x' has the name of a p",
        ),
        (
            "parameters: {x: 1}\nroot: {for_each: {item: [x, y], items: [[1]], condition: x == y}}",
            "'x' has the name of a parameter",
        ),
        ("blackboard: {x: $y}\nroot: {condition: x == 1}", "'$y' cannot stand here: the key 'x' begins with"),
        ("blackboard: {x: {type: number}}\nroot: {condition: x == 1}", "the key 'x' is read, but nothing writes it"),
        (
            "blackboard: {x: {type: number, unit: m}}\nroot: {sequence: [{set_blackboard: {key: x, value: 1}}, "
            "{condition: x > 1 s}]}",
            "a number in m and a number in s",
        ),
        (
            "root: {sequence: [{for_each: {item: n, items: [1, 2], act: }}, {retry: {attempts: $n, act: }}]}",
            "'attempts' of 'retry' must be known before the run",
        ),
        ("root: {for_each: {item: n, items: [cup, ball], log: '{distance(n)}'}}", "'n' names a percept: it must be"),
        (
            "root: {emergency_stop: {sequence: [{set_blackboard: {key: n, value: a}}, {reach: {target: $n}}]}}",
            "'target' of 'reach' must be known before the run",
        ),
    ],
)
def test_mistakes_in_what_a_tree_declares(workspace: Workspace, text: str, message: str) -> None:
    (problem,) = problems(workspace, text)
    assert message in problem.message


def test_declared_keys_that_nothing_reads_are_only_worth_a_warning(workspace: Workspace) -> None:
    tree = load(workspace, "blackboard: {x: 1}\nroot: act")
    assert [(w.code, w.severity) for w in tree.warnings] == [("unused-key", "warning")]


def test_a_tree_that_starts_again_has_its_keys_as_at_first(workspace: Workspace) -> None:
    text = "blackboard: {n: 0}\nroot: {sequence: [{set_blackboard: {key: n, expression: n + 1}}, {condition: n == 1}]}"
    assert Run(load(workspace, text)).ticks(3) == "sss"


def test_a_wrong_expression_is_one_mistake(workspace: Workspace) -> None:
    (problem,) = problems(workspace, "parameters: {a: 1}\nblackboard: {n: 0}\nroot: {condition: n == a and m > 1}")
    assert "unknown name 'm'" in problem.message


@pytest.mark.parametrize("given", ["expression: $n", "expression: n", "value: $n"])
def test_a_key_can_get_the_value_of_another(workspace: Workspace, given: str) -> None:
    text = f"blackboard: {{n: 3}}\nroot: {{sequence: [{{set_blackboard: {{key: m, {given}}}}}, {{condition: m == 3}}]}}"
    assert Run(load(workspace, text)).ticks(1) == "s"


def test_a_node_that_is_given_may_use_the_same_tree(workspace: Workspace) -> None:
    write(workspace, "tried", TRIED)
    inner = "{subtree: {tree: tried, attempts: 1, action: {act: {script: f}}}}"
    tree = load(workspace, f"root: {{subtree: {{tree: tried, attempts: 2, action: {inner}}}}}")
    assert [node.type_name for node in tree.nodes] == ["subtree", "retry", "subtree", "retry", "act"]
    assert Run(tree).ticks(2) == "rf"


def test_a_tree_cannot_give_itself_to_itself(workspace: Workspace) -> None:
    write(workspace, "first", "subtree: true\nparameters: {a: {type: node}}\nroot: {subtree: {tree: first, a: $a}}")
    (problem,) = problems(workspace, "root: {subtree: {tree: first, a: act}}")
    assert problem.code == "subtree-cycle"


@pytest.mark.parametrize(
    ("text", "code", "message"),
    [
        (
            "for_each: {item: n, items: [1, 2], act: {script: $n}}",
            "wrong-type",
            "'script' must be text, and",
        ),
        ("for_each: {item: n, items: [s, f], wait: $n}", "wrong-type", "'duration' must be a number in s"),
        ("for_each: {item: n, items: [-1, -2], wait: $n}", "out-of-range", "'duration' must be >= 0, not -1"),
        (
            "sequence: [{set_blackboard: {key: n, value: loud}}, {log: {text: hi, level: $n}}]",
            "wrong-choice",
            "'level' cannot be 'loud'",
        ),
    ],
)
def test_a_key_of_the_wrong_type_is_found_before_the_run(
    workspace: Workspace, text: str, code: str, message: str
) -> None:
    (problem,) = problems(workspace, f"root: {{{text}}}")
    assert message in problem.message
    assert problem.code == code


LENGTH = "blackboard: {x: {type: number, unit: m}}\n"
TOLD = "subtree: true\noutputs: {ok: {type: boolean}}\nroot: {set_blackboard: {key: ok, value: true}}\n"


@pytest.mark.parametrize(
    ("declared", "nodes", "found"),
    [
        (
            "",
            "for_each: {item: [x, y], items: [[1 m, 0]], condition: x < 2 m}",
            "'x < 2 m': text and a number in m cannot be compared",
        ),
        ("", "for_each: {item: x, items: [1 m, 3], condition: x < 2 m}", "text and a number in m cannot be compared"),
        ("", "for_each: {item: [x], items: [[1 m]], wait: $x}", "'duration' must be a number in s, and the key 'x' is"),
        ("", "for_each: {item: [x], items: [[1 s], [2]], wait: $x}", None),
        ("", "for_each: {item: x, items: [1 s, 2 min], wait: $x}", None),
        ("", "for_each: {item: [x, y], items: [[a], [b, 2]], log: '{x} {y}'}", None),
        ("", "for_each: {item: x, items: [-1, 2], selector: [condition: x < 0, wait: $x]}", None),
        ("", "for_each: {item: x, items: [1, .inf], log: '{x}'}", "'x' must be finite, not inf"),
        (LENGTH, "for_each: {item: [x], items: [[5 cm], [0.2]], condition: x < 2 m}", None),
        (LENGTH, "for_each: {item: [x], items: [[5 cm], [5 s]], condition: x < 2 m}", "'x' has the unit 's'"),
        (
            "blackboard: {x: {type: integer}}\n",
            "sequence: [{set_blackboard: {key: x, value: 2.5}}, {condition: x < 2}]",
            "'x' must be a whole number, not a number 2.5",
        ),
        (
            "blackboard: {x: {type: text}}\n",
            "for_each: {item: x, items: [a, ~], condition: x == 'a'}",
            "'x' must be text, not nothing",
        ),
        (
            "",
            "sequence: [{subtree: {tree: told, ok: x}}, {set_blackboard: {key: x, value: 5}}, {condition: x}]",
            "'x' must be true or false, not a number 5",
        ),
        (
            "",
            "sequence: [{subtree: {tree: told, ok: x}}, {subtree: {tree: near, gone: x}}, {condition: x}]",
            "the output 'gone' is a number in m, and the key 'x' is true or false",
        ),
    ],
)
def test_what_is_written_as_it_stands_in_the_file_goes_with_its_key(
    workspace: Workspace, declared: str, nodes: str, found: str | None
) -> None:
    write(workspace, "told", TOLD)
    write(workspace, "near", NEAR)
    text = f"{declared}root: {{{nodes}}}"
    if found is None:
        load(workspace, text)
    else:
        (problem,) = problems(workspace, text)
        assert found in problem.message


def test_a_quantity_is_a_number_in_a_key_that_is_declared(workspace: Workspace) -> None:
    text = f"{LENGTH}root: {{sequence: [{{set_blackboard: {{key: x, value: 46 cm}}}}, {{condition: x < 0.5 m}}]}}"
    run = Run(load(workspace, text))
    assert run.ticks(1) == "s"
    assert [key.value for key in run.tree.keys] == [0.46]


def test_a_key_of_the_wrong_unit_is_found_before_the_run(workspace: Workspace) -> None:
    text = "blackboard: {far: {unit: m, default: 1}}\nroot: {wait: $far}"
    (problem,) = problems(workspace, text)
    assert (problem.code, problem.message) == (
        "wrong-unit",
        "'duration' must be a number in s, and the key 'far' is a number in m",
    )


NEAR = """\
subtree: true
outputs: {gone: {type: number, unit: m}}
root: {set_blackboard: {key: gone, value: 0.46}}
"""


@pytest.mark.parametrize(
    ("text", "place", "code", "message"),
    [
        (
            "root: {sequence: [{subtree: {tree: near, gone: d}}, {condition: d < 1 s}]}",
            "2:67",
            "expression",
            "a number in m and a number in s",
        ),
        (
            "root: {sequence: [{subtree: {tree: near, gone: d}}, {wait: $d}]}",
            "2:60",
            "wrong-unit",
            "'duration' must be a number in s, and the key 'd' is a number in m",
        ),
        (
            "blackboard: {d: {type: number, unit: s}}\n"
            "root: {sequence: [{subtree: {tree: near, gone: d}}, {condition: d < 1 s}]}",
            "3:48",
            "wrong-unit",
            "the output 'gone' is a number in m, and the key 'd' is a number in s",
        ),
        (
            "blackboard: {d: {type: text}}\n"
            "root: {sequence: [{subtree: {tree: near, gone: d}}, {condition: d == 'far'}]}",
            "3:48",
            "wrong-type",
            "the output 'gone' is a number in m, and the key 'd' is text",
        ),
        (
            "root: {sequence: [{subtree: {tree: near, gone: d}}, {subtree: {tree: took, time: d}}, "
            "{condition: d < 1}]}",
            "2:82",
            "wrong-unit",
            "the output 'time' is a number in s, and the key 'd' is a number in m",
        ),
        (
            "root: {sequence: [{subtree: {tree: near, gone: d}}, {set_blackboard: {key: d, value: 46 ms}}, "
            "{condition: d < 1}]}",
            "2:86",
            "wrong-unit",
            "'d' has the unit 'ms'",
        ),
        (
            "outputs: {d: {type: number, unit: m}}\nroot: {set_blackboard: {key: d, value: far}}",
            "3:40",
            "wrong-type",
            "'d' must be a number, not text 'far'",
        ),
    ],
)
def test_the_unit_of_an_output_is_that_of_the_callers_key(
    workspace: Workspace, text: str, place: str, code: str, message: str
) -> None:
    write(workspace, "near", NEAR)
    write(workspace, "took", NEAR.replace("gone", "time").replace("unit: m", "unit: s"))
    (problem,) = problems(workspace, text)
    assert message in problem.message
    assert problem.code == code
    assert problem.place is not None
    assert f"{problem.place.line}:{problem.place.column}" == place


def test_an_output_says_its_unit_where_it_is_written_and_read(workspace: Workspace) -> None:
    write(workspace, "near", NEAR)
    copied = "{set_blackboard: {key: e, expression: d}}"
    text = f"root: {{sequence: [{{subtree: {{tree: near, gone: d}}}}, {{condition: d < 1 m}}, {copied}]}}"
    run = Run(load(workspace, text))
    assert run.ticks(1) == "s"
    said = [node.behaviour.feedback_message for node in run.tree.nodes if node.type_name != "sequence"]
    assert said == ["", "d = 0.46 m", "d 0.46 m < 1 m", "e = 0.46 m"]
