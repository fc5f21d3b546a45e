"""The tables of a recording, from where their columns are declared."""

from __future__ import annotations

from humanoid_bt.review.columns import TABLES
from humanoid_bt.review.recording import Recording
from parts.markdown import members, table


def data_tables() -> str:
    """Return every table with its columns."""
    return "\n\n".join(
        f"### {name}\n\n{spec.meaning}\n\n"
        + table(
            ("column", "unit", "meaning"),
            [(f"`{c.name}`", c.unit or "-", c.meaning.replace("|", r"\|")) for c in spec.columns],
        )
        for name, spec in TABLES.items()
    )


def recording() -> str:
    """Return what a recording offers."""
    return members(Recording)
