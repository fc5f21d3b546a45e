"""A network in a file of ONNX, run by onnxruntime on one core."""

from __future__ import annotations

import importlib
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from humanoid_bt.core.errors import Place, UserError

Metadata = Mapping[str, Any]
"""Key -> value: what is written as JSON, or as words with commas between them, as what it means; else text."""

Tensor = NDArray[np.float32]
FLOAT = "tensor(float)"
FLOATS = (FLOAT, "tensor(double)", "tensor(float16)")
INSTALL = "pip install 'humanoid-bt[policy]'"


class Network:
    """A network that was loaded.

    Args:
        path: the .onnx file.
        place: where it is named, for messages.

    Raises:
        UserError: onnxruntime is not installed, or the file is no model that it can run.

    Attributes:
        metadata: what the model says of itself.
        inputs, outputs: name -> shape; None where a size is free, which is run as 1.
        kinds: of the outputs, as :data:`FLOAT`.
    """

    def __init__(self, path: Path, place: Place | None) -> None:
        runtime = _runtime(place)
        options = runtime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        options.log_severity_level = 4  # what is wrong is raised
        try:
            self._session = runtime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
        except Exception as error:  # onnxruntime's own classes derive from nothing else
            message = f"not a model that onnxruntime can run: {_one_line(error)}"
            raise UserError(message, place, code="policy") from error
        written = self._session.get_modelmeta().custom_metadata_map
        self.metadata: Metadata = {key: _meant(text) for key, text in written.items()}
        self.inputs = {one.name: _shape(one.shape) for one in self._session.get_inputs()}
        self.outputs = {one.name: _shape(one.shape) for one in self._session.get_outputs()}
        self.kinds: dict[str, str] = {one.name: one.type for one in self._session.get_outputs()}
        for one in self._session.get_inputs():
            if one.type != FLOAT:
                message = f"the model's input {one.name!r} is a {one.type}, not a {FLOAT}"
                raise UserError(message, place, "float32", code="policy")

    def run(self, outputs: list[str], inputs: Mapping[str, Tensor]) -> list[Tensor]:
        """Return outputs for inputs.

        Raises:
            RuntimeError: it cannot be computed.
        """
        try:
            return list(self._session.run(outputs, dict(inputs)))
        except Exception as error:  # as above
            raise RuntimeError(_one_line(error)) from error


def of_one(shape: tuple[int | None, ...]) -> tuple[int, ...]:
    """Return the shape of a tensor, of a batch of one."""
    return tuple(1 if length is None else length for length in shape)


def size(shape: tuple[int | None, ...]) -> int:
    """Return how many numbers a tensor has, of a batch of one."""
    return math.prod(of_one(shape))


def is_free(shape: tuple[int | None, ...]) -> bool:
    """Return whether more than the batch is free."""
    return None in shape[1:]


def _runtime(place: Place | None) -> Any:
    try:
        return importlib.import_module("onnxruntime")
    except ImportError as error:
        message = "a learned walker needs onnxruntime, which is not installed"
        raise UserError(message, place, INSTALL, code="policy") from error


def _shape(shape: list[Any]) -> tuple[int | None, ...]:
    return tuple(length if isinstance(length, int) else None for length in shape)


def _meant(text: str) -> Any:
    """Return what a value of metadata means: exporters write lists as JSON, or with commas."""
    try:
        return json.loads(text)
    except ValueError:
        pass
    words = [word.strip() for word in text.split(",")]
    try:
        return [float(word) for word in words]
    except ValueError:
        return words if len(words) > 1 else text


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())[:300]
