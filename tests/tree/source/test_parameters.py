from __future__ import annotations

from typing import Any

import pytest

from humanoid_bt.files.workspace import Workspace
from tests.tree.helpers import load
from tests.tree.source.test_load import one

TIMEOUT = "timeout: {duration: $x, act: }"


@pytest.mark.parametrize(
    ("declaration", "use", "override", "expected"),
    [
        ("3", "plain: {count: $x}", None, 3.0),
        ("3", TIMEOUT, "0.5", 0.5),
        ("3", TIMEOUT, "200 ms", 0.2),
        ("0.5 s", TIMEOUT, None, 0.5),
        ("0.5 s", TIMEOUT, "200 ms", 0.2),
        ("0.5 s", TIMEOUT, "0.25", 0.25),
        ("1e-3", TIMEOUT, None, 0.001),
        ("{default: 2, unit: s, doc: How long.}", TIMEOUT, "3 s", 3.0),
        ("{type: number, unit: s}", TIMEOUT, "3", 3.0),
        ("{unit: s}", TIMEOUT, "3", 3.0),
        ("{type: integer, default: 1}", "plain: {count: $x}", "7", 7),
        ("{type: text, default: r}", "act: {script: $x}", "s", "s"),
        ("r", "act: {script: $x}", "f", "f"),
        ("{type: text, default: r}", "act: {script: $x}", "123", "123"),
        ("true", "emergency_stop: {idle: {look_around: $x}}", "false", False),
        ("ball", "watchdog: {percept: $x, max_age: 1, act: }", "cup", "cup"),
        ("r", "act: {name: $x}", "a name", "a name"),
    ],
)
def test_values_and_overrides(
    workspace: Workspace, declaration: str, use: str, override: str | None, expected: Any
) -> None:
    text = f"parameters: {{x: {declaration}}}\nroot: {{{use}}}"
    result = load(workspace, text, **({} if override is None else {"x": override})).parameters["x"]
    assert (result, type(result)) == (expected, type(expected))


def test_a_value_reaches_the_node(workspace: Workspace) -> None:
    tree = load(workspace, f"parameters: {{x: 0.5 s}}\nroot: {{{TIMEOUT}}}", x="2 min")
    assert tree.nodes[0].values == {"duration": 120.0}
    assert vars(tree.root)["duration"] == 120.0


@pytest.mark.parametrize("declared", ["0.3", "{type: number, default: 0.3}", "{type: number, doc: How long.}"])
def test_a_unit_that_is_given_is_written(workspace: Workspace, declared: str) -> None:
    tree = load(workspace, f"parameters: {{x: {declared}}}\nroot: {{{TIMEOUT}}}", x="2 min")
    again = load(workspace, tree.to_yaml())
    assert again.nodes[0].values == tree.nodes[0].values == {"duration": 120.0}


def test_a_parameter_keeps_its_unit_where_a_number_with_an_exponent_is_given(workspace: Workspace) -> None:
    tree = load(workspace, "parameters: {x: 0.3 m}\nroot: {condition: 0 m < x}", x="1e-3")
    assert "x: 1e-3 m\n" in tree.to_yaml()


