"""What tests of trees can do to a run: faults, conditions, and what they get back."""

from __future__ import annotations

from dataclasses import fields

from humanoid_bt.core.params import params_of
from humanoid_bt.testing.conditions import Conditions
from humanoid_bt.testing.events import FAULTS, Event
from humanoid_bt.testing.substitution import Answer
from humanoid_bt.testing.tree_run import Sample, TreeRun, View
from parts.markdown import attributes, docstring, members, summary, table
from parts.parameters import Row, parameter_row, parameter_table


def faults() -> str:
    """Return every fault with its parameters, the main one first where there is one."""
    parts: list[str] = []
    for name in FAULTS:
        spec = params_of(Event)[name]
        cls = next(arg for arg in spec.type.__args__ if arg is not type(None))
        rows = sorted(params_of(cls).values(), key=lambda own: own.name != cls.main)
        short = f" Short: `{name}: {cls.main.upper()}`." if cls.main else ""
        own = [parameter_row(row) for row in rows] if name != "set" else [_any_name()]
        parts += [f"#### {name}", summary(docstring(cls)) + short, parameter_table("key", own)]
    return "\n\n".join(parts)


def _any_name() -> Row:
    return "*name*", "anything", "required", "Of a key of the blackboard, or `NODE.PARAMETER`: what it becomes."


def conditions() -> str:
    """Return what can be different from the beginning of a run."""
    return parameter_table("key", map(parameter_row, params_of(Conditions).values()))


def answers() -> str:
    """Return what a stand-in can answer."""
    return parameter_table("key", map(parameter_row, params_of(Answer).values()))


def tree_run() -> str:
    """Return what a run on the stage gives back."""
    own = [(f"`{one.name}`", meaning) for one in fields(TreeRun) if (meaning := _said(TreeRun, one.name))]
    return table(("attribute", "meaning"), own) + "\n" + members(TreeRun).partition("| --- | --- |\n")[2]


def view() -> str:
    """Return what a watcher sees after a tick."""
    kept = [line.replace("| `", "| `sample.") for line in attributes(Sample).splitlines()[2:]]
    shown = [line for line in kept if "keys" in line or "results" in line]
    own = members(View, hidden=("move_on",)).splitlines()
    return "\n".join([*own, *attributes(View).splitlines()[2:], *shown])


def _said(cls: type, name: str) -> str:
    row = next((line for line in attributes(cls).splitlines() if line.startswith(f"| `{name}` |")), "")
    return row.split("|")[2].strip() if row else ""
