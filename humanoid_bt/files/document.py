"""YAML files with the place of every value, so that a mistake can be shown where it is.

Only what ``yaml.safe_load`` would give: mappings with text keys, lists, text, numbers, booleans and null. A file
cannot exhaust memory or the stack: its size after expanding aliases and its depth are bounded.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import yaml

from humanoid_bt.core.errors import Place, Problem, UserError, relative
from humanoid_bt.core.items import Item
from humanoid_bt.files.reading import read_text
from humanoid_bt.files.slips import slip

MAX_ITEMS = 100_000
"""Most values in one file, aliases expanded."""

MAX_DEPTH = 100
"""Deepest nesting of mappings and lists in one file."""

_WHOLE, _FRACTION = re.compile(r"[-+]?\d+"), re.compile(r"\d+( *[A-Za-z/]+)?")
_TAG = "tag:yaml.org,2002:"
_CONSTRUCTED = {_TAG + name for name in ("null", "bool", "int", "float")}
_TEXT = {_TAG + name for name in ("str", "timestamp", "value", "merge")}  # a date or a lone "=" is text here


def load(path: Path) -> Item:
    """Read a YAML file.

    Raises:
        UserError: the file cannot be read, is no valid YAML, has duplicate keys, or is too large or too deep.
    """
    return parse(read_text(path), relative(path))


def parse(text: str, name: str, problems: list[Problem] | None = None) -> Item:
    """Parse YAML text; ``name`` stands in messages for the file.

    Args:
        text: the YAML text.
        name: the file's name.
        problems: takes the mistakes after which reading can go on (duplicate keys); raised if None.

    Raises:
        UserError: as :func:`load`.
    """
    found: list[Problem] = [] if problems is None else problems
    try:
        item = _Reader(text, name, found).document()
    except yaml.reader.ReaderError as error:
        before = text[: error.position]
        place = Place(name, before.count("\n") + 1, len(before) - before.rfind("\n"))
        code = ord(text[error.position])
        raise UserError(f"not valid YAML: the character U+{code:04X} is not allowed", place, code="syntax") from error
    except yaml.MarkedYAMLError as error:
        found_slip = slip(text, error)
        place = Place(name, found_slip.line, found_slip.column)
        raise UserError(found_slip.message, place, found_slip.hint, "syntax") from error
    except RecursionError as error:
        raise UserError("nested too deeply", Place(name, 1, 1), code="too-large") from error
    if found and problems is None:
        raise UserError(found)
    return item


def as_line(value: Any) -> str:
    """Return a value as YAML on one line; text with characters that nobody sees in quotes, with these written out."""
    plain = str(value).isprintable() and "\\" not in str(value)
    style: dict[str, Any] = {"allow_unicode": True} if plain else {"default_style": '"'}
    text: str = yaml.safe_dump(value, sort_keys=False, width=math.inf, default_flow_style=True, **style)
    return text.removesuffix("...\n").strip()


def _place(name: str, mark: yaml.Mark) -> Place:
    return Place(name, mark.line + 1, mark.column + 1)


class _Loader(yaml.SafeLoader):
    """A safe loader that refuses deep nesting while composing, which recurses."""

    def __init__(self, text: str, name: str) -> None:
        super().__init__(text)
        self.file = name
        self.depth = 0

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            place = _place(self.file, parent.start_mark) if parent else Place(self.file)
            raise UserError(f"nested deeper than {MAX_DEPTH} levels", place, code="too-large")
        node = super().compose_node(parent, index)
        self.depth -= 1
        return node


class _Reader:
    """Turns one document's nodes into items."""

    def __init__(self, text: str, name: str, problems: list[Problem]) -> None:
        self.loader: Any = _Loader(text, name)
        self.name = name
        self.problems = problems
        self.count = 0
        self.merged: dict[int, dict[str, tuple[Place, yaml.Node]]] = {}

    def document(self) -> Item:
        try:
            node = self.root()
            if node is None:
                raise UserError("the file is empty", Place(self.name, 1, 1), code="syntax")
            return self.item(node, ())
        finally:
            self.loader.dispose()

    def root(self) -> yaml.Node | None:
        try:
            node: yaml.Node | None = self.loader.get_single_node()
        except UserError:
            raise
        except (ValueError, OverflowError) as error:  # from the scanner: "\UFFFFFFFF", a version of 5000 digits
            place = _place(self.name, self.loader.get_mark())
            raise UserError("not valid YAML: no character or version has this number", place, code="syntax") from error
        return node

    def item(self, node: yaml.Node, above: tuple[int, ...]) -> Item:
        place = _place(self.name, node.start_mark)
        self.grow(1, place)
        if isinstance(node, yaml.ScalarNode):
            on_one_line = node.start_mark.line == node.end_mark.line
            return Item(self.scalar(node, place), place, text_at=int(bool(node.style)) if on_one_line else None)
        if id(node) in above:
            raise UserError("an alias refers to a value that contains it", place, code="syntax")
        above = (*above, id(node))
        if len(above) > MAX_DEPTH:
            raise UserError(f"nested deeper than {MAX_DEPTH} levels", place, code="too-large")
        if isinstance(node, yaml.SequenceNode) and node.tag == _TAG + "seq":
            return Item([self.item(child, above) for child in node.value], place)
        if not isinstance(node, yaml.MappingNode) or node.tag != _TAG + "map":
            raise self.unknown_tag(node, place)
        pairs = self.pairs(node, ())
        values = {key: self.item(value, above) for key, (_, value) in pairs.items()}
        return Item(values, place, {key: key_place for key, (key_place, _) in pairs.items()})

    def grow(self, values: int, place: Place) -> None:
        self.count += values
        if self.count > MAX_ITEMS:
            raise UserError(f"more than {MAX_ITEMS} values, aliases expanded", place, code="too-large")

    def scalar(self, node: yaml.ScalarNode, place: Place) -> Any:
        if node.tag in _TEXT:
            return self.text(node, place)
        if node.tag not in _CONSTRUCTED:
            raise self.unknown_tag(node, place)
        try:
            return self.loader.construct_object(node)
        except (ValueError, LookupError, ArithmeticError, AttributeError, TypeError) as error:
            kind = node.tag.removeprefix(_TAG)
            raise UserError(f"{node.value[:40]!r} is not a valid {kind}", place, code="wrong-type") from error

    def text(self, node: yaml.ScalarNode, place: Place) -> str:
        try:
            node.value.encode("utf-8")
        except UnicodeEncodeError as error:  # half of a pair, written as "\uD800"
            raise UserError(f"{node.value[:40]!a} holds half a character", place, code="syntax") from error
        return str(node.value)

    def unknown_tag(self, node: yaml.Node, place: Place) -> UserError:
        message = f"the tag {node.tag.replace(_TAG, '!!')!r} is not supported"
        hint = "text that begins with ! stands in quotes; in an expression write 'not' instead"
        return UserError(message, place, hint, code="syntax")

    def pairs(self, node: yaml.MappingNode, above: tuple[int, ...]) -> dict[str, tuple[Place, yaml.Node]]:
        """Return a mapping's keys with their places and values; its own keys win over merged ones (``<<``)."""
        if id(node) in self.merged:
            return self.merged[id(node)]
        above = (*above, id(node))
        own: dict[str, tuple[Place, yaml.Node]] = {}
        inherited: dict[str, tuple[Place, yaml.Node]] = {}
        for key_node, value_node in self.with_points(node.value):
            place = _place(self.name, key_node.start_mark)
            if not isinstance(key_node, yaml.ScalarNode):
                hint = "one pair of brackets too many? {key: value} is a mapping, and $name a parameter"
                raise UserError("a key must be text", place, hint, code="syntax")
            key = self.text(key_node, place)
            if key_node.tag == _TAG + "merge":
                for source in self.sources(value_node, above):
                    merged = self.pairs(source, above)
                    self.grow(len(merged), place)
                    for name, pair in merged.items():
                        inherited.setdefault(name, pair)
            elif key in own:
                hint = f"remove one; the first is at {own[key][0]}"
                message = f"the key {key!r} stands twice in one mapping"
                self.problems.append(Problem(message, place, hint, code="duplicate-key"))
            else:
                own[key] = (place, value_node)
        self.merged[id(node)] = inherited | own
        return self.merged[id(node)]

    def with_points(self, pairs: list[tuple[yaml.Node, yaml.Node]]) -> list[tuple[yaml.Node, yaml.Node]]:
        """Return keys with their values, those that a decimal comma tore apart (``{a: 0,5 s}``) in one again."""
        whole: list[tuple[yaml.Node, yaml.Node]] = []
        for key, value in pairs:
            if whole and _is_fraction(whole[-1][1], key, value):
                name, number = whole.pop()
                text, place = f"{number.value}.{key.value}", _place(self.name, number.start_mark)
                self.problems.append(Problem("a number with a comma", place, f"write {text}, with a point", "syntax"))
                tag = _TAG + ("float" if key.value.isdigit() else "str")
                whole.append((name, yaml.ScalarNode(tag, text, number.start_mark, key.end_mark)))
            else:
                whole.append((key, value))
        return whole

    def sources(self, node: yaml.Node, above: tuple[int, ...]) -> list[yaml.MappingNode]:
        nodes = node.value if isinstance(node, yaml.SequenceNode) else [node]
        for source in nodes:
            place = _place(self.name, source.start_mark)
            if not isinstance(source, yaml.MappingNode):
                raise UserError("only mappings can be merged with <<", place, code="syntax")
            if id(source) in above:
                raise UserError("an alias refers to a value that contains it", place, code="syntax")
        return list(nodes)


def _is_fraction(number: yaml.Node, key: yaml.Node, value: yaml.Node) -> bool:
    """Return whether a key without a value is what stands behind the comma of a number."""
    if not all(isinstance(node, yaml.ScalarNode) and node.style is None for node in (number, key, value)):
        return False
    near = key.start_mark.index == number.end_mark.index + 1
    return near and not value.value and bool(_WHOLE.fullmatch(number.value) and _FRACTION.fullmatch(key.value))
