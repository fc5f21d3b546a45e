"""What ``--set`` and ``--perception`` give."""

from __future__ import annotations

from typing import Any

from humanoid_bt.core.errors import Place, UserError
from humanoid_bt.core.items import Item, item_of
from humanoid_bt.files import document


def overrides(texts: list[str]) -> dict[str, str]:
    """Return the values that ``--set NAME=VALUE`` gives, by name.

    Raises:
        UserError: one is not of this form, or a name is given twice.
    """
    values: dict[str, str] = {}
    for text in texts:
        name, value = pair(text)
        if name in values:
            raise UserError(f"--set {text!r}: {name!r} was set to {values[name]!r} before", hint="give each name once")
        values[name] = value
    return values


def pair(text: str) -> tuple[str, str]:
    """Return name and value of one ``--set NAME=VALUE``.

    Raises:
        UserError: it is not of this form.
    """
    name, equals, value = text.partition("=")
    if not equals or not name.strip():
        raise UserError(f"--set {text!r} is not NAME=VALUE", hint="example: --set reach_distance=0.45")
    return name.strip(), value


def sources(texts: list[str]) -> Any:
    """Return the item of the percept sources that ``--perception`` names, None if there are none.

    Raises:
        UserError: a text is no YAML.
    """
    given = [_typed(f"--perception {text}", text) for text in texts]
    return Item(given, given[0].place) if len(given) > 1 else next(iter(given), None)


def _typed(option: str, text: str) -> Item:
    """Return what a text says, all of it in the place of the option as it was typed."""
    return item_of(document.parse(text, option).plain(), Place(option))
