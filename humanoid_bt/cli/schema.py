"""``humanoid-bt schema``: JSON Schemas of tree files, scenario files and campaign files, for editors."""

from __future__ import annotations

import argparse
import json

from humanoid_bt.campaign.file import CampaignFile
from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.session.report import ExitCode
from humanoid_bt.testing.scenario_schema import file_schema, scenario_schema
from humanoid_bt.tree.nodes.registry import Registry
from humanoid_bt.tree.source.load import subtree_types
from humanoid_bt.tree.source.schema import tree_schema


def schema(arguments: argparse.Namespace) -> int:
    """Print the schema, or write it to a file."""
    text, told = schema_text(Workspace(arguments.workspace), arguments.of)
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


def schema_text(workspace: Workspace, of: str) -> tuple[str, str]:
    """Return a schema as JSON, of a workspace's "trees", "scenarios" or "campaigns", and in words what it is of."""
    if of == "scenarios":
        made, told = scenario_schema(workspace), "scenarios"
    elif of == "campaigns":
        made, told = file_schema(CampaignFile, "A campaign of humanoid-bt", workspace), "campaigns"
    else:
        registry = Registry.of(workspace)
        made, told = tree_schema(registry, subtree_types(workspace, registry)), f"{len(registry)} node types"
    return json.dumps(made, indent=1), told
