"""``humanoid-bt schema``: JSON Schemas of tree files and of scenario files, for editors."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.session.report import ExitCode
from humanoid_bt.testing.scenario_schema import scenario_schema
from humanoid_bt.tree.nodes.registry import Registry
from humanoid_bt.tree.source.load import subtree_types
from humanoid_bt.tree.source.schema import tree_schema


def schema(arguments: argparse.Namespace) -> int:
    """Print the schema, or write it to a file."""
    text, told = schema_text(arguments.workspace, arguments.of)
    if arguments.output is None:
        print(text)
        return ExitCode.SUCCESS
    try:
        arguments.output.parent.mkdir(parents=True, exist_ok=True)
        arguments.output.write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise UserError(f"the schema cannot be written to {str(arguments.output)!r}: {error.strerror}") from error
    print(f"{arguments.output}: {told}")
    return ExitCode.SUCCESS


def schema_text(folder: Path | None, of: str) -> tuple[str, str]:
    """Return a schema of a workspace as JSON, and what it is of: of its trees, or of its "scenarios"."""
    workspace = Workspace(folder)
    if of == "scenarios":
        return json.dumps(scenario_schema(workspace), indent=1), "scenarios"
    registry = Registry.of(workspace)
    made = tree_schema(registry, subtree_types(workspace, registry))
    return json.dumps(made, indent=1), f"{len(registry)} node types"
