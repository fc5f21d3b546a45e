"""The public API: what users import, compared with a list, so that a change is a decision."""

from __future__ import annotations

import inspect
import re
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import humanoid_bt as hbt

LIST = Path(__file__).with_name("public_api.txt")
MEANT = "If this is meant, `python tests/test_public_api.py --write` writes the list; tell of it in CHANGELOG.md."
GIVEN = {
    "Gait",
    "Mode",
    "Node",
    "NodeChange",
    "NodeError",
    "Recording",
    "Report",
    "RigResult",
    "RobotHandle",
    "SkillCheck",
    "State",
    "Track",
    "Tree",
    "TreeRun",
    "View",
}
"""Classes whose instances users are given; how they are made is not public."""

PLAIN = (bool, int, float, str, tuple, type(None))


def public_api() -> list[str]:
    """Return a line for each public name and each public member of a class, with how it is called."""
    return [line for name in sorted(hbt.__all__) for line in _lines(name, getattr(hbt, name))]


def _lines(name: str, thing: Any) -> Iterator[str]:
    if isinstance(thing, ModuleType):
        yield f"{name}: {', '.join(sorted(thing.__all__))}"
    elif inspect.isclass(thing) and thing.__module__.startswith("humanoid_bt"):
        yield f"class {name}{'' if name in GIVEN else _call(thing)}"
        for member in sorted(_members(thing)):
            value = inspect.getattr_static(thing, member, None)
            plain = value.__func__ if isinstance(value, classmethod) else value
            yield f"    {member}{_call(plain, skip=1) if inspect.isfunction(plain) else ''}"
    elif inspect.isfunction(thing):
        yield f"{name}{_call(thing)}"
    else:
        yield name


def _members(cls: type) -> set[str]:
    """Return the public members of a class that are ours: methods, properties, fields and documented attributes."""
    found: set[str] = set()
    for base in cls.__mro__:
        if base.__module__.startswith("humanoid_bt"):
            attributes = inspect.cleandoc(base.__doc__ or "").partition("Attributes:\n")[2].partition("\n\n")[0]
            documented = re.findall(r"^    (\w[\w, ]*): ", attributes, re.MULTILINE)
            found |= {*vars(base), *vars(base).get("__annotations__", {}), *", ".join(documented).split(", ")}
    return {name for name in found if name and not name.startswith("_")}


def _call(thing: Any, skip: int = 0) -> str:
    try:
        parameters = list(inspect.signature(thing).parameters.values())[skip:]
    except (TypeError, ValueError):
        return ""
    shown = [
        parameter.replace(annotation=parameter.empty, default=_default(parameter.default)) for parameter in parameters
    ]
    return str(inspect.Signature(shown))


def _default(value: Any) -> Any:
    return value if value is inspect.Parameter.empty or isinstance(value, PLAIN) else ...


def test_the_public_api_is_the_one_that_was_decided() -> None:
    known, now = LIST.read_text(encoding="utf-8").splitlines(), public_api()
    gone, new = [line for line in known if line not in now], [line for line in now if line not in known]
    assert known == now, "\n".join([*(f"- {line}" for line in gone), *(f"+ {line}" for line in new), MEANT])


def test_every_name_is_there_and_means_the_same_to_type_checkers() -> None:
    source = Path(hbt.__file__).read_text(encoding="utf-8")
    typed = re.findall(r"^    from ([\w.]+) import (\w+) as \2$", source, re.MULTILINE)
    assert sorted(name for _, name in typed) == sorted(hbt.__all__) == sorted(set(hbt.__all__))
    for home, name in typed:
        found = getattr(hbt, name)  # a module, or what is in one
        assert found in (sys.modules.get(f"{home}.{name}"), getattr(import_module(home), name))
    assert set(hbt.__all__) <= set(dir(hbt))


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'Skil'"):
        hbt.Skil  # type: ignore[attr-defined]  # noqa: B018  # the mistake that is tried


def test_a_near_name_is_thought_of() -> None:
    script = "import humanoid_bt as hbt\nhbt.Sesion('fetch')"
    done = subprocess.run([sys.executable, "-c", script], check=False, capture_output=True, text=True)
    assert "Did you mean: 'Session'?" in done.stderr


@pytest.mark.parametrize(
    ("line", "heavy"),
    [
        ("import humanoid_bt", {"numpy", "py_trees", "mujoco", "mink", "rerun"}),
        ("from humanoid_bt import Skill, Status, param", {"mujoco", "mink", "rerun", "humanoid_bt.tree"}),
    ],
)
def test_a_skill_file_does_not_wait_for_the_simulator(line: str, heavy: set[str]) -> None:
    script = f"{line}\nimport sys\nprint(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, text=True).stdout.split()
    assert not heavy & set(loaded)


USES = """
import humanoid_bt as hbt
from humanoid_bt import Skill, Status, param

class Nod(Skill):
    times: int = param(3, doc="How often.")

    def update(self) -> Status:
        reveal_type(self.robot.track("ball"))
        return self.succeed("nodded")

with hbt.Session("fetch", reach_distance="45 cm") as session:
    reveal_type(session.step())
    reveal_type(session.state)
    reveal_type(session.percepts["target"].age)
    reveal_type(session.node("reach").status)
    reveal_type(session.report)
reveal_type(hbt.run("fetch", seed=3))
reveal_type(hbt.load("fetch"))
reveal_type(hbt.check("fetch"))
reveal_type(hbt.skills()["wave"](times=1))
reveal_type(hbt.make_tree(hbt.nodes.Wait("wait", duration=1.0)).to_yaml())
hbt.run("fetch", mode="fast")
hbt.runn("fetch")
"""
REVEALED = [
    "humanoid_bt.decision.robot.Track | None",
    "builtins.bool",
    "humanoid_bt.core.messages.State",
    "builtins.float",
    "py_trees.common.Status",
    "humanoid_bt.session.report.Report",
    "humanoid_bt.session.report.Report",
    "humanoid_bt.tree.tree.Tree",
    "builtins.list[humanoid_bt.core.errors.Problem]",
    "py_trees.behaviour.Behaviour",
    "builtins.str",
]


@pytest.mark.trials
def test_type_checkers_see_what_everything_is(tmp_path: Path) -> None:
    file = tmp_path / "uses.py"
    file.write_text(USES, encoding="utf-8")
    root = Path(hbt.__file__).parents[1]
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file", str(root / "pyproject.toml"), str(file)]
    said = subprocess.run(command, cwd=root, check=False, capture_output=True, text=True).stdout
    last = [kind.rsplit(".", 1)[-1] for kind in re.findall(r'Revealed type is "(.*)"', said)]
    assert last == [kind.rsplit(".", 1)[-1] for kind in REVEALED], said
    errors = re.findall(r"error: (.*)", said)
    assert len(errors) == 2, said
    assert "incompatible type \"Literal['fast']\"" in errors[0]
    assert 'has no attribute "runn"' in errors[1]


if __name__ == "__main__" and sys.argv[1:] == ["--write"]:
    LIST.write_text("\n".join(public_api()) + "\n", encoding="utf-8")
