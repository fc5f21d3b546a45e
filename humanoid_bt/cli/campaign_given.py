"""The campaign that a command line asks for."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from humanoid_bt.campaign.file import FOLDER, CampaignFile, Names, named_after
from humanoid_bt.campaign.variation import BETWEEN
from humanoid_bt.cli.overrides import pair, sources
from humanoid_bt.core.errors import Place, UserError, nearest, relative
from humanoid_bt.core.items import Item, item_of
from humanoid_bt.core.params import Param
from humanoid_bt.core.reading import read
from humanoid_bt.files import document
from humanoid_bt.files.reading import is_file
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.source.file import read_file
from humanoid_bt.tree.source.given import TEXTS, written_item

_ANY = Param("", Any)


def workspace_given(arguments: argparse.Namespace) -> Workspace:
    """Return where names are looked up: where was asked for, else a file's own workspace, else the current folder."""
    path = Path(arguments.what[0])
    if arguments.workspace is None and is_file(path) and path.resolve().parent.name == FOLDER:
        return Workspace(path.resolve().parent.parent)
    return Workspace.of_argument(arguments.what[0], arguments.workspace)


def is_named(what: str, workspace: Workspace) -> bool:
    """Return whether a campaign or a tree has a name."""
    return what in workspace.campaigns() or what in workspace.trees()


def campaign_given(arguments: argparse.Namespace, workspace: Workspace) -> tuple[CampaignFile, list[Any]]:
    """Return the campaign that is asked for, and its script as it is written.

    Raises:
        UserError: with everything that is wrong with it.
    """
    item = _base(arguments.what[0], workspace)
    places = dict(item.key_places)
    values: dict[str, Item] = dict(item.value)
    for name, value in _given(arguments, values, workspace):
        values[name] = value
        places[name] = value.place
    campaign: CampaignFile = read(CampaignFile, Item(values, item.place, places), "the campaign")
    script = values.get("script")
    return campaign, script.plain() if script is not None else []


def _base(what: str, workspace: Workspace) -> Item:
    """Return the campaign file that is named, or for a tree a campaign that has nothing but its name."""
    known = workspace.campaigns()
    trees = workspace.trees()
    if what in known and what in trees:
        files = " or ".join(relative(path) for path in (known[what], trees[what]))
        raise UserError(f"there is a campaign and a tree named {what!r}", hint=f"give the file that is meant: {files}")
    path = known.get(what, Path(what))
    if (what in known or is_file(path)) and (item := document.load(path)) and not _is_tree(item):
        if not isinstance(item.value, dict):
            raise UserError(f"a campaign must be a mapping, not {item.kind}", item.place, "format: 1 ... tree: ...")
        return item
    if what not in trees and not is_file(path):
        raise UserError(f"no tree and no campaign named {what!r}", hint=nearest(what, [*trees, *known]))
    return item_of({"format": 1, "name": named_after(Path(what)), "tree": what}, Place(what))


def _is_tree(item: Item) -> bool:
    return isinstance(item.value, dict) and "root" in item.value


def _given(
    arguments: argparse.Namespace, known: Mapping[str, Item], workspace: Workspace
) -> Iterator[tuple[str, Item]]:
    """Yield what the command line gives, by the key of a campaign file that says the same."""
    for key in ("scene", "robot", "seeds", "duration", "time_limit", "recordings", "dry", "fail_on"):
        if (value := getattr(arguments, key)) is not None:
            yield key, item_of(value, Place(f"--{key.replace('_', '-')}"))
    if (named := sources(arguments.perception)) is not None:
        yield "perception", named
    if arguments.overrides:
        pairs = [(Place(f"--set {text}"), *pair(text)) for text in arguments.overrides]
        yield "parameters", _joined(known.get("parameters"), pairs, _declared(known.get("tree"), workspace))
    if arguments.conditions:
        pairs = [(Place(f"--condition {text}"), *_pair(text, "--condition")) for text in arguments.conditions]
        yield "conditions", _joined(known.get("conditions"), pairs, {})
    if arguments.pushes:
        pushes = [_push(text) for text in arguments.pushes]
        yield "pushes", Item(pushes, Place("--push"))
    if arguments.require:
        before = known["require"].value if "require" in known and isinstance(known["require"].value, list) else []
        yield (
            "require",
            Item([*before, *(Item(text, Place("--require")) for text in arguments.require)], Place("--require")),
        )


def _declared(tree: Item | None, workspace: Workspace) -> Mapping[str, Param]:
    """Return the parameters of the first tree; none if it cannot be read, which is told later."""
    try:
        names = Names.from_item(tree or Item(None, Place("tree")), "tree").items
        declared = read_file(workspace.find_tree(names[0].value), []).parameters
    except UserError:
        return {}
    return {name: declaration.spec for name, declaration in declared.items()}


def _joined(before: Item | None, pairs: list[tuple[Place, str, str]], declared: Mapping[str, Param]) -> Item:
    """Return a mapping of names to what options give them, in the place of what a file gives them.

    Args:
        before: what the file gives.
        pairs: each option, its name and its value.
        declared: what is known of the values; one that is text stays as it is.
    """
    found: dict[str, list[Item]] = {}
    for place, name, text in pairs:
        found.setdefault(name, []).append(written_item(declared.get(name, _ANY), text, place))
    values = dict(before.value) if before is not None and isinstance(before.value, dict) else {}
    places = dict(before.key_places) if before is not None else {}
    for name, items in found.items():
        is_text = declared.get(name, _ANY).type in TEXTS
        if drawn := [item for item in items if not is_text and len(items) > 1 and BETWEEN in str(item.value)]:
            raise UserError(f"{name!r} is drawn, and given other values too", drawn[0].place)
        values[name] = Item(items, items[0].place) if is_text or len(items) > 1 else items[0]
        places[name] = items[0].place
    return Item(values, pairs[0][0], places)


def _push(text: str) -> Item:
    place = Place(f"--push {text}")
    pairs = [_pair(part, "--push") for part in text.split(",")]
    items = {name: written_item(_ANY, value, place) for name, value in pairs}
    return Item(items, place, dict.fromkeys(items, place))


def _pair(text: str, option: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not (equals and name.strip() and value.strip()):
        raise UserError(f"{option} {text!r} is not NAME=VALUE", hint=f"example: {option} {_EXAMPLES[option]}")
    return name.strip(), value.strip()


_EXAMPLES = {
    "--condition": f"friction=0.5{BETWEEN}1.2",
    "--push": f"at=2s,force=20{BETWEEN}80,direction=90deg",
}