@pytest.mark.parametrize(
    ("text", "overrides", "message", "hint"),
    [
        ("parameters: {a: 1}\nroot: act", {}, "2:14 the parameter 'a' is not used", "use it as $a"),
        ("parameters: {speed: 1}\nroot: {plain: {count: $sped}}", {}, "unknown parameter or key '$sped'", "'speed'"),
        ("root: {plain: {count: $x}}", {}, "2:23 unknown parameter or key '$x'", "declares no parameters"),
        (
            "parameters: [n: 1]\nroot: {plain: {count: $n}}",
            {"n": "2"},
            "2:13 the parameters must be a mapping",
            "dashes",
        ),
        (
            "parameters: {n: {type: node, default: act}}\nroot: {condition: n or true}",
            {},
            "3:19 in 'n or true': 'n' is a node",
            "as $n",
        ),
        ("parameters: {n: {type: node, default: act}}\nroot: {log: $n}", {}, "3:13 in '$n': 'n' is a node", "as $n"),
        ("root: act", {"x": "1"}, "x=1 the tree has no parameter 'x'", "declares no parameters"),
        ("parameters: {speed: 1}\nroot: {plain: {count: $speed}}", {"sped": "1"}, "sped=1", "'speed'"),
        ("parameters: {n: 1}\nroot: {plain: {count: $n}}", {"n": "two"}, "n=two 'n' must be a number", ""),
        ("parameters: {n: 1}\nroot: {plain: {count: $n}}", {"n": ""}, "n= 'n' must be a number", ""),
        ("parameters: {n: 1}\nroot: {plain: {count: $n}}", {"n": "[1"}, "n=[1 'n' must be a number", ""),
        (
            "parameters: {n: 1}\nroot: {plain: {count: $n}}",
            {"n": "1.5"},
            "n=1.5 'count' must be a whole number, not a number 1.5",
            "$n is used at",
        ),
        (
            "parameters: {n: 1 s}\nroot: {timeout: {duration: $n, act: }}",
            {"n": "2 m"},
            "n=2 m 'n' has the unit 'm'",
            "valid: s, ms, min",
        ),
        (
            "parameters: {n: -1}\nroot: {timeout: {duration: $n, act: }}",
            {},
            "3:28 'duration' must be > 0, not -1.0",
            "$n is declared at",
        ),
        (
            "parameters: {n: 1 m}\nroot: {timeout: {duration: $n, act: }}",
            {},
            "3:28 'duration' is in s, $n in m",
            "$n is declared at",
        ),
        (
            "parameters: {n: 1 m}\nroot: {plain: {count: $n}}",
            {},
            "3:23 'count' is a whole number without a unit, $n in m",
            "$n is declared at",
        ),
        (
            "parameters: {n: 1 m}\nroot: {set_blackboard: {key: k, value: $n}}",
            {},
            "3:40 'value' is anything without a unit, $n in m",
            "$n is declared at",
        ),
        ("parameters: {n: }\nroot: {plain: {count: $n}}", {}, "2:14 the parameter 'n' has no value", "n="),
        ("parameters: {n: {type: number}}\nroot: {plain: {count: $n}}", {}, "2:14 the parameter 'n' has no", "--set"),
        ("parameters: {n: {doc: x}}\nroot: {plain: {count: $n}}", {}, "2:17 the parameter 'n' has neither", "type"),
        ("parameters: {n: {type: nmber}}\nroot: {plain: {count: $n}}", {}, "2:24 'type' cannot be", "'number'"),
        ("parameters: {n: {unit: furlong}}\nroot: {plain: {count: $n}}", {}, "2:24 unknown unit", "valid: Hz"),
        ("parameters: {n: {default: a, unit: m}}\nroot: {act: {script: $n}}", {}, "2:36 the parameter 'n' has a", ""),
        (
            "parameters: {n: {defalt: 1}}\nroot: {plain: {count: $n}}",
            {},
            "2:18 unknown key 'defalt' of the parameter 'n'",
            "'default'",
        ),
        *(
            (
                f"parameters: {{n: {declared}}}\nroot: {{timeout: {{duration: $n, act: }}}}",
                {"n": "50 cm"},
                "n=50 cm 'duration' is in s, $n in m",
                "$n is used at",
            )
            for declared in ("0.3", "{type: number}")
        ),
        (
            "parameters: {n: 3}\nroot: {condition: state.time < n}",
            {"n": "3 m"},
            "3:30 in 'state.time < n': a number in s and a number in m cannot be compared",
            "",
        ),
        ("parameters: [n]\nroot: act", {}, "2:13 the parameters must be a mapping, not a list", "name: default"),
        (
            "parameters: {a: s, n: [1, $a]}\nroot: {for_each: {item: x, items: $n, act: {script: $a}}}",
            {},
            "2:27 '$a' cannot stand here: the parameter 'n' begins with a plain value",
            "$$a",
        ),
        ("parameters: {2n: 1}\nroot: {plain: {count: $2n}}", {}, "2:14 '2n' cannot be a parameter's name", "letters"),
    ],
)
def test_mistakes(workspace: Workspace, text: str, overrides: dict[str, str], message: str, hint: str) -> None:
    found, found_hint = one(workspace, text, **overrides)
    assert message in found
    assert hint in found_hint
