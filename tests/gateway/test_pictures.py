"""What the head camera sees as messages, made without ROS 2."""

from __future__ import annotations

import numpy as np
import pytest

from humanoid_bt.core.geometry import rotation_matrix
from humanoid_bt.gateway import outputs, pictures
from humanoid_bt.gateway.file import Frames
from humanoid_bt.gateway.frames import optical_in_base
from humanoid_bt.gateway.snapshot import Snapshot
from humanoid_bt.link.wire import SeenPicture
from humanoid_bt.perception.picture import Picture
from tests.gateway.test_outputs import types
from tests.tree.helpers import make_state

PITCH = np.array([[0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, 0.8]])  # the eye looks down


@pytest.fixture
def seen() -> SeenPicture:
    color = np.arange(4 * 6 * 3, dtype=np.uint8).reshape(4, 6, 3)
    depth = np.full((4, 6), np.inf, dtype=np.float32)
    depth[1, 2] = 1.5
    return SeenPicture(3.0, color, depth, 5.0, np.array([0.1, 0.0, 0.4]), PITCH)


def test_pixels_are_given_row_by_row_from_the_upper_left_one(seen: SeenPicture) -> None:
    color = pictures.image(types, seen, 1000.5, "eye")
    assert (color.height, color.width, color.encoding, color.step) == (4, 6, "rgb8", 18)
    assert bytes(color.data[:6]) == bytes([0, 1, 2, 3, 4, 5])
    assert (color.header.frame_id, color.header.stamp.sec, color.header.stamp.nanosec) == ("eye", 1000, 500_000_000)
    depth = pictures.depth(types, seen, 1000.5, "eye")
    assert (depth.encoding, depth.step, depth.is_bigendian) == ("32FC1", 24, 0)
    assert np.frombuffer(bytes(depth.data), "<f4").reshape(4, 6)[1, 2] == 1.5


def test_the_optical_frame_and_the_matrix_put_a_pixel_where_perception_does(seen: SeenPicture) -> None:
    picture = Picture(seen.color, seen.depth, seen.focal, seen.position, seen.rotation)
    k = np.array(pictures.camera_info(types, seen, 0.0, "eye").k).reshape(3, 3)
    position, turn = optical_in_base(seen)
    for column, row, depth in ((2.0, 1.0, 1.5), (5.0, 3.0, 2.0), (0.0, 0.0, 0.7)):
        point = position + rotation_matrix(turn) @ (depth * np.linalg.inv(k) @ [column, row, 1.0])
        assert point == pytest.approx(picture.point(column, row, depth))


def test_tf_says_where_the_camera_was_when_it_took_the_last_picture(seen: SeenPicture) -> None:
    names = Frames(base="pelvis", camera="eye")
    now = Snapshot(make_state(4.0), 1000.25, [], names, None, {}, {}, seen, 999.5)
    _, camera = outputs.tf(types, now).transforms
    assert (camera.header.frame_id, camera.child_frame_id, camera.header.stamp.sec) == ("pelvis", "eye", 999)
    moved, turn = camera.transform.translation, camera.transform.rotation
    assert [moved.x, moved.y, moved.z] == pytest.approx([0.1, 0.0, 0.4])
    ahead = rotation_matrix(np.array([turn.w, turn.x, turn.y, turn.z])) @ [0, 0, 1]
    assert ahead == pytest.approx(PITCH @ [1, 0, 0])
