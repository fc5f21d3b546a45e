"""YAML files with the place of every value, so that a mistake can be shown where it is.

Only what ``yaml.safe_load`` would give: mappings, lists, strings, numbers, booleans and null.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from humanoid_bt.errors import Place, UserError, relative


@dataclass(frozen=True)
class Item:
    """A value of a YAML file and its place.

    Attributes:
        value: a scalar, a ``list[Item]`` or a ``dict[str, Item]``.
        place: where the value begins.
        key_places: for a mapping, where each key stands.
    """

    value: Any
    place: Place
    key_places: dict[str, Place] = field(default_factory=dict)

    def plain(self) -> Any:
        """Return the value as ``yaml.safe_load`` would give it."""
        if isinstance(self.value, dict):
            return {key: item.plain() for key, item in self.value.items()}
        if isinstance(self.value, list):
            return [item.plain() for item in self.value]
        return self.value

    @property
    def kind(self) -> str:
        """The value's kind in words, for messages."""
        names = {dict: "a mapping", list: "a list", str: "text", bool: "a boolean", type(None): "nothing"}
        return names.get(type(self.value), "a number")


def load(path: Path) -> Item:
    """Read a YAML file.

    Raises:
        UserError: the file cannot be read, is no valid YAML, or has duplicate keys.
    """
    name = relative(path)
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise UserError("the file is not UTF-8 text", Place(name)) from error
    except OSError as error:
        raise UserError(f"cannot be read: {error.strerror}", Place(name)) from error
    return parse(text, name)


def parse(text: str, name: str) -> Item:
    """Parse YAML text; ``name`` stands in messages for the file.

    Raises:
        UserError: as :func:`load`.
    """
    loader = yaml.SafeLoader(text)
    try:
        node = loader.get_single_node()
        if node is None:
            raise UserError("the file is empty", Place(name, 1, 1))
        return _item(loader, node, name, ())
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = Place(name, mark.line + 1, mark.column + 1) if mark else Place(name)
        what = " ".join(part for part in (error.context, error.problem) if part)
        raise UserError(f"not valid YAML: {what}", place) from error
    except yaml.YAMLError as error:
        raise UserError(f"not valid YAML: {str(error).splitlines()[0]}", Place(name)) from error
    except RecursionError as error:
        raise UserError("nested too deeply", Place(name)) from error
    finally:
        loader.dispose()


def _item(loader: yaml.SafeLoader, node: yaml.Node, name: str, above: tuple[int, ...]) -> Item:
    place = Place(name, node.start_mark.line + 1, node.start_mark.column + 1)
    if id(node) in above:
        raise UserError("an alias refers to a value that contains it", place)
    if isinstance(node, yaml.ScalarNode):
        try:
            return Item(loader.construct_object(node), place)
        except (ValueError, OverflowError) as error:
            raise UserError(f"{node.value!r} is not a valid value: {error}", place) from error
    above = (*above, id(node))
    if isinstance(node, yaml.SequenceNode):
        return Item([_item(loader, child, name, above) for child in node.value], place)
    keys: dict[str, Place] = {}
    for key_node, _ in node.value:
        key_place = Place(name, key_node.start_mark.line + 1, key_node.start_mark.column + 1)
        if not isinstance(key_node, yaml.ScalarNode):
            raise UserError("a key must be text", key_place)
        if key_node.value in keys:
            raise UserError(
                f"the key {key_node.value!r} stands twice in one mapping", key_place, f"first at {keys[key_node.value]}"
            )
        keys[key_node.value] = key_place
    loader.flatten_mapping(node)  # merge keys (<<) come first, so a mapping's own keys win
    values: dict[str, Item] = {}
    for key_node, value_node in node.value:
        values[key_node.value] = _item(loader, value_node, name, above)
        keys.setdefault(key_node.value, place)
    return Item(values, place, keys)
