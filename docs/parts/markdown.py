"""Markdown: tables, and what docstrings say."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable, Sequence


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table."""
    lines = [head, tuple("---" for _ in head), *rows]
    return "\n".join(f"| {' | '.join(cells)} |".replace("  ", " ") for cells in lines)


def code(names: Iterable[str]) -> str:
    """Return names as code, between commas."""
    return ", ".join(f"`{name}`" for name in names)


def docstring(cls: type) -> str:
    """Return what a class says of itself, and not what its base says."""
    return inspect.cleandoc(vars(cls)["__doc__"] or "").replace("``", "`")


def summary(doc: str) -> str:
    """Return the first paragraph of a docstring in one line, its references as code."""
    first = doc.partition("\n\n")[0]
    return re.sub(r":\w+:`~?(?:[\w.]*\.)?(\w+)`", r"`\1`", first).replace("``", "`").replace("\n", " ")


def attributes(cls: type) -> str:
    """Return a table of the attributes that a class's docstring describes."""
    text = inspect.cleandoc(cls.__doc__ or "").partition("Attributes:\n")[2]
    rows: list[tuple[str, str]] = []
    for line in text.splitlines():
        name, colon, meaning = line.strip().partition(": ")
        if line.startswith("    ") and not line.startswith("     ") and colon:
            rows.append((code(name.split(", ")), summary(meaning)))
        elif rows:
            rows[-1] = (rows[-1][0], f"{rows[-1][1]} {line.strip()}")
    return table(("attribute", "meaning"), rows)


def members(cls: type, hidden: tuple[str, ...] = ()) -> str:
    """Return a table of the public methods and properties of a class: how to call them, what they do."""
    rows = []
    for name, member in vars(cls).items():
        if name.startswith("_") or name in hidden or not (inspect.isfunction(member) or isinstance(member, property)):
            continue
        call = name
        if inspect.isfunction(member):
            arguments = [
                argument.replace(annotation=inspect.Parameter.empty)
                for argument in list(inspect.signature(member).parameters.values())[1:]
            ]
            call += str(inspect.Signature(arguments))
        rows.append((f"`{call}`", summary(inspect.getdoc(member) or "")))
    return table(("member", "meaning"), rows)
