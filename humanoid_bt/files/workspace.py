"""Workspaces: folders with ``trees/``, ``skills/``, ``perception/``, ``sim/`` and more, and names in them.

Names are looked up in the current workspace first, then in the built-in one.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import Literal

from humanoid_bt.core.errors import UserError, nearest, relative, resolved
from humanoid_bt.files.reading import is_file, is_folder

_PACKAGE = Path(__file__).resolve().parents[1]
_TREES, _SCENES, _ROBOTS, _SKILLS = "trees/*.yaml", "sim/scenes/*.yaml", "sim/*/robot.yaml", "skills/*.py"
_SCENARIOS, _CAMPAIGNS, _GATEWAYS = "scenarios/*.yaml", "campaigns/*.yaml", "gateways/*.yaml"
_DEEP = ("trees", "scenarios", "campaigns")  # folders in which files may lie at any depth
_KINDS = ("trees", "sim", "scenarios", "campaigns")
_Thing = Literal["tree", "scene", "robot", "scenario", "gateway"]


def builtin_root() -> Path:
    """Return the built-in workspace: inside the installed package, or the repository in a checkout."""
    packaged = _PACKAGE / "builtin"
    return packaged if packaged.is_dir() else _PACKAGE.parent


def workspace_above(folder: Path) -> Path | None:
    """Return the nearest workspace: this folder or one above it; None if none of them is one.

    Test files make no workspace: ``tests/skills/`` with nothing but tests in it holds no skills.
    """
    return next((place for place in (folder, *folder.parents) if _is_workspace(place)), None)


def yaml_files(folder: Path, kinds: Sequence[str] = _KINDS) -> list[Path]:
    """Return the trees, scenes, robots, scenarios and campaigns of a folder.

    Of a folder of trees, scenarios or campaigns all below it, however its folders are called; of ``sim/`` the scenes
    and robots, of a workspace those in its folders for them. Of any other folder what lies directly in it: below it,
    there may be anybody's files.

    Args:
        folder: it.
        kinds: the folders of a workspace in which such files are looked for.
    """
    whole = resolved(folder)
    if (deep := deep_folder(whole)) is not None:
        return sorted(folder.rglob("*.yaml")) if deep.name in kinds else []
    if any((folder / name).is_dir() for name in _KINDS):
        return [path for name in kinds if (folder / name).is_dir() for path in yaml_files(folder / name, kinds)]
    if whole.name == "sim":
        robots = (path / "robot.yaml" for path in folder.glob("*/"))
        found = [*folder.glob("scenes/*.yaml"), *filter(os.path.lexists, robots)]  # a broken link is told of
        return sorted(found) if "sim" in kinds else []
    return sorted(folder.glob("*.yaml"))


def is_path(name: str) -> bool:
    """Return whether a name is the path of a file, not what a file in a workspace is called."""
    return "/" in name or name.endswith((".yaml", ".yml"))


def source_files(folder: Path) -> list[Path]:
    """Return the files of a folder of percept sources; none of a Python package, which is something else."""
    if (folder / "__init__.py").exists():
        return []
    return [path for path in sorted(folder.glob("*.py")) if not path.name.startswith("_")]


def deep_folder(folder: Path) -> Path | None:
    """Return the folder of trees, scenarios or campaigns that a folder is or lies in: the outermost of its workspace.

    Outside of a workspace the nearest, and None if there is none.
    """
    found: list[Path] = []
    for place in (folder, *folder.parents):
        named_so = place.name in _DEEP
        if _is_workspace(place) and not (named_so and _is_workspace(place.parent)):
            return found[-1] if found else None
        if named_so:
            found.append(place)
    return found[0] if found else None


def _is_workspace(folder: Path) -> bool:
    if any(any(folder.glob(pattern)) for pattern in (_TREES, _SCENES, _ROBOTS, _SCENARIOS)):
        return True
    return any(not path.name.startswith(("_", "test_", "conftest.")) for path in folder.glob(_SKILLS))


class Workspace:
    """A workspace laid over the built-in one.

    Args:
        root: the user's folder; the working directory if None. It may lack any of the folders.

    Raises:
        UserError: ``root`` is not a folder, or the working directory is gone.
    """

    def __init__(self, root: str | PathLike[str] | None = None) -> None:
        if root is not None and not isinstance(root, (str, PathLike)):
            message, hint = f"a workspace is a folder, not {root!r}", "valid: its path, as text or a Path"
            raise UserError(message, hint=hint, code="wrong-type")
        self.root = resolved(Path(root or "."))
        if not is_folder(self.root):
            raise UserError(f"the workspace {relative(self.root)!r} is not a folder", code="no-file")
        self.layers = list(dict.fromkeys((self.root, builtin_root())))

    def __repr__(self) -> str:
        return f"Workspace({relative(self.root)!r})"

    @classmethod
    def of_tree(cls, path: Path) -> Workspace:
        """Return the workspace a tree or a scenario file belongs to.

        It is the folder above its ``trees/``, ``scenarios/`` or ``campaigns/``, else its own folder if that has
        ``skills/`` or ``sim/``, else the current one.
        """
        folder = resolved(path).parent
        if (deep := deep_folder(folder)) is not None:
            return cls(deep.parent)
        return cls(folder if (folder / "skills").is_dir() or (folder / "sim").is_dir() else None)

    @classmethod
    def of_argument(cls, tree: str, root: str | PathLike[str] | Workspace | None) -> Workspace:
        """Return the workspace for a tree that is named.

        Args:
            tree: name or path of the tree.
            root: the workspace that was asked for, if any. Else a file's own, or the working directory for a name.

        Raises:
            UserError: ``root`` is not a folder.
        """
        if root is not None:
            return root if isinstance(root, Workspace) else cls(root)
        path = Path(tree)
        return cls.of_tree(path) if is_file(path) else cls()

    def trees(self) -> dict[str, Path]:
        """Return every tree file by name."""
        return self._files(_TREES)

    def tree_files(self) -> list[Path]:
        """Return every file below ``trees/``: also those that trees name by their path."""
        return [path for layer in self.layers for path in yaml_files(layer / "trees")]

    def scenes(self) -> dict[str, Path]:
        """Return every scene file by name."""
        return self._files(_SCENES)

    def scenarios(self) -> dict[str, Path]:
        """Return every scenario file by name."""
        return self._files(_SCENARIOS)

    def campaigns(self) -> dict[str, Path]:
        """Return every campaign file by name."""
        return self._files(_CAMPAIGNS)

    def gateways(self) -> dict[str, Path]:
        """Return every gateway file by name."""
        return self._files(_GATEWAYS)

    def robots(self) -> dict[str, Path]:
        """Return every ``robot.yaml`` by the name of its folder."""
        found: dict[str, Path] = {}
        for layer in reversed(self.layers):
            found |= {path.parent.name: path for path in sorted(layer.glob(_ROBOTS))}
        return found

    def skill_files(self) -> list[Path]:
        """Return every skill file; the current workspace's come last and win over built-in ones of one name."""
        return [
            path
            for layer in reversed(self.layers)
            for path in sorted(layer.glob(_SKILLS))
            if not path.name.startswith("_")
        ]

    def perception_files(self) -> list[Path]:
        """Return every file of percept sources, in the order of :meth:`skill_files`."""
        return [path for layer in reversed(self.layers) for path in source_files(layer / "perception")]

    def find_tree(self, name: str) -> Path:
        """Return a tree's file from its name or path.

        Raises:
            UserError: there is none.
        """
        return self._find(name, self.trees(), "tree", "file")

    def find_scene(self, name: str) -> Path:
        """Return a scene's file from its name or path; raises as :meth:`find_tree`."""
        return self._find(name, self.scenes(), "scene", "file")

    def find_scenario(self, name: str) -> Path:
        """Return a scenario's file from its name or path; raises as :meth:`find_tree`."""
        return self._find(name, self.scenarios(), "scenario", "file")

    def find_gateway(self, name: str) -> Path:
        """Return a gateway file from its name or path; raises as :meth:`find_tree`."""
        return self._find(name, self.gateways(), "gateway", "file")

    def find_robot(self, name: str) -> Path:
        """Return a robot's ``robot.yaml`` from its name, folder or path; raises as :meth:`find_tree`."""
        path = Path(name)
        if is_folder(path) and is_file(path / "robot.yaml"):
            return path / "robot.yaml"
        return self._find(name, self.robots(), "robot", "folder or robot.yaml")

    def _files(self, pattern: str) -> dict[str, Path]:
        found: dict[str, Path] = {}
        for layer in reversed(self.layers):
            found |= {path.stem: path for path in sorted(layer.glob(pattern))}
        return found

    def _find(self, name: str, known: dict[str, Path], what: _Thing, kind: str) -> Path:
        if name in known:
            return known[name]
        path = Path(name)
        if is_folder(path):
            raise UserError(f"{name!r} is a folder, not a {what}", hint=nearest(name, known), code=f"unknown-{what}")
        if is_path(name):
            if is_file(path):
                return path
            raise UserError(f"no {what} {kind} {name!r}", hint=nearest(path.stem, known), code=f"unknown-{what}")
        raise UserError(f"no {what} named {name!r}", hint=nearest(name, known), code=f"unknown-{what}")
