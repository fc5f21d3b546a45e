"""``humanoid-bt init``: a workspace that works at once, to be changed into one's own."""

from __future__ import annotations

import argparse
import os
import shlex
import shutil
from pathlib import Path

from humanoid_bt.cli.schema import schema_text
from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.session.report import ExitCode

SCHEMAS = {of: Path(f".vscode/{of.removesuffix('s')}.schema.json") for of in ("trees", "scenarios", "campaigns")}
"""What is made and not copied: schemas say what skills and trees there are."""

_NEXT = """\
  humanoid-bt run point_out     walk up to a ball and point at it; --view shows it
  humanoid-bt check             find mistakes in all files
  humanoid-bt test              try the tree in its scenario
  python -m pytest tests        test the skill
  humanoid-bt campaign point_anywhere -j 2     how often does it succeed?
README.md says what is in it and how to go on"""


def init(arguments: argparse.Namespace) -> int:
    """Make a workspace and say what to do next.

    Raises:
        UserError: something is in the way, or the folder cannot be written.
    """
    folder: Path = arguments.folder
    template = builtin_root() / "template"
    files = sorted(path.relative_to(template) for path in template.rglob("*") if _is_ours(path))
    _refuse_to_overwrite(folder, [*files, *SCHEMAS.values()])
    try:
        for file in files:
            (folder / file).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(template / file, folder / file)
        for of, file in SCHEMAS.items():
            text, _ = schema_text(Workspace(folder), of)
            (folder / file).write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise UserError(f"{error.filename or str(folder)!r} cannot be written: {error.strerror}") from error
    print(f"{folder}: a workspace with {len(files) + len(SCHEMAS)} files. What to do next:")
    if relative(folder) != ".":
        print(f"  cd {shlex.quote(str(folder))}")
    print(_NEXT)
    return ExitCode.SUCCESS


def _is_ours(path: Path) -> bool:
    """Whether a file belongs to the template, and is none that Python has left there."""
    return path.is_file() and "__pycache__" not in path.parts


def _refuse_to_overwrite(folder: Path, files: list[Path]) -> None:
    """See that nothing is in the way.

    Raises:
        UserError: something is.
    """
    hint = "valid: a folder that is new, or has none of these files"
    if os.path.lexists(folder) and not folder.is_dir():
        raise UserError(f"{str(folder)!r} is no folder", hint=hint)
    in_the_way = [str(file) for file in files if os.path.lexists(folder / file)]
    if in_the_way:
        more = f" and {len(in_the_way) - 3} more" if len(in_the_way) > 3 else ""
        raise UserError(f"init would overwrite {', '.join(in_the_way[:3])}{more} in {str(folder)!r}", hint=hint)
