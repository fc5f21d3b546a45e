from __future__ import annotations

import sys
from pathlib import Path

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.decision.skill_files import load_skills
from humanoid_bt.files.class_files import class_file, class_place
from humanoid_bt.files.workspace import Workspace

HEAD = "from humanoid_bt.decision.skill import Skill, Status\nfrom humanoid_bt.core.params import param\n"
TYPES = """
import enum
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

class M(enum.Enum):
    A = 1

@dataclass
class D:
    x: int = 1

"""
WAVE = HEAD + "class WaveHand(Skill):\n    'Wave.'\n    def update(self): return Status.SUCCESS\n"


@pytest.fixture
def workspace(tmp_path: Path) -> Workspace:
    (tmp_path / "skills").mkdir()
    return Workspace(tmp_path)


def write(workspace: Workspace, name: str, text: str) -> Path:
    path = workspace.root / "skills" / name
    path.write_text(text)
    return path


def test_skills_and_plain_behaviours_defined_in_a_file_are_found_by_name(workspace: Workspace) -> None:
    write(workspace, "wave.py", WAVE + "import py_trees\nclass Plain(py_trees.behaviours.Success): pass\n")
    abstract = "class Abstract(Skill): pass\nclass Real(Abstract):\n    def update(self): pass\n"
    write(workspace, "more.py", HEAD + "class _Private(Skill):\n    def update(self): pass\n" + abstract)
    skills = load_skills(workspace)
    assert skills["wave_hand"].__doc__ == "Wave."
    assert {"plain", "wave_hand", "real"} <= set(skills)
    assert not {"success", "skill", "abstract", "_private"} & set(skills)
    assert str(class_place(skills["wave_hand"])).endswith("wave.py:3:1")


def test_a_skill_without_update_is_a_mistake(workspace: Workspace) -> None:
    write(workspace, "lazy.py", HEAD + "class Lazy(Skill): pass\n")
    with pytest.raises(UserError, match=r"lazy.py:3:1: error: the skill 'lazy' has no update\(\)"):
        load_skills(workspace)


@pytest.mark.parametrize(
    ("head", "said"),
    [
        ("class Own(Skill):\n    def __init__(self): pass", "4:5: error: Own.__init__ does .* 'name'"),
        (
            "class Own(Skill):\n    far: float = param(1.0, doc='')\n    def __init__(self, name): pass",
            "5:5: error: Own.__init__ does not take what trees give it: got an unexpected keyword argument 'far'",
        ),
        (
            "class Own(Skill):\n    far: float = param(1.0, doc='')\n    def __init__(self, name, far): pass",
            "5:5: error: Own.__init__ does not take what trees give it: missing a required argument: 'far'",
        ),
        (
            "import py_trees\nclass Own(py_trees.behaviours.Success):\n    def __init__(self): pass",
            "5:5: error: Own.__init__ does not take what trees give it: got an unexpected keyword argument 'name'",
        ),
    ],
)
def test_a_constructor_that_does_not_take_what_trees_give_it_is_a_mistake(
    workspace: Workspace, head: str, said: str
) -> None:
    write(workspace, "own.py", f"{HEAD}{head}\n    def update(self): return Status.SUCCESS\n")
    with pytest.raises(UserError, match=rf"own.py:{said}.* \[broken-skill\]"):
        load_skills(workspace)


def test_file_names_never_collide_with_modules(workspace: Workspace) -> None:
    before = dict(sys.modules)
    for name in ("numpy", "py_trees", "idle", "json"):
        write(workspace, f"{name}.py", f"import numpy, json\n{WAVE.replace('WaveHand', 'Do' + name.title())}")
    skills = load_skills(workspace)
    assert {"do_numpy", "do_json"} <= set(skills)
    assert all(sys.modules[name] is module for name, module in before.items())
    assert all(name.startswith("_humanoid_bt_skill_") for name in set(sys.modules) - set(before))


