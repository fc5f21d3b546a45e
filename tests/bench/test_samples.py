from __future__ import annotations

from pathlib import Path

import pytest

from humanoid_bt.bench.samples import sample_tree
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.tree.source.load import load_tree


@pytest.mark.parametrize("nodes", [10, 40, 500])
def test_a_sample_has_so_many_nodes_and_no_mistakes(tmp_path: Path, nodes: int) -> None:
    file = tmp_path / "sample.yaml"
    file.write_text(sample_tree(nodes), encoding="utf-8")
    assert len(load_tree(file, Workspace(builtin_root())).nodes) == nodes


@pytest.mark.parametrize("nodes", [5, 41])
def test_not_every_number_of_nodes_can_be_had(nodes: int) -> None:
    with pytest.raises(ValueError, match=f"not {nodes}"):
        sample_tree(nodes)
