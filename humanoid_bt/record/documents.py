"""What was run, in words: versions, parameters, the tree file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import rerun as rr

from humanoid_bt.record.columns import send
from humanoid_bt.record.subject import TreeView
from humanoid_bt.record.tree_view import printable

RUN = "documents/run"
TREE = "documents/tree"


def send_info(stream: Any, time: float, info: Mapping[str, str]) -> None:
    """Write the run's information as it is from a time on.

    Args:
        stream: the rerun recording stream.
        time: engine time [s].
        info: heading -> text; texts of several lines are set as blocks.
    """
    short = {key: text for key, text in info.items() if "\n" not in text}
    rows = "\n".join(f"| {_cell(key)} | {_cell(text)} |" for key, text in short.items())
    blocks = [f"## {key}\n\n```yaml\n{text}\n```" for key, text in info.items() if key not in short]
    _send(stream, RUN, time, "\n\n".join([f"| | |\n|---|---|\n{rows}", *blocks]))


def send_tree_file(stream: Any, time: float, tree: TreeView) -> None:
    """Write the tree file as it is from a time on.

    Args:
        stream: the rerun recording stream.
        time: engine time [s].
        tree: its file and source.
    """
    _send(stream, TREE, time, f"## {tree.file}\n\n```yaml\n{tree.source}\n```")


def _send(stream: Any, path: str, time: float, text: str) -> None:
    document = rr.TextDocument.columns(text=[printable(text)], media_type=[rr.MediaType.MARKDOWN])
    send(stream, path, [time], document, lasting=True)


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
