"""Coverage of what cannot be read, and in a folder that is called strangely."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.testing.coverage import tree_coverage, write
from humanoid_bt.testing.coverage_page import page
from humanoid_bt.tree.coverage import Coverage


def test_what_cannot_be_read_is_not_covered(tmp_path: Path) -> None:
    file = tmp_path / "broken.yaml"
    file.write_text("format: 1\nroot: {nosuch: {}}\n")
    report = tree_coverage(Coverage(), [file])
    assert "100 %" not in report.text(80)
    assert "100&thinsp;%" not in page(report)
    assert "all tried" not in page(report)


def test_a_page_of_a_folder_that_is_called_strangely_is_written(tmp_path: Path) -> None:
    write(tmp_path / "page.html", "b\udcffd")
    assert (tmp_path / "page.html").read_text() == "b?d"
