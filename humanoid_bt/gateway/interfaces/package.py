"""What a package of interfaces is made of: a folder with msg/, srv/ and action/, as colcon builds it."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

from humanoid_bt.core.errors import Place, UserError, relative

KNOWN = Path(__file__).parent
"""The packages that come along, for there are no wheels of them: as much of each as the gateway needs."""

_NAME = re.compile(r"[a-z](_?[a-z0-9])*")
_NO_VERSION = "0.0.0"  # older than any that is published


@dataclass(frozen=True)
class Package:
    """A package of interfaces.

    Attributes:
        name: of the package.
        version: of it.
        folder: where its files are.
        files: of its interfaces, from there: ``msg/Point.msg``.
    """

    name: str
    version: str
    folder: Path
    files: tuple[Path, ...]


def find(named: str) -> Package:
    """Return a package by its folder, or by its name if it is one of those that come along.

    Raises:
        UserError: there is none, its name does not do, or there are no interfaces in it.
    """
    folder = Path(named)
    if not folder.is_dir():
        folder = KNOWN / named
        if not (folder / "msg").is_dir():
            known = ", ".join(sorted(file.parent.name for file in KNOWN.glob("*/msg")))
            raise UserError(f"there is no folder {named!r}", hint=f"a folder with msg/, srv/ or action/, or {known}")
    name, version = _called(folder)
    files = sorted(
        file.relative_to(folder) for kind in ("msg", "srv", "action") for file in folder.glob(f"{kind}/*.{kind}")
    )
    if not files:
        raise UserError("there are no interfaces", Place(relative(folder)), "files as msg/Point.msg, srv/Find.srv")
    return Package(name, version, folder.resolve(), tuple(files))


def _called(folder: Path) -> tuple[str, str]:
    """Return name and version of a package: its package.xml's, or its folder's name."""
    name, version, file = folder.resolve().name, _NO_VERSION, folder / "package.xml"
    if file.is_file():
        try:
            root = ET.parse(file).getroot()
        except ET.ParseError as error:
            line, column = error.position
            raise UserError(f"this is no XML: {error.msg}", Place(relative(file), line, column + 1)) from None
        name = (root.findtext("name") or name).strip()
        version = (root.findtext("version") or version).strip()
    if not _NAME.fullmatch(name):
        where = Place(relative(file if file.is_file() else folder))
        raise UserError(f"{name!r} is no name of a package", where, "small letters, digits and _, as lab_interfaces")
    return name, version
