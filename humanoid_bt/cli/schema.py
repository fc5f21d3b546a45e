"""``humanoid-bt schema``: a JSON Schema of tree files for editors."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.session.report import ExitCode
from humanoid_bt.tree.nodes.registry import Registry
from humanoid_bt.tree.source.load import subtree_types
from humanoid_bt.tree.source.schema import tree_schema


def schema(arguments: argparse.Namespace) -> int:
    """Print the schema, or write it to a file."""
    text, number = schema_text(arguments.workspace)
    if arguments.output is None:
        print(text)
        return ExitCode.SUCCESS
    try:
        arguments.output.parent.mkdir(parents=True, exist_ok=True)
        arguments.output.write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise UserError(f"the schema cannot be written to {str(arguments.output)!r}: {error.strerror}") from error
    print(f"{arguments.output}: {number} node types")
    return ExitCode.SUCCESS


def schema_text(folder: Path | None) -> tuple[str, int]:
    """Return the schema of a workspace as JSON, and how many node types it has."""
    workspace = Workspace(folder)
    registry = Registry.of(workspace)
    return json.dumps(tree_schema(registry, subtree_types(workspace, registry)), indent=1), len(registry)
