from __future__ import annotations

import subprocess
import sys

import humanoid_bt

CODE = """
import sys, pkgutil, importlib
import humanoid_bt.link as link
for module in pkgutil.walk_packages(link.__path__, "humanoid_bt.link."):
    importlib.import_module(module.name)
core = {f"humanoid_bt.core.{name}" for name in ("errors", "texts", "clock", "messages")}
allowed = {"humanoid_bt", "humanoid_bt.core", *core}
ours = {name for name in sys.modules if name.split(".")[0] == "humanoid_bt" and not name.startswith("humanoid_bt.link")}
heavy = {"py_trees", "rerun", "mujoco", "mink", "rich", "yaml", "psutil", "pickle"} & set(sys.modules)
sys.exit(f"{ours - allowed} {heavy - {'pickle'}}" if ours - allowed or heavy - {"pickle"} else 0)
"""


def test_the_link_stands_on_messages_alone() -> None:
    root = humanoid_bt.__path__[0].removesuffix("humanoid_bt")
    done = subprocess.run([sys.executable, "-c", CODE], cwd=root, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
