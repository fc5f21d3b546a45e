"""From the sources of a package of interfaces to what is installed: libraries, headers, Python."""

from __future__ import annotations

import shutil
import subprocess
import sysconfig
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from humanoid_bt.core.errors import UserError
from humanoid_bt.gateway.interfaces.generate import TYPE_SUPPORTS, Sources

_RUNTIME = (
    "rosidl_runtime_c",
    "rcutils",
    "rosidl_typesupport_c",
    *TYPE_SUPPORTS,
    "rosidl_typesupport_fastrtps_cpp",
    "fastcdr",
)
"""Libraries that what is generated calls, beside those of other packages."""

_LINK = ("-shared", "-fPIC", "-O2", "-Wl,--as-needed")


class Compiler:
    """Compiles the sources of a package.

    Args:
        name: of the package.
        sources: of it.
        prefixes: where other packages are installed, with their headers and libraries.
        to: folder for libraries, as ``lib/``, and for the Python package.

    Raises:
        UserError: there is no compiler, or no headers of Python.
    """

    def __init__(self, name: str, sources: Sources, prefixes: Sequence[Path], to: Path) -> None:
        check_tools()
        self._name, self._sources, self._to = name, sources, to
        self._libraries = to / "lib"
        self._libraries.mkdir(parents=True, exist_ok=True)
        own = [sources.folder / module for module in ("rosidl_generator_c", *TYPE_SUPPORTS)]
        theirs = [folder for prefix in prefixes for folder in (prefix / "include", *prefix.glob("include/*/"))]
        python = [Path(sysconfig.get_path("include")), Path(np.get_include())]
        self._headers = [f"-I{folder}" for folder in (*own, *theirs, *python)]
        self._runtime = [str(prefix / f"lib/lib{one}.so") for prefix in prefixes for one in _RUNTIME]
        self._runtime = [library for library in self._runtime if Path(library).is_file()]
        self._others = [str(file) for prefix in prefixes for file in prefix.glob("lib/lib*__rosidl_*_c.so")]
        self._others += [str(file) for prefix in prefixes for file in prefix.glob("lib/lib*__rosidl_generator_py.so")]

    def compile(self) -> None:
        """Make all libraries, in the order in which they need each other."""
        code = self._sources.folder
        for kind in ("rosidl_generator_c", *TYPE_SUPPORTS, "rosidl_typesupport_c", "rosidl_generator_py"):
            files = sorted(file for file in (code / kind / self._name).glob("*/**/*.c*"))
            self._link(files, self._libraries / f"lib{self._name}__{kind}.so")
        package = self._to / self._name
        shutil.copytree(code / "rosidl_generator_py" / self._name, package, ignore=shutil.ignore_patterns("*.c"))
        for kind in ("rosidl_typesupport_c", *TYPE_SUPPORTS):
            entry = code / "rosidl_generator_py" / self._name / f"_{self._name}_s.ep.{kind}.c"
            self._link([entry], package / f"{self._name}_s__{kind}.so")

    def _link(self, files: Sequence[Path], library: Path) -> None:
        compiler = "g++" if any(file.suffix == ".cpp" for file in files) else "gcc"
        own = sorted(map(str, self._libraries.glob("*.so")))
        named = f"-Wl,-soname,{library.name}"  # else others look for it where it was built
        command = [compiler, *_LINK, named, *self._headers, *map(str, files), "-o", str(library), *own, *self._others]
        done = subprocess.run([*command, *self._runtime], capture_output=True, text=True, check=False)
        if done.returncode:
            said = [line for line in done.stderr.splitlines() if "error" in line or "undefined" in line]
            raise UserError(f"{library.name} cannot be built: {(said or done.stderr.splitlines() or ['?'])[0]}")


def check_tools() -> None:
    """Refuse where nothing can be compiled.

    Raises:
        UserError: there is no compiler, or no headers of Python, and how to get them.
    """
    for tool in ("gcc", "g++"):
        if shutil.which(tool) is None:
            raise UserError(f"messages are compiled with {tool!r}, which is not there", hint=f"apt install {tool}")
    if not Path(sysconfig.get_path("include"), "Python.h").is_file():
        python = f"python{sysconfig.get_python_version()}"
        raise UserError(f"the headers of {python} are not there", hint=f"apt install {python}-dev")
