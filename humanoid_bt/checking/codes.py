"""The codes of all findings: what each means, whether it keeps a file from being used, an example.

A code is a stable name for one kind of mistake: people allow warnings by it, programs tell findings apart by it. They
are listed in ``codes.toml``.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path

from humanoid_bt.core.errors import Severity, UserError, nearest


@dataclass(frozen=True)
class Code:
    """One kind of finding.

    Attributes:
        name: the code.
        meaning: one sentence.
        severity: an error keeps a file from being used; a warning does not.
        wrong: a part of a file that has the mistake, "" where no short one shows it.
        right: the same without it.
        allowable: of a warning: whether a comment in the file can allow it.
    """

    name: str
    meaning: str
    severity: Severity = "error"
    wrong: str = ""
    right: str = ""
    allowable: bool = True


def _read() -> dict[str, Code]:
    text = Path(__file__).with_name("codes.toml").read_text(encoding="utf-8")
    return {name: Code(name, **values) for name, values in tomllib.loads(text).items()}


CODES: dict[str, Code] = _read()
"""Every code by its name."""

ALLOWABLE = frozenset(code.name for code in CODES.values() if code.severity == "warning" and code.allowable)
"""The codes that a comment can allow: warnings, but for those about such comments."""


def find(name: str) -> Code:
    """Return a code.

    Raises:
        UserError: there is none of this name.
    """
    if name not in CODES:
        everything = "all: humanoid-bt check --explain"
        hint = nearest(name, CODES, everything.removeprefix("all: "))
        raise UserError(f"no code {name!r}", hint=hint if everything in hint else f"{hint} {everything}")
    return CODES[name]
