"""``fmt``: which files it takes, what it leaves alone, what it says."""

from __future__ import annotations

import stat
import subprocess
from pathlib import Path

import pytest

from humanoid_bt.cli import main
from humanoid_bt.files.workspace import builtin_root

UGLY = "format: 1\nroot:   # here\n    emergency_stop:   { idle: {} }\n\n\n"
NEAT = "format: 1\nroot:   # here\n  emergency_stop: {idle: {}}\n"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Go to a workspace with a tree and a scene that are not formatted, and a tree that is."""
    write(tmp_path / "trees/ugly.yaml", UGLY)
    write(tmp_path / "trees/deep/neat.yaml", NEAT)
    write(tmp_path / "sim/scenes/room.yaml", "format:  1\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(text.encode())
    return path


def read(name: str) -> str:
    return Path(name).read_bytes().decode()


def test_formats_the_trees_of_the_workspace(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fmt"]) == 0
    assert capsys.readouterr().out == "trees/ugly.yaml: formatted\n"
    assert read("trees/ugly.yaml") == NEAT
    assert read("sim/scenes/room.yaml") == "format:  1\n"
    assert main(["fmt"]) == 0
    assert capsys.readouterr().out == "all 2 files are formatted\n"


@pytest.mark.parametrize(
    "arguments", [["."], ["ugly", "room"], ["trees", "sim"], ["--workspace", ".", "room", "trees"]]
)
def test_takes_names_files_and_folders(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fmt", *arguments]) == 0
    assert set(capsys.readouterr().out.splitlines()) == {
        "sim/scenes/room.yaml: formatted",
        "trees/ugly.yaml: formatted",
    }


def test_takes_a_file_once(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fmt", "ugly", "trees/ugly.yaml", "trees"]) == 0
    assert capsys.readouterr().out.count("ugly") == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nothing.yaml"], "no file and no tree, scene, robot, scenario or campaign named 'nothing.yaml'"),
        (["ugli"], "did you mean 'ugly'?"),
        (["fetch"], "'fetch' is built in; fmt changes only files of the workspace"),
        (["empty_folder"], "nothing to format in 'empty_folder'"),
        (["skill.py"], "'skill.py' is no YAML file"),
        (["--workspace", "empty_folder"], "no trees in 'empty_folder'"),
    ],
)
def test_says_what_it_cannot_take(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("empty_folder").mkdir()
    Path("skill.py").touch()
    assert main(["fmt", *arguments]) == 2
    assert message in capsys.readouterr().err


def test_check_changes_nothing_and_names_files(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fmt", "--check"]) == 1
    assert capsys.readouterr().out == "trees/ugly.yaml: would be formatted\n"
    assert read("trees/ugly.yaml") == UGLY
    assert main(["fmt", "--check", "trees/deep/neat.yaml"]) == 0
    assert capsys.readouterr().out == "1 file is formatted\n"


@pytest.mark.parametrize("before", [UGLY, UGLY.rstrip(), UGLY.replace("\n", "\r\n")])
def test_diff_changes_nothing_and_can_be_applied(
    before: str, folder: Path, capfdbinary: pytest.CaptureFixture[bytes]
) -> None:
    file = write(folder / "trees/ugly.yaml", before)
    assert main(["fmt", "--diff"]) == 1
    diff = capfdbinary.readouterr().out
    assert file.read_bytes() == before.encode()
    subprocess.run(["git", "apply", "-p0", "--whitespace=nowarn"], input=diff, check=True, cwd=folder)
    applied = file.read_bytes()
    assert main(["fmt"]) == 0
    assert file.read_bytes() == applied


def test_a_broken_file_is_left_and_the_others_formatted(capsys: pytest.CaptureFixture[str]) -> None:
    write(Path("trees/broken.yaml"), "root:  [\n")
    write(Path("trees/binary.yaml"), "")
    Path("trees/binary.yaml").write_bytes(b"a:  \xff\n")
    assert main(["fmt"]) == 2
    out, err = capsys.readouterr()
    assert out == "trees/ugly.yaml: formatted\n"
    assert read("trees/broken.yaml") == "root:  [\n"
    assert "trees/binary.yaml:1:5: error: the file is not UTF-8 text" in err
    assert err.endswith("2 files have mistakes and cannot be formatted, of 4\n")
    told = next(line for line in err.splitlines() if "broken" in line)
    assert main(["check", "trees/broken.yaml"]) == 2
    assert told in capsys.readouterr().out.splitlines()


@pytest.mark.parametrize("mark", ["", "\ufeff"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_keeps_line_breaks_and_byte_order_mark(mark: str, end: str) -> None:
    write(Path("trees/ugly.yaml"), mark + UGLY.replace("\n", end))
    assert main(["fmt"]) == 0
    assert read("trees/ugly.yaml") == mark + NEAT.replace("\n", end)
    assert main(["fmt", "--check"]) == 0


def test_keeps_permissions_and_links(folder: Path) -> None:
    file = folder / "trees/ugly.yaml"
    file.chmod(0o640)
    link = folder / "link.yaml"
    link.symlink_to(file)
    assert main(["fmt", "link.yaml"]) == 0
    assert link.is_symlink()
    assert file.read_text(encoding="utf-8") == NEAT
    assert stat.S_IMODE(file.stat().st_mode) == 0o640


def test_a_file_that_cannot_be_replaced_stays_whole(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(self: Path, target: Path) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "replace", refuse)
    assert main(["fmt"]) == 2
    assert "trees/ugly.yaml: error: cannot be written: Permission denied" in capsys.readouterr().err
    assert read("trees/ugly.yaml") == UGLY
    assert sorted(path.name for path in (folder / "trees").iterdir()) == ["deep", "ugly.yaml"]


def test_a_file_that_has_the_form_is_not_written(folder: Path) -> None:
    before = (folder / "trees/deep/neat.yaml").stat()
    assert main(["fmt"]) == 0
    after = (folder / "trees/deep/neat.yaml").stat()
    assert (after.st_ino, after.st_mtime_ns) == (before.st_ino, before.st_mtime_ns)


def test_the_built_in_workspace_has_the_form() -> None:
    assert main(["fmt", "--check", str(builtin_root() / "trees"), str(builtin_root() / "sim")]) == 0
