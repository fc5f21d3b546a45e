"""Shapes of the 3D view as entities that other programs draw."""

from __future__ import annotations

import base64
import io

import numpy as np
import pytest

from humanoid_bt.core.messages import Array
from humanoid_bt.review.drawing import Shape

trimesh = pytest.importorskip("trimesh")

from humanoid_bt.review.mcap_scene import scene_update  # noqa: E402  # needs what may be missing

QUARTER = np.array([np.sqrt(0.5), 0, 0, np.sqrt(0.5)])  # about x: what points up points to the right
CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 0, 2]])


def shape(kind: str, **values: Array) -> Shape:
    red = np.array([1.0, 0, 0, 1])
    return Shape("robot", "shin", "shin", kind, np.array([0.0, 0, 1]), QUARTER, values, red)


def drawn(kind: str, **values: Array) -> dict[str, list[dict[str, object]]]:
    (entity,) = scene_update([shape(kind, **values)], {"sec": 0, "nsec": 0})["entities"]
    assert entity["id"] == entity["frame_id"] == "shin"
    return entity  # type: ignore[no-any-return]  # as JSON has it


def test_a_capsule_has_a_ball_at_either_end_of_its_axis() -> None:
    entity = drawn("Capsules3D", lengths=np.array([0.6]), radii=np.array([0.1]))
    ends = [list(ball["pose"]["position"].values()) for ball in entity["spheres"]]  # type: ignore[index]  # likewise
    np.testing.assert_allclose(sorted(ends), [[0, -0.3, 1], [0, 0.3, 1]], atol=1e-12)
    assert entity["cylinders"][0]["size"] == {"x": 0.2, "y": 0.2, "z": 0.6}


@pytest.mark.parametrize("shared", [True, False])
def test_a_mesh_is_a_file_of_gltf_with_y_up(shared: bool) -> None:
    triangles = {"triangle_indices": np.array([[0, 1, 2]])} if shared else {}
    entity = drawn("Mesh3D", vertex_positions=CORNERS, vertex_normals=np.tile([0.0, -1, 0], (3, 1)), **triangles)
    (model,) = entity["models"]
    data = base64.b64decode(str(model["data"]), validate=True)
    (mesh,) = trimesh.load_scene(io.BytesIO(data), file_type="glb").geometry.values()
    np.testing.assert_allclose(mesh.vertices, [[0, 0, 0], [1, 0, 0], [0, 2, 0]])
    np.testing.assert_allclose(mesh.vertex_normals, np.tile([0, 0, 1], (3, 1)), atol=1e-6)
    assert mesh.visual.material.baseColorFactor.tolist() == [255, 0, 0, 255]


def test_what_is_not_known_of_a_shape_leaves_it_out() -> None:
    assert drawn("Boxes3D")["cubes"] == []
