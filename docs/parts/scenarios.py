"""Scenario files: their keys, and what can be claimed of a run."""

from __future__ import annotations

from humanoid_bt.core.params import Param, params_of
from humanoid_bt.testing.claim import VERBS, WORDS
from humanoid_bt.testing.scenario import Scenario
from parts.markdown import table
from parts.parameters import Row, parameter_row, parameter_table

_ELSEWHERE = {
    "seeds": ("seeds", "`0`"),
    "parameters": ("mapping of names to values", ""),
    "conditions": ("[conditions](testing.md#conditions)", ""),
    "script": ("list of [events](testing.md#faults)", ""),
    "replace": ("mapping of nodes to [stand-ins](testing.md#stand-ins)", ""),
    "expect": ("list of [expectations](#what-can-be-expected)", "required"),
}
"""Type and default of the keys that are explained elsewhere."""


def scenario_keys() -> str:
    """Return the keys of a scenario file."""
    return parameter_table("key", map(_row, params_of(Scenario).values()))


def _row(spec: Param) -> Row:
    if spec.name in _ELSEWHERE:
        kind, default = _ELSEWHERE[spec.name]
        return f"`{spec.name}`", kind, default, spec.doc
    return parameter_row(spec)


def run_words() -> str:
    """Return what can be asked of a run, beside what its tree can ask."""
    rows = [(f"`{name}`", str(word.type), word.doc) for name, word in WORDS.items()]
    return table(("word", "is", "meaning"), rows)


def node_verbs() -> str:
    """Return what can be asked of nodes."""
    return table(("claim", "meaning"), [(f"`reach {verb}`", doc) for verb, (doc, _) in VERBS.items()])
