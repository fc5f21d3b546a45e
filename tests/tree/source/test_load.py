from __future__ import annotations

import textwrap

import pytest

from humanoid_bt import nodes
from humanoid_bt.core.errors import Problem, UserError
from humanoid_bt.files.workspace import Workspace
from tests.tree.helpers import load, run


def problems(workspace: Workspace, text: str, **overrides: str) -> tuple[Problem, ...]:
    """Return what is wrong with a tree file; line 1 is the format."""
    with pytest.raises(UserError) as caught:
        load(workspace, textwrap.dedent(text).lstrip("\n"), **overrides)
    return caught.value.problems


def one(workspace: Workspace, text: str, **overrides: str) -> tuple[str, str]:
    """Return the only mistake as ``line:column message`` and its hint."""
    found = problems(workspace, text, **overrides)
    assert len(found) == 1, "\n".join(map(str, found))
    place = found[0].place
    assert place is not None
    where = f"{place.line}:{place.column}" if place.line else place.file
    return f"{where} {found[0].message}", found[0].hint


def test_nodes_have_names_paths_places_and_parents(workspace: Workspace) -> None:
    tree = load(
        workspace,
        textwrap.dedent(
            """\
            name: fetch it
            description: A tree.
            robot: humanoid
            scene: empty
            root:
              emergency_stop:
                sequence:
                  name: all
                  children:
                    - idle
                    - idle: {name: rest}
                    - idle:
                    - {idle: {name: idle#2}}
            """
        ),
    )
    assert (tree.name, tree.description, tree.robot, tree.scene) == ("fetch it", "A tree.", "humanoid", "empty")
    assert [node.path for node in tree.nodes] == [
        "fetch it/emergency_stop",
        "fetch it/emergency_stop/all",
        "fetch it/emergency_stop/all/idle",
        "fetch it/emergency_stop/all/rest",
        "fetch it/emergency_stop/all/idle#2",
        "fetch it/emergency_stop/all/idle#2#2",
    ]
    assert [node.parent for node in tree.nodes] == [-1, 0, 1, 1, 1, 1]
    assert [node.type_name for node in tree.nodes[:3]] == ["emergency_stop", "sequence", "idle"]
    assert [node.kind for node in tree.nodes[:3]] == ["decorator", "composite", "skill"]
    assert [(node.place.line, node.place.column) for node in tree.nodes] == [
        (7, 3), (8, 5), (11, 11), (12, 11), (13, 11), (14, 12),
    ]  # fmt: skip
    assert vars(tree.nodes[3].behaviour)["path"] == tree.nodes[3].path
    assert tree.root is tree.nodes[0].behaviour
    assert tree.source.startswith("format: 1\nname: fetch it")


def test_the_name_is_the_files_if_not_given(workspace: Workspace) -> None:
    assert load(workspace, "root: act").name == "t"


def test_short_forms(workspace: Workspace) -> None:
    tree = load(workspace, "root: {inverter: {sequence: [act, {act: }, {act: {}}, {inverter: act}]}}")
    assert [node.type_name for node in tree.nodes] == ["inverter", "sequence", "act", "act", "act", "inverter", "act"]


def test_on_stale_is_a_part_of_the_tree(workspace: Workspace) -> None:
    tree = load(
        workspace,
        "root: {emergency_stop: {watchdog: {percept: p, max_age: 1, on_stale: {inverter: idle}, act: }}}",
    )
    assert [(node.name, node.parent, node.branch) for node in tree.nodes[1:]] == [
        ("watchdog", 0, ""),
        ("act", 1, ""),
        ("inverter", 1, "on_stale"),
        ("idle", 3, ""),
    ]


def test_what_an_unknown_node_refers_to_is_not_called_unused(workspace: Workspace) -> None:
    with pytest.raises(UserError) as caught:
        load(workspace, "parameters: {limit: 3}\nroot: {timeot: {duration: $limit, act: }}")
    assert [problem.message for problem in caught.value.problems] == ["unknown node 'timeot'"]


