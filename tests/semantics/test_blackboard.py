"""The blackboard and sub-trees."""

from __future__ import annotations

from pathlib import Path

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.ticking.executor import NodeError
from tests.semantics.claims import shows
from tests.tree.helpers import COUNTED, Run, load, run, write

COUNT = "{set_blackboard: {key: n, expression: n + 1}}"


def told(under_test: Run) -> list[str]:
    """Return what the tree's logs told."""
    return [text for _, _, text in under_test.events]


@shows("key-seen")
def test_a_value_is_seen_in_the_same_tick(workspace: Workspace) -> None:
    keyed = run(workspace, "{sequence: [{set_blackboard: {key: k, value: 3}}, {condition: k == 3}]}")
    assert keyed.ticks(1) == "s"


@shows("key-condition", "key-initial", "key-halt")
def test_keys_through_ticks_halts_and_starts(workspace: Workspace) -> None:
    text = f"blackboard: {{n: 0}}\nroot: {{reactive_sequence: [{{sequence: [{COUNT}, {{condition: n < 3}}]}}, act]}}\n"
    keyed = Run(load(workspace, text))
    assert keyed.ticks(4) == "rrfr"  # counted in every tick; the tree that failed starts with 0 again
    (key,) = keyed.tree.keys
    keyed.halt()
    assert key.value == 1


PATIENT = """
from humanoid_bt.core.params import param
from humanoid_bt.decision.skill import Skill, Status

class Patient(Skill):
    ticks: int = param(doc="How many ticks it takes.")
    def initialise(self):
        self.done = 0
    def update(self):
        self.done += 1
        return self.succeed("") if self.done == self.ticks else self.running(str(self.ticks))
"""


PUTTING = """
import numpy as np
from humanoid_bt import Key, Skill, param

class Putting(Skill):
    key: Key = param(doc="Where to.")
    what: str = param(doc="What, in Python.")
    def update(self):
        self.key.set(eval(self.what))
        return self.succeed("")
"""


def put(workspace: Workspace, what: str, declared: str = "") -> Run:
    (workspace.root / "skills" / "putting.py").write_text(PUTTING, encoding="utf-8")
    head = f"blackboard: {{k: {{type: {declared}}}}}\n" if declared else ""
    root = f"{{sequence: [{{putting: {{key: k, what: {what!r}}}}}, {{condition: is_set(k)}}]}}"
    return Run(load(workspace, f"{head}root: {root}\n"))


@shows("key-declared")
@pytest.mark.parametrize(
    ("declared", "what", "said"),
    [
        ("number", "'a'", "the key 'k' must be a number, not text 'a'"),
        ("number", "None", "the key 'k' must be a number, not nothing"),
        ("number", "dict(a=1)", "the key 'k' must be a number, not a mapping"),
        ("number", "np.array([1.0, 2.0])", "the key 'k' must be a number, not a list"),
        ("number", "self", "the key 'k' must be a number, not an object of type Putting"),
        ("number", "float('nan')", "the key 'k' must be finite, not nan"),
        ("integer", "2.5", "the key 'k' must be a whole number, not a number 2.5"),
        ("boolean", "1", "the key 'k' must be true or false, not a number 1"),
        ("text", "2", "the key 'k' must be text, not a number 2"),
        ("", "float('inf')", "the key 'k' must be finite, not inf"),
        ("", "10**400", "the key 'k' must be finite, not 1000"),
        ("", "np.float32('nan')", "the key 'k' must be finite, not nan"),
    ],
)
def test_a_key_takes_what_it_is_declared_to_be(workspace: Workspace, declared: str, what: str, said: str) -> None:
    with pytest.raises(NodeError, match=said) as raised:
        put(workspace, what, declared).ticks(1)
    assert raised.value.path.endswith("/putting")
    assert str(raised.value.where).endswith("putting.py:9:9")


@shows("key-declared")
@pytest.mark.parametrize(
    ("declared", "what", "value"),
    [
        ("number", "np.float32(0.5)", 0.5),
        ("number", "2", 2.0),
        ("integer", "np.int64(3)", 3),
        ("boolean", "np.bool_(True)", True),
        ("list", "np.array([1, 2])", [1, 2]),
        ("list", "(1, 2)", [1, 2]),
        ("", "np.float64(0.5)", 0.5),
        ("", "dict(a=1)", {"a": 1}),
    ],
)
def test_numbers_of_numpy_are_plain_ones(workspace: Workspace, declared: str, what: str, value: object) -> None:
    keyed = put(workspace, what, declared)
    assert keyed.ticks(1) == "s"
    assert keyed.tree.keys[0].value == value
    assert type(keyed.tree.keys[0].value) is type(value)


