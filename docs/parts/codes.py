"""What checks find: the codes of findings."""

from __future__ import annotations

from humanoid_bt.checking.codes import ALLOWABLE, CODES
from parts.markdown import table


def codes() -> str:
    """Return the table of what checks find."""
    rows = []
    for code in CODES.values():
        severity = f"{code.severity}, can be allowed" if code.name in ALLOWABLE else code.severity
        rows.append((f"`{code.name}`", severity, code.meaning.replace("$name", "`$name`")))
    return table(("code", "severity", "meaning"), rows)


def code_examples() -> str:
    """Return the table of the codes whose example fits into it."""
    rows = [
        (f"`{code.name}`", f"`{code.wrong}`", f"`{code.right}`")
        for code in CODES.values()
        if code.wrong and "\n" not in code.wrong + code.right
    ]
    return table(("code", "wrong", "right"), rows)
