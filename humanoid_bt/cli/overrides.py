"""What ``--set`` gives."""

from __future__ import annotations

from humanoid_bt.core.errors import UserError


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
