"""What was run, in words: versions, parameters, the tree file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import rerun as rr

from humanoid_bt.record.columns import send
from humanoid_bt.record.tree_view import TreeView, printable

RUN = "documents/run"
TREE = "documents/tree"


def log_info(stream: Any, info: Mapping[str, str]) -> None:
    """Write the run's information.

    Args:
        stream: the rerun recording stream.
        info: heading -> text; texts of several lines are set as blocks.
    """
    short = {key: text for key, text in info.items() if "\n" not in text}
    rows = "\n".join(f"| {_cell(key)} | {_cell(text)} |" for key, text in short.items())
    blocks = [f"## {key}\n\n```yaml\n{text}\n```" for key, text in info.items() if key not in short]
    text = printable("\n\n".join([f"| | |\n|---|---|\n{rows}", *blocks]))
    document = rr.TextDocument(text, media_type=rr.MediaType.MARKDOWN)
    stream.log(RUN, document, static=True)


def send_tree_file(stream: Any, time: float, tree: TreeView) -> None:
    """Write the tree file as it is from a time on.

    Args:
        stream: the rerun recording stream.
        time: engine time [s].
        tree: its file and source.
    """
    text = printable(f"## {tree.file}\n\n```yaml\n{tree.source}\n```")
    send(stream, TREE, [time], rr.TextDocument.columns(text=[text], media_type=[rr.MediaType.MARKDOWN]))


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
