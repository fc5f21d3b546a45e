"""The arguments of ``humanoid-bt schema``."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.cli.arguments.parsing import Commands, add_workspace

_EXAMPLES = """\
examples:
  humanoid-bt schema -o .vscode/tree.schema.json
  humanoid-bt schema scenarios -o .vscode/scenario.schema.json
  humanoid-bt schema campaigns -o .vscode/campaign.schema.json
"""


def add_schema(commands: Commands) -> None:
    """Declare ``schema``."""
    schema = commands.add(
        "schema",
        "write a JSON Schema for editors",
        "Write a JSON Schema of this workspace's tree files, its skills and\n"
        "sub-trees included, or of its scenario or campaign files. Editors complete, explain\nand check with it.",
        _EXAMPLES,
    )
    schema.add_argument(
        "of", nargs="?", choices=["trees", "scenarios", "campaigns"], default="trees", help="default: trees"
    )
    schema.add_argument("-o", "--output", type=Path, metavar="FILE", help="write it to this file; default: print it")
    add_workspace(schema)
