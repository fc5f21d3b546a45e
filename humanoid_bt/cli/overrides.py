"""What ``--set`` and ``--perception`` give."""

from __future__ import annotations

from typing import Any

from humanoid_bt.core.errors import UserError
from humanoid_bt.files import document


def overrides(texts: list[str]) -> dict[str, str]:
    """Return the values that ``--set NAME=VALUE`` gives, by name.

    Raises:
        UserError: one is not of this form, or a name is given twice.
    """
    values: dict[str, str] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        name = name.strip()
        if not equals or not name:
            raise UserError(f"--set {text!r} is not NAME=VALUE", hint="example: --set reach_distance=0.45")
        if name in values:
            raise UserError(f"--set {text!r}: {name!r} was set to {values[name]!r} before", hint="give each name once")
        values[name] = value
    return values


def sources(texts: list[str]) -> Any:
    """Return the percept sources that ``--perception`` names, in the form of scenes and trees; None if there are none.

    Raises:
        UserError: a text is no YAML.
    """
    given = [document.parse(text, f"--perception {text}").plain() for text in texts]
    return given[0] if len(given) == 1 else given or None