COLLECT = """
from humanoid_bt import Key, Skill, param

class Collect(Skill):
    key: Key = param(doc="Where to.")
    how: str = param(doc="In Python.")
    def initialise(self):
        self.all = []
    def update(self):
        self.all.append(len(self.all))
        eval(self.how)
        return self.succeed("") if len(self.all) == 3 else self.running("")
"""


@shows("key-initial")
@pytest.mark.parametrize("declared", ["[7]", "{type: list, default: [7]}"])
@pytest.mark.parametrize("how", ["self.key.value.append(1)", "self.key.set(self.all)"])
def test_a_list_belongs_to_its_key_alone(workspace: Workspace, declared: str, how: str) -> None:
    (workspace.root / "skills" / "collect.py").write_text(COLLECT, encoding="utf-8")
    keyed = Run(load(workspace, f"blackboard: {{k: {declared}}}\nroot: {{collect: {{key: k, how: {how!r}}}}}\n"))
    (key,) = keyed.tree.keys
    assert key.value == [7]
    for _ in range(2):
        assert keyed.ticks(3) == "rrs"
        assert key.value == ([7, 1, 1, 1] if "append" in how else [0, 1, 2])
    assert key.initial == [7]


@shows("key-declared")
def test_what_is_computed_is_finite_and_no_part_of_an_item_is_none(workspace: Workspace) -> None:
    big = "{sequence: [{set_blackboard: {key: k, expression: 1e308 * (10 + n)}}, {condition: k > 0}]}"
    with pytest.raises(NodeError, match="the key 'k' must be finite, not inf"):
        Run(load(workspace, f"blackboard: {{n: 0}}\nroot: {big}\n")).ticks(1)
    loop = "{for_each: {item: [x, turn], items: [[1 m, 90 deg], [1 m]], condition: x > 0.5 m and is_set(turn)}}"
    keys = "{x: {type: number, unit: m}, turn: {type: number, unit: rad}}"
    keyed = Run(load(workspace, f"blackboard: {keys}\nroot: {loop}\n"))
    assert keyed.ticks(2) == "rs"
    assert [key.value for key in keyed.tree.keys] == [1.0, None]


@shows("key-at-start")
def test_a_parameter_is_read_at_the_start(workspace: Workspace) -> None:
    (workspace.root / "skills" / "patient.py").write_text(PATIENT, encoding="utf-8")
    root = f"{{reactive_sequence: [{COUNT}, {{patient: {{ticks: $n}}}}]}}"
    keyed = Run(load(workspace, f"blackboard: {{n: 2}}\nroot: {{repeat: {root}}}\n"))
    assert keyed.ticks(3) == "rrr"  # 3 ticks, though the key goes on to 5
    patient = keyed.tree.nodes[-1].behaviour
    assert (vars(patient)["ticks"], patient.status.name) == (3, "SUCCESS")
    keyed.tick()
    assert vars(patient)["ticks"] == 6


@shows("key-at-start")
def test_a_parameter_of_a_sub_tree_stays_until_its_next_start(workspace: Workspace) -> None:
    said = "{log: '{at}'}, {sequence: [{wait: 0.1 s}, {log: '{at} still'}]}"
    write(workspace, "inner", f"subtree: true\nparameters: {{at: {{type: number}}}}\nroot: {{sequence: [{said}]}}\n")
    within = "{subtree: {tree: inner, at: $at}}"
    write(workspace, "outer", f"subtree: true\nparameters: {{at: {{type: number}}}}\nroot: {within}\n")
    root = f"{{repeat: {{parallel: [{{subtree: {{tree: outer, at: $n}}}}, {COUNT}]}}}}"
    keyed = Run(load(workspace, f"blackboard: {{n: 1}}\nroot: {root}\n"))
    assert keyed.ticks(4) == "rrrr"
    assert told(keyed) == ["1", "1 still", "2", "2 still"]


@shows("key-unset", "key-clear")
def test_a_key_without_a_value(workspace: Workspace) -> None:
    cleared = "{set_blackboard: {key: k, value: 3}}, {clear_blackboard: k}"
    assert run(workspace, f"{{sequence: [{cleared}, {{condition: is_set(k)}}]}}").ticks(1) == "f"
    with pytest.raises(NodeError, match="'k' is read before anything has written it"):
        run(workspace, f"{{sequence: [{cleared}, {{condition: k == 3}}]}}").tick()


@shows("key-unseen")
def test_a_value_of_what_was_never_seen(workspace: Workspace) -> None:
    write_it = "{set_blackboard: {key: k, expression: distance(target)}}"
    text = f"subtree: true\nblackboard: {{k: 7}}\nroot: {{sequence: [{{inverter: {write_it}}}, {{condition: k == 7}}]}}"
    assert Run(load(workspace, text)).ticks(1) == "s"


@shows("key-unwritten")
def test_what_nothing_writes_is_refused(workspace: Workspace) -> None:
    with pytest.raises(UserError, match="the key 'x' is read, but nothing writes it"):
        load(workspace, "blackboard: {x: {type: number}}\nroot: {condition: x == 1}")


