"""Tiny ONNX models written by hand: an affine network with metadata, with no more of the format than that takes.

https://github.com/onnx/onnx/blob/main/onnx/onnx.proto has the numbers of the fields.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

FLOAT, INT64 = 1, 7  # TensorProto.DataType


def write_affine(
    path: Path,
    matrix: Any,
    offset: Any,
    metadata: Mapping[str, Any] | None = None,
    *,
    state: int = 0,
    flat: bool = False,
    batch: int | str = 1,
    numbers: str = "",
    answer: int = FLOAT,
) -> None:
    """Write a network whose output ``action`` is ``obs @ matrix + offset``.

    Args:
        path: the file.
        matrix: shape (observations, actions).
        offset: shape (actions,).
        metadata: key -> text, or what becomes JSON.
        state: so many numbers of a memory: ``h_out`` is ``h_in`` + 1.
        flat: whether ``h_out`` has no batch, as ``h_in`` has.
        batch: first size of the observation, or its name where it is free.
        numbers: name of the second size of the observation where it is free.
        answer: type of the output.
    """
    matrix, offset = np.asarray(matrix, np.float32), np.asarray(offset, np.float32)
    graph = _node("MatMul", ["obs", "matrix"], ["product"]) + _node("Add", ["product", "offset"], ["sum"])
    graph += _node("Cast", ["sum"], ["action"], _text(1, "to") + _number(3, answer) + _number(20, 2))
    graph += _tensor("matrix", matrix) + _tensor("offset", offset)
    inputs, outputs = (
        _value(11, "obs", batch, numbers or len(matrix)),
        _value(12, "action", batch, len(offset), kind=answer),
    )
    if state:
        graph += _node("Add", ["h_in", "one"], ["h"]) + _tensor("one", np.ones(1, np.float32))
        graph += _node("Squeeze" if flat else "Identity", ["h"], ["h_out"])
        shape = (state,) if flat else (1, state)
        inputs, outputs = inputs + _value(11, "h_in", 1, state), outputs + _value(12, "h_out", *shape)
    model = (
        _number(1, 8) + _field(8, _text(1, "") + _number(2, 13)) + _field(7, graph + _text(2, "g") + inputs + outputs)
    )
    for key, value in (metadata or {}).items():
        model += _field(14, _text(1, key) + _text(2, value if isinstance(value, str) else json.dumps(value)))
    path.write_bytes(model)


def _varint(value: int) -> bytes:
    out = b""
    while value > 0x7F:
        out += bytes([value & 0x7F | 0x80])
        value >>= 7
    return out + bytes([value])


def _number(field: int, value: int) -> bytes:
    return _varint(field << 3) + _varint(value)


def _field(field: int, content: bytes) -> bytes:
    return _varint(field << 3 | 2) + _varint(len(content)) + content


def _text(field: int, text: str) -> bytes:
    return _field(field, text.encode())


def _node(kind: str, inputs: list[str], outputs: list[str], attribute: bytes = b"") -> bytes:
    ends = [*(_text(1, name) for name in inputs), *(_text(2, name) for name in outputs)]
    return _field(1, b"".join(ends) + _text(4, kind) + (_field(5, attribute) if attribute else b""))


def _tensor(name: str, values: Any) -> bytes:
    dims = b"".join(_number(1, length) for length in values.shape)
    raw = struct.pack(f"<{values.size}f", *values.reshape(-1).tolist())
    return _field(5, dims + _number(2, FLOAT) + _text(8, name) + _field(9, raw))


def _value(field: int, name: str, *shape: int | str, kind: int = FLOAT) -> bytes:
    dims = b"".join(_field(1, _text(2, size) if isinstance(size, str) else _number(1, size)) for size in shape)
    return _field(field, _text(1, name) + _field(2, _field(1, _number(1, kind) + _field(2, dims))))