def test_a_users_skill_wins_over_a_built_in_one(
    workspace: Workspace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    builtin = tmp_path / "builtin"
    (builtin / "skills").mkdir(parents=True)
    (builtin / "skills" / "wave.py").write_text(WAVE.replace("Wave.", "Built in."))
    workspace.layers = [workspace.root, builtin]
    assert load_skills(workspace)["wave_hand"].__doc__ == "Built in."
    write(workspace, "mine.py", WAVE.replace("Wave.", "Mine."))
    assert load_skills(workspace)["wave_hand"].__doc__ == "Mine."


def test_a_file_is_loaded_again_only_when_it_changed(workspace: Workspace) -> None:
    write(workspace, "wave.py", WAVE)
    first = load_skills(workspace)["wave_hand"]
    assert load_skills(workspace)["wave_hand"] is first
    write(workspace, "wave.py", WAVE.replace("Wave.", "Bow!!"))  # the same size, within the same second
    assert load_skills(workspace)["wave_hand"].__doc__ == "Bow!!"


def test_a_file_that_breaks_leaves_its_old_classes_whole(workspace: Workspace) -> None:
    path = write(workspace, "wave.py", WAVE)
    wave = load_skills(workspace)["wave_hand"]
    path.write_text("1/0\n")
    with pytest.raises(UserError, match="ZeroDivisionError"):
        load_skills(workspace)
    assert class_file(wave) == path.resolve()


def test_nothing_is_written_beside_the_files(workspace: Workspace) -> None:
    write(workspace, "wave.py", WAVE)
    load_skills(workspace)
    assert [path.name for path in (workspace.root / "skills").iterdir()] == ["wave.py"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "import nothing_of_this_name\n",
            r"bad.py:1:1: error: .*ModuleNotFoundError: No module named 'nothing_of_this_name'",
        ),
        ("x = 1\ndef f():\n    return 1 / 0\nf()\n", r"bad.py:3:12: error: .*ZeroDivisionError: division by zero"),
        ("class A:\n  def f(:\n", r"bad.py:2:9: error: .*SyntaxError: "),
        ("import json\njson.loads('{')\n", r"bad.py:2:1: error: .*JSONDecodeError"),
        ("raise SystemExit(3)\n", r"bad.py:1:1: error: .*SystemExit: 3"),
        (
            WAVE.replace("    'Wave.'", "    resources = ('tail',)"),
            r"bad.py:3:1: error: .*unknown resource 'tail' \[unknown-resource\]\n.*valid: base",
        ),
        (
            WAVE.replace("    'Wave.'", "    resources = 'base'"),
            r"bad.py:3:1: error: the resources of 'wave_hand' must be a tuple",
        ),
        (WAVE.replace("    'Wave.'", "    x: Nowhere = param(1, doc='')"), r"bad.py.*NameError: name 'Nowhere'"),
        (WAVE.replace("    'Wave.'", "    x: 'Nowhere' = param(1, doc='')"), r"bad.py:3:1: error: .*cannot be read"),
        (
            WAVE.replace("    'Wave.'", "    status: int = param(1, doc='')"),
            r"bad.py:3:1: error: .*declares the parameter 'status', which every node has",
        ),
        (WAVE.replace("    'Wave.'", "    x = param(1, doc='')"), r"bad.py:3:1: error: .*cannot be read"),
    ],
)
def test_a_bad_file_is_answered_with_its_line(workspace: Workspace, text: str, message: str) -> None:
    write(workspace, "bad.py", text)
    with pytest.raises(UserError, match=message):
        load_skills(workspace)


@pytest.mark.parametrize(
    ("declared", "message"),
    [
        ("M = param(M.A, doc='')", "the parameter 'x' of 'wave_hand' cannot be M"),
        ("D = param(D(), doc='')", "the parameter 'x' of 'wave_hand' cannot be D"),
        ("list = param([], doc='')", "the parameter 'x' of 'wave_hand' cannot be list"),
        ("Sequence[float] = param((), doc='')", "cannot be collections.abc.Sequence"),
        ("list[M] | None = param(None, doc='')", "the parameter 'x' of 'wave_hand' cannot be list"),
        ("float = param('5 cm', unit='m', doc='')", "the default of 'x' must be 0.05, not '5 cm'"),
        ("float = param('5 s', unit='m', doc='')", "the default of 'x' has the unit 's'"),
        ("float = param(-1.0, minimum=0, doc='')", "the default of 'x' must be >= 0, not -1"),
        ("float = param(float('nan'), doc='')", "the default of 'x' must be finite"),
        ("Literal['left', 'right'] = param('lft', doc='')", "the default of 'x' cannot be 'lft'"),
        ("int = param(2.5, doc='')", "the default of 'x' must be a whole number"),
    ],
)
def test_what_no_file_could_write_is_no_parameter(workspace: Workspace, declared: str, message: str) -> None:
    write(workspace, "bad.py", TYPES + WAVE.replace("    'Wave.'", f"    x: {declared}"))
    with pytest.raises(UserError, match=f"bad.py:16:1: error: .*{message}") as caught:
        load_skills(workspace)
    assert [problem.code for problem in caught.value.problems] == ["broken-skill"]


@pytest.mark.parametrize(
    "declared",
    [
        "tuple[float, ...] | None = param([1, 2], doc='')",
        "dict[str, list[int]] = param({'a': [1]}, doc='')",
        "Literal['all'] | int = param(3, doc='')",
        "float | None = param(doc='')",
    ],
)
def test_what_a_file_can_write_is_a_parameter(workspace: Workspace, declared: str) -> None:
    write(workspace, "good.py", TYPES + WAVE.replace("    'Wave.'", f"    x: {declared}"))
    assert "wave_hand" in load_skills(workspace)


def test_all_bad_files_are_answered_at_once(workspace: Workspace) -> None:
    write(workspace, "a.py", "1/0\n")
    write(workspace, "b.py", "1/0\n")
    write(workspace, "c.py", WAVE)
    write(workspace, "d.py", WAVE)
    with pytest.raises(UserError) as caught:
        load_skills(workspace)
    assert [problem.message.split(":")[0] for problem in caught.value.problems] == [
        "the skill file cannot be imported",
        "the skill file cannot be imported",
        "the skill 'wave_hand' is declared twice",
    ]


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("from humanoid_bt import Skil\n", "did you mean 'Skill'?"),
        ("class Wave(Skill): pass\n", "from humanoid_bt import Skill"),
        ("class Wave(Skil): pass\n", "did you mean 'Skill'?"),
        ("from math import sqr\n", "did you mean 'sqrt'?"),
    ],
)
def test_a_name_that_cannot_be_imported_is_answered_with_the_nearest(
    workspace: Workspace, text: str, hint: str
) -> None:
    write(workspace, "bad.py", text)
    with pytest.raises(UserError) as caught:
        load_skills(workspace)
    [problem] = caught.value.problems
    assert problem.hint == hint
    assert "(" not in problem.message  # where the engine lies is of no use