MISTAKES = [
    ("root: idel", "2:7 unknown node 'idel'", "did you mean 'idle'?"),
    ("root: {inverte: act}", "2:8 unknown node 'inverte'", "did you mean 'inverter'?"),
    ("root: {act: {scrip: r}}", "2:14 unknown parameter 'scrip' of 'act'", "did you mean 'script'?"),
    ("root: {act: {script: 3}}", "2:22 'script' must be text, not a number 3", "What to return."),
    ("root: {act: [1]}", "2:13 what 'act' holds must be a mapping, not a list", "act: {script: ...}"),
    ("root: {timeout: act}", "2:8 the parameter 'duration' of 'timeout' is missing", "duration: number [s]"),
    ("root: {timeout: {duration: 1 m, act: }}", "2:28 'duration' has the unit 'm'", "valid: s, ms, min"),
    ("root: {timeout: {duration: -1, act: }}", "2:28 'duration' must be > 0, not -1", ""),
    ("root: {inverter: }", "2:8 'inverter' needs a child", ""),
    ("root: {inverter: {name: x}}", "2:8 'inverter' needs a child", ""),
    ("root: {inverter: {act: , idel: }}", "2:26 'idel' is neither a parameter of 'inverter' nor a node", "'idle'"),
    ("root: {inverter: {act: , plain: }}", "2:26 'inverter' has one child, here are 2", "sequence"),
    ("root: {inverter: [act]}", "2:18 what 'inverter' holds must be a mapping, not a list", "one child"),
    ("root: {sequence: []}", "2:18 'sequence' needs at least one child", ""),
    ("root: {sequence: }", "2:8 'sequence' needs at least one child", ""),
    ("root: {sequence: {children: act}}", "2:29 the children of 'sequence' must be a list, not text", "- "),
    ("root: {sequence: {children: [act], nam: a}}", "2:36 unknown parameter 'nam' of 'sequence'", "'name'"),
    ("root: {sequence: {children: [act], act: }}", "2:36 'act' stands beside the children of 'sequence'", "list"),
    ("root: {sequence: [3]}", "2:19 a child of 'sequence' must be a node, not a number", "idle"),
    ("root: [act]", "2:7 the root must be a node, not a list", ""),
    ("root: {}", "2:7 the root must be a node, not an empty mapping", ""),
    ("root:", "2:6 the root must be a node, not nothing", ""),
    ("root: {act: , plain: }", "2:15 a node is one key, here are 2", "below a sequence"),
    ("root: {act: {name: a/b}}", "2:20 'a/b' cannot be a name", "without /"),
    ("root: {act: {name: 3}}", "2:20 a name must be text, not a number", ""),
    ("root: act\nnme: x", "3:1 unknown key 'nme' of a tree", "did you mean 'name'?"),
    ("root: act\nname: a/b", "3:7 'a/b' cannot be a name", ""),
    ("name: x", "1:1 the key 'root' of a tree is missing", "root: the root node"),
    ("root: act\nroot: act", "3:1 the key 'root' stands twice in one mapping", "the first is at"),
    ("root: {act: {script: r, script: s}}", "2:25 the key 'script' stands twice in one mapping", "the first is at"),
    ("format: 2\nroot: act", "1:9 'format' cannot be 2", "valid: 1"),
    ("root: {plain: {count: many}}", "2:23 'count' must be a whole number, not text 'many'", ""),
]


_GOES_ON, _ASKS = "goes on with what runs", "asks again in every tick"
MEMORY = [
    ("sequence", "true", f"leave it out: 'sequence' {_GOES_ON}"),
    ("sequence", "false", f"use 'reactive_sequence', which {_ASKS}"),
    ("fallback", "false", f"use 'reactive_selector', which {_ASKS}"),
    ("reactive_selector", "true", f"use 'selector', which {_GOES_ON}"),
    ("reactive_sequence", "false", f"leave it out: 'reactive_sequence' {_ASKS}"),
    ("selector", "$often", f"'selector' {_GOES_ON}, 'reactive_selector' {_ASKS}"),
    ("if", "true", f"leave it out: 'if' {_GOES_ON}"),
    ("switch", "false", f"use 'reactive_switch', which {_ASKS}"),
    ("parallel", "true", "valid: "),
]


@pytest.mark.parametrize(("kind", "value", "hint"), MEMORY)
def test_memory_is_answered_with_the_type_that_does_it(workspace: Workspace, kind: str, value: str, hint: str) -> None:
    below = {"if": "condition: 1 < 2, then: act", "switch": "value: state.gait, cases: {stand: act}"}
    root = f"{{{kind}: {{memory: {value}, {below.get(kind, 'children: [act]')}}}}}"
    declared = "parameters: {often: true}\n" if "$" in value else ""
    found, found_hint = one(workspace, f"{declared}root: {root}")
    assert found == f"{3 if declared else 2}:{11 + len(kind)} unknown parameter 'memory' of {kind!r}"
    assert found_hint.startswith(hint)


