"""The public API: every name of ``humanoid_bt``, and what sessions and reports offer."""

from __future__ import annotations

import ast
import inspect
import itertools
from typing import Any, cast

import humanoid_bt
from humanoid_bt.core import messages, params
from humanoid_bt.session.debugging import Debugging
from humanoid_bt.session.report import Report
from humanoid_bt.session.session import Session
from parts.markdown import members, summary, table


def api() -> str:
    """Return the tables of the public API, in the groups of ``humanoid_bt.__all__``."""
    source = inspect.getsource(humanoid_bt).partition("__all__ = [")[2].partition("\n]")[0]
    groups: dict[str, list[tuple[str, str]]] = {}
    for line in source.splitlines()[1:]:
        text = line.strip()
        if text.startswith("# "):
            rows = groups.setdefault(text[2:], [])
        else:
            rows.append(_public(text.strip('",')))
    return "\n\n".join(f"### {title}\n\n{table(('name', 'what it is'), rows)}" for title, rows in groups.items())


def session() -> str:
    """Return what a session offers."""
    return members(Session)


def debugging() -> str:
    """Return what a session offers to those who debug its tree."""
    return members(Debugging)


def report() -> str:
    """Return what a report holds besides its fields."""
    return members(Report)


def _public(name: str) -> tuple[str, str]:
    """Return a public name as it is called, and its first line of documentation."""
    thing = getattr(humanoid_bt, name)
    if inspect.isclass(thing) or inspect.ismodule(thing) or inspect.isfunction(thing):
        call = f"{name}({_arguments(thing)})" if inspect.isfunction(thing) else name
        return f"`{call}`", summary(inspect.getdoc(thing) or "")
    return f"`{name}`", summary(_doc_below(name))


def _arguments(function: Any) -> str:
    """Return the arguments that matter of a function: those that must be given, and that there are others."""
    arguments = inspect.signature(function).parameters.values()
    needed = [str(a.replace(annotation=a.empty)) for a in arguments if a.default is a.empty and a.kind != a.VAR_KEYWORD]
    return ", ".join([*needed, *(["..."] if len(needed) < len(arguments) else [])])


def _doc_below(name: str) -> str:
    """Return the text below the assignment of a constant."""
    for module in (messages, params):
        body = ast.parse(inspect.getsource(module)).body
        for node, after in itertools.pairwise(body):
            targets = getattr(node, "targets", [getattr(node, "target", None)])
            if any(getattr(target, "id", "") == name for target in targets):
                return str(ast.literal_eval(cast(ast.Expr, after).value))
    raise LookupError(name)