WINK = """
from humanoid_bt.core.params import param
from humanoid_bt.decision.skill import PerceptName, Skill

class Wink(Skill):
    target: PerceptName | None = param(None, doc="At whom.")
    others: list[PerceptName] = param([], doc="At whom else.")
    def update(self):
        return self.succeed("")
"""


@shows("key-static")
@pytest.mark.parametrize(("skill", "parameter"), [("reach", "target"), ("wink", "target"), ("wink", "others")])
def test_what_the_checks_must_know_is_no_key(workspace: Workspace, skill: str, parameter: str) -> None:
    (workspace.root / "skills" / "wink.py").write_text(WINK, encoding="utf-8")
    keyed = f"sequence: [{{set_blackboard: {{key: n, value: a}}}}, {{{skill}: {{{parameter}: $n}}}}]"
    with pytest.raises(UserError, match=f"'{parameter}' of '{skill}' must be known before the run"):
        run(workspace, f"{{emergency_stop: {{{keyed}}}}}")


@shows("key-scope")
def test_two_trees_share_no_key(workspace: Workspace) -> None:
    text = f"blackboard: {{n: 0}}\nroot: {{sequence: [{COUNT}, {{condition: n == 1}}]}}"
    first, second = Run(load(workspace, text)), Run(load(workspace, text))
    assert (first.ticks(1), second.ticks(1)) == ("s", "s")


# ---- sub-trees -----------------------------------------------------------------------------------------------------


@shows("subtree-status")
def test_a_subtree_has_the_status_of_its_tree(workspace: Workspace) -> None:
    write(workspace, "part", "root: {act: {script: rsf}}")
    assert run(workspace, "{subtree: part}").ticks(3) == "rsf"


@shows("subtree-names")
def test_names_of_the_caller_mean_nothing_in_it(workspace: Workspace) -> None:
    write(workspace, "part", "subtree: true\nroot: {condition: n == 1}")
    with pytest.raises(UserError, match="unknown name 'n'"):
        load(workspace, f"blackboard: {{n: 1}}\nroot: {{sequence: [{COUNT}, {{subtree: part}}]}}")
    write(workspace, "part", "subtree: true\nparameters: {n: 2}\nroot: {condition: n == 1}")
    given = f"blackboard: {{n: 0}}\nroot: {{sequence: [{COUNT}, {{subtree: {{tree: part, n: $n}}}}]}}"
    assert Run(load(workspace, given)).ticks(1) == "s"


@shows("subtree-outputs", "subtree-keys")
def test_outputs_and_own_keys(workspace: Workspace) -> None:
    write(workspace, "counted", COUNTED)
    both = "sequence: [{subtree: {tree: counted, total: n}}, {condition: n == 1 and count == 10}]"
    text = f"blackboard: {{count: 10}}\nroot: {{repeat: {{times: 3, {both}}}}}"
    assert Run(load(workspace, text)).ticks(3) == "rrs"


@shows("subtree-twice")
def test_two_uses_share_nothing(workspace: Workspace) -> None:
    write(workspace, "counted", COUNTED)
    text = "root: {sequence: [{subtree: {tree: counted, limit: 1}}, {subtree: {tree: counted, limit: 1}}]}"
    assert Run(load(workspace, text)).ticks(1) == "s"


@shows("subtree-node")
def test_a_node_keeps_the_callers_names(workspace: Workspace) -> None:
    write(
        workspace,
        "tried",
        "subtree: true\nparameters: {what: s, action: {type: node}}\n"
        "root: {sequence: [{act: {script: $what}}, $action]}",
    )
    text = "parameters: {what: rf}\nroot: {subtree: {tree: tried, action: {act: {script: $what}}}}"
    assert Run(load(workspace, text)).ticks(2) == "rf"


@shows("subtree-checks")
def test_the_checks_look_through_it(workspace: Workspace) -> None:
    write(workspace, "touch", "subtree: true\nparameters: {it: {type: percept}}\nroot: {reach: {target: $it}}")
    use = "subtree: {tree: touch, it: ball}"
    load(workspace, f"root: {{emergency_stop: {{watchdog: {{percept: ball, max_age: 1, {use}}}}}}}")
    with pytest.raises(UserError) as refused:
        load(workspace, f"root: {{{use}}}")
    assert [problem.code for problem in refused.value.problems] == ["outside-emergency-stop", "outside-watchdog"]


@shows("subtree-cycle")
def test_a_tree_cannot_contain_itself(workspace: Workspace, tmp_path: Path) -> None:
    write(workspace, "first", "root: {subtree: second}")
    write(workspace, "second", "root: {subtree: first}")
    with pytest.raises(UserError, match="'first' would contain itself"):
        load(workspace, "root: {subtree: first}")
