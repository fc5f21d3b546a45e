"""Two recordings in one view: both robots in one scene, their nodes and curves beside each other, on one time axis."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import rerun as rr
import rerun.blueprint as rrb

from humanoid_bt.record import camera, documents, eye, lanes, plots, results, tree_view
from humanoid_bt.record.blueprint import BACKGROUND
from humanoid_bt.record.columns import TIMELINE
from humanoid_bt.record.flight import FLIGHT
from humanoid_bt.record.rrd import RrdFile
from humanoid_bt.record.scene_view import POSES, WORLD

NAMES = ("A", "B")
_TINT = np.array([0.85, 0.2, 0.75])  # of all that is the second one's
_MIXED = 0.6  # share of the tint in its colours
_FRAMES = ("frame", "child_frame", "parent_frame")  # columns that name frames of the scene
_LEFT_OUT = (
    *(f"/{part}" for part in (FLIGHT, camera.CAMERA, documents.RUN, documents.TREE, tree_view.TREE, results.RESULTS)),
    "/__properties",
    *("/view", "/container", "/blueprint_panel", "/selection_panel", "/time_panel"),  # how each was shown alone
)
_COLORS = ("colors", "vertex_colors", "albedo_factor")
_TWICE = f"/{WORLD}/scene/"  # what stands around is shown once
_CURVES = {
    "speed [m/s]": plots.SPEED,
    "tilt [rad]": plots.TILT,
    "palm to target [m]": plots.HANDS,
    "foot force [N]": plots.FEET,
    "distance of what is seen [m]": plots.DISTANCE,
    "confidence of what is seen": plots.CONFIDENCE,
}


def write_side_by_side(path: Path, files: tuple[list[Path], list[Path]], base_height: float = 0.7) -> None:
    """Write a recording that shows two others.

    Args:
        path: of the new one.
        files: the parts of each.
        base_height: of the standing robots [m], the measure of the picture.

    Raises:
        OSError: one of them cannot be read, or the new one cannot be written.
        ValueError: one is no recording.
    """
    path.unlink(missing_ok=True)
    path.touch()  # the library does not say that it cannot
    with rr.RecordingStream("humanoid_bt", recording_id=path.stem, send_properties=False) as stream:
        stream.save(path, default_blueprint=_blueprint(base_height))
        for name, parts in zip(NAMES, files, strict=True):
            for part in parts:
                stream.send_chunks(_chunks(part, name))
        stream.flush()
        stream.disconnect()


def _chunks(file: Path, name: str) -> Iterator[Any]:
    """Yield what one of them shows, below its name."""
    second = name == NAMES[1]
    left_out = (*_LEFT_OUT, _TWICE) if second else _LEFT_OUT
    for entity, batch in RrdFile(file).batches_of(lambda entity: bool(entity) and not entity.startswith(left_out)):
        try:
            chunks = rr.chunk.Chunk.from_record_batch(_renamed(batch, name, second))
        except (pa.ArrowException, ValueError, TypeError, RuntimeError):  # it is damaged: the others are shown
            continue
        for chunk in chunks:
            yield chunk.with_entity_path(f"/{name}{entity}")


def _renamed(batch: Any, name: str, second: bool) -> Any:
    """Return a batch of one of them, with names that the other one does not have; the second one's is tinted."""
    for number, field in enumerate(batch.schema):
        archetype, _, kind = field.name.rpartition(":")
        column = batch.column(number)
        if field.name == "SeriesLines:names":
            changed = _texts(column, lambda curve: f"{name} {curve}")
        elif second and kind in _FRAMES:
            changed = _texts(column, lambda frame: frame if frame == WORLD else f"{name} {frame}")
        elif second and kind in _COLORS and archetype != "StateConfiguration":  # these say what a node did
            changed = _tinted(column)
        else:
            continue
        batch = batch.set_column(number, field, changed)
    return batch


def _texts(column: Any, change: Callable[[str], str]) -> Any:
    rows = [None if row is None else [change(text) for text in row] for row in column.to_pylist()]
    return pa.array(rows, column.type)


def _tinted(column: Any) -> Any:
    """Return colours, each a number 0xRRGGBBAA in a list, mixed with the second one's."""
    rgba = column.values.to_numpy(zero_copy_only=False)[:, None] >> np.array([24, 16, 8, 0]) & 255
    rgb = (rgba[:, :3] * (1 - _MIXED) + 255 * _TINT * _MIXED).astype(np.uint32)
    mixed = rgb[:, 0] << 24 | rgb[:, 1] << 16 | rgb[:, 2] << 8 | rgba[:, 3].astype(np.uint32)
    return pa.ListArray.from_arrays(
        column.offsets, pa.array(mixed, pa.uint32()), type=column.type, mask=column.is_null()
    )


def _blueprint(base_height: float) -> Any:
    one_time = rrb.TimeAxis(link="LinkToGlobal")
    scene = rrb.Spatial3DView(
        name="both robots: B is tinted",
        origin="/",
        contents=[f"+ /{name}/{WORLD}/**" for name in NAMES] + [f"+ /{name}/{POSES}" for name in NAMES],
        eye_controls=rrb.EyeControls3D(position=eye.position(base_height), look_target=(0, 0, 0), eye_up=(0, 0, 1)),
        spatial_information=rrb.SpatialInformation(target_frame=eye.FRAME),
        background=BACKGROUND,
        line_grid=False,
    )
    nodes = [
        rrb.StateTimelineView(
            name=f"nodes of {name}",
            origin="/",
            contents=[f"+ /{name}/{group}/**" for group in lanes.GROUPS],
            time_view=one_time,
        )
        for name in NAMES
    ]
    curves = [
        rrb.TimeSeriesView(
            name=title,
            contents=[f"+ /{name}/{path}/**" for name in NAMES],
            axis_x=one_time,
            plot_legend=rrb.PlotLegend(visible=number == 2),
        )
        for number, (title, path) in enumerate(_CURVES.items())
    ]
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(scene, rrb.Grid(*curves, grid_columns=3), row_shares=[3, 2]),
            rrb.Vertical(*nodes),
            column_shares=[3, 2],
        ),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        auto_layout=False,
        auto_views=False,
    )
