"""``fmt``: bringing tree, scene, robot, scenario and campaign files into one form."""

from __future__ import annotations

import argparse
import difflib
import sys
from dataclasses import dataclass
from pathlib import Path

from humanoid_bt.cli.findings import print_findings
from humanoid_bt.core.errors import Place, UserError, nearest, relative
from humanoid_bt.core.texts import one_line
from humanoid_bt.files.formatting import formatted
from humanoid_bt.files.reading import followed, is_file, is_folder, read_bytes, read_text
from humanoid_bt.files.whole import write_whole
from humanoid_bt.files.workspace import Workspace, yaml_files
from humanoid_bt.session.report import ExitCode

_DEFAULT = ("trees", "scenarios", "campaigns")  # what is formatted where nothing is named
_ENDING = "trees, scenes, robots, scenarios and campaigns end in .yaml"
_BYTE_ORDER_MARK = "\ufeff"


def fmt(arguments: argparse.Namespace) -> int:
    """Format files, or say which would change; return the exit code."""
    looks_only = arguments.check or arguments.diff
    changed = broken = 0
    files = _files(arguments)
    for path in files:
        try:
            file = _read(path)
            if file.is_changed and not looks_only:
                _write(path, file.after)
        except UserError as error:
            print_findings(error.problems, stderr=True)
            broken += 1
            continue
        changed += file.is_changed
        if file.is_changed and arguments.diff:
            print(_diff(file, relative(path)), end="")
        elif file.is_changed:
            print(f"{one_line(relative(path))}: {'would be formatted' if looks_only else 'formatted'}")
    if broken:
        count = "1 file has" if broken == 1 else f"{broken} files have"
        print(f"{count} mistakes and cannot be formatted, of {len(files)}", file=sys.stderr)
        return ExitCode.USAGE
    if not changed and not arguments.diff:
        print("1 file is formatted" if len(files) == 1 else f"all {len(files)} files are formatted")
    return ExitCode.FAILURE if changed and looks_only else ExitCode.SUCCESS


def _files(arguments: argparse.Namespace) -> list[Path]:
    """Return the files to format, each once, symbolic links followed."""
    workspace = Workspace(arguments.workspace)
    if not arguments.paths:
        found = sorted(path for folder in _DEFAULT for path in (workspace.root / folder).rglob("*.yaml"))
        if not found:
            raise UserError(
                f"no trees in {relative(workspace.root)!r}",
                hint="give names, files or folders, or go to a folder with trees/, scenarios/ or campaigns/",
            )
    else:
        found = [file for text in arguments.paths for file in _given(text, workspace)]
    return list(dict.fromkeys(followed(path) for path in found))


def _given(text: str, workspace: Workspace) -> list[Path]:
    """Return the files of one argument: a folder, a file, or a name."""
    path = Path(text)
    if is_folder(path):
        if not (found := yaml_files(path)):
            raise UserError(f"nothing to format in {text!r}", hint=_ENDING)
        return found
    if is_file(path):
        if path.suffix not in {".yaml", ".yml"}:
            raise UserError(f"{text!r} is no YAML file", hint=_ENDING)
        return [path]
    known = {
        **workspace.campaigns(),
        **workspace.scenarios(),
        **workspace.robots(),
        **workspace.scenes(),
        **workspace.trees(),
    }
    own = {name: file for name, file in known.items() if file.is_relative_to(workspace.root)}
    if text in own:
        return [own[text]]
    if text in known:
        raise UserError(f"{text!r} is built in; fmt changes only files of the workspace", hint=nearest(text, own))
    raise UserError(
        f"no file and no tree, scene, robot, scenario or campaign named {text!r}", hint=nearest(path.stem, own)
    )


@dataclass(frozen=True)
class _File:
    """A file's bytes as they are and as they would be."""

    before: bytes
    after: bytes

    @property
    def is_changed(self) -> bool:
        return self.before != self.after


def _read(path: Path) -> _File:
    """Read and format a file; its byte order mark and the line break of its first line are kept.

    Raises:
        UserError: it cannot be read or formatted.
    """
    text = read_text(path)
    before = read_bytes(path)
    after = formatted(text, relative(path))
    if before.partition(b"\n")[0].endswith(b"\r"):
        after = after.replace("\n", "\r\n")
    if text.startswith(_BYTE_ORDER_MARK):
        after = _BYTE_ORDER_MARK + after
    return _File(before, after.encode("utf-8"))


def _write(path: Path, content: bytes) -> None:
    """Replace a file's content at once, or not at all; its permissions stay.

    Raises:
        UserError: it cannot be written.
    """
    try:
        write_whole(path, content)
    except OSError as error:
        raise UserError(f"cannot be written: {error.strerror}", Place(relative(path)), code="unreadable") from error


def _diff(file: _File, name: str) -> str:
    """Return what would change, in unified form."""
    before, after = (content.decode("utf-8").splitlines(keepends=True) for content in (file.before, file.after))
    lines = difflib.unified_diff(before, after, name, f"{name} (formatted)")
    return "".join(line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n" for line in lines)