def test_a_former_parameter_is_answered_with_what_the_node_does(workspace: Workspace) -> None:
    hint = "leave it out: the node always waits for the reset"
    root = "root: {emergency_stop: {wait_for_reset: $patient, act: }}"
    found, found_hint = one(workspace, f"parameters: {{patient: true}}\n{root}")
    assert found == "3:25 unknown parameter 'wait_for_reset' of 'emergency_stop'"
    assert found_hint.startswith(hint)
    with pytest.raises(TypeError, match=hint):
        nodes.EmergencyStop("safe", nodes.Success("done"), wait_for_reset=True)


@pytest.mark.parametrize(("text", "message", "hint"), MISTAKES)
def test_a_mistake_is_answered_with_its_place_and_a_hint(
    workspace: Workspace, text: str, message: str, hint: str
) -> None:
    found, found_hint = one(workspace, text)
    assert found == message or found.startswith(message + " ")
    assert hint in found_hint


def test_a_missing_format_is_named(workspace: Workspace) -> None:
    path = workspace.root / "trees" / "t.yaml"
    path.write_text("root: act\n")
    from humanoid_bt.tree.source.load import load_tree

    with pytest.raises(UserError, match=r"t.yaml:1:1: error: the key 'format' of a tree is missing"):
        load_tree(path, workspace)


def test_all_mistakes_are_answered_at_once_in_the_files_order(workspace: Workspace) -> None:
    found = problems(
        workspace,
        """
        nme: x
        parameters: {speed: 3}
        root:
          sequence:
            - timeout: {duraton: 1, act: }
            - idel
            - act: {script: $sped}
            - act: {script: $speed}
            - confident: {percept: ball, above: 2}
            - idle
            - retry: {attempts: 0, act: }
        """,
        missing="1",
    )
    assert [(p.place.line if p.place else None, p.message) for p in found] == [
        (2, "unknown key 'nme' of a tree"),
        (6, "'duraton' is neither a parameter of 'timeout' nor a node"),
        (7, "unknown node 'idel'"),
        (8, "unknown parameter or key '$sped'"),
        (9, "'script' must be text, not a number 3.0"),
        (10, "'confident' uses the percept 'ball' outside a watchdog on it"),
        (10, "'above' must be >= 0 and <= 1, not 2"),
        (11, "'idle' commands gaze, posture outside an emergency_stop"),
        (12, "'retry' is never ticked: 'idle' before it never ends"),
        (12, "'retry' cannot be made: 'attempts' must be at least 1, or -1 for ever"),
        (0, "the tree has no parameter 'missing'"),
    ]


def test_a_constructor_that_raises_is_answered_with_both_places(workspace: Workspace) -> None:
    (workspace.root / "skills" / "fussy.py").write_text(
        "from humanoid_bt.decision.skill import Skill, Status\n"
        "class Fussy(Skill):\n"
        "    def __init__(self, name='', **values):\n"
        "        raise LookupError('no way')\n"
        "    def update(self): return Status.SUCCESS\n"
    )
    message, hint = one(workspace, "root: fussy")
    assert message == "2:7 'fussy' cannot be made: LookupError: no way"
    assert "fussy.py:4:" in hint


def test_a_skill_file_that_cannot_be_imported_is_answered_with_its_line(workspace: Workspace) -> None:
    (workspace.root / "skills" / "broken.py").write_text("import math\n\nmath.nothing\n")
    found = problems(workspace, "root: act\nnme: 3")
    assert [p.message.split(":")[0] for p in found] == [
        "unknown key 'nme' of a tree",
        "the skill file cannot be imported",
    ]
    assert "broken.py:3:1" in str(found[1])


def test_a_users_skill_works_like_a_built_in_one(workspace: Workspace) -> None:
    assert run(workspace, "{sequence: [{plain: {count: 3}}]}").ticks(3) == "rrs"


def test_deep_trees_load_and_run(workspace: Workspace) -> None:
    deep = run(workspace, "{inverter: " * 96 + "act" + "}" * 96)
    assert deep.ticks(1) == "r"
    assert len(deep.tree.nodes) == 97


def test_many_equal_siblings_get_different_paths(workspace: Workspace) -> None:
    tree = load(workspace, f"root: [{', '.join(['act'] * 500)}]".replace("root: ", "root: {sequence: ") + "}")
    assert len({node.path for node in tree.nodes}) == 501
    assert tree.nodes[-1].path.endswith("/act#500")
