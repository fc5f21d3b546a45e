"""What was run, in words: versions, parameters, the tree file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import rerun as rr

from humanoid_bt.record.tree_view import TreeView, printable

RUN = "documents/run"
TREE = "documents/tree"


def log_documents(stream: Any, tree: TreeView, info: Mapping[str, str]) -> None:
    """Write the run's information and the tree file.

    Args:
        stream: the rerun recording stream.
        tree: its file and source.
        info: heading -> text; texts of several lines are set as blocks.
    """
    short = {key: text for key, text in info.items() if "\n" not in text}
    rows = "\n".join(f"| {_cell(key)} | {_cell(text)} |" for key, text in short.items())
    blocks = [f"## {key}\n\n```yaml\n{text}\n```" for key, text in info.items() if key not in short]
    stream.log(RUN, _document("\n\n".join([f"| | |\n|---|---|\n{rows}", *blocks])), static=True)
    stream.log(TREE, _document(f"## {tree.file}\n\n```yaml\n{tree.source}\n```"), static=True)


def _document(text: str) -> Any:
    return rr.TextDocument(printable(text), media_type=rr.MediaType.MARKDOWN)


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
