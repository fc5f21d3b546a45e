"""MuJoCo's own functions, for compiled code to call.

Called from Python, most of those that control needs take longer to begin than to end. Here model and data are told by
their addresses, which stay as long as they live, and arrays by their ``ctypes``. Arguments are not checked.
"""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Any

import mujoco
from llvmlite import binding
from numba import config, types

_ADDRESS, _NUMBERS, _INTEGER = types.intp, types.CPointer(types.float64), types.int32  # type: ignore[no-untyped-call]  # numba has no types
_NUMBER = types.float64
_IN_PYTHON = {
    _ADDRESS: ctypes.c_void_p,
    _NUMBERS: ctypes.c_void_p,
    _INTEGER: ctypes.c_int,
    _NUMBER: ctypes.c_double,
}
_MODEL_AND_DATA = _ADDRESS, _ADDRESS
_LIBRARY = next(str(file) for file in sorted(Path(mujoco.__file__).parent.glob("*mujoco*.*")))


def _function(name: str, *arguments: types.Type) -> Any:
    """Return one that takes these arguments, and returns nothing."""
    if config.DISABLE_JIT:  # type: ignore[attr-defined]  # numba finds it at run time
        function = getattr(ctypes.CDLL(_LIBRARY), name)
        function.restype, function.argtypes = None, [_IN_PYTHON[kind] for kind in arguments]
        return function
    return types.ExternalFunction(name, types.void(*arguments))


binding.load_library_permanently(_LIBRARY)
kinematics, com_pos, com_vel, subtree_vel, make_m, passive = (
    _function(name, *_MODEL_AND_DATA)
    for name in ("mj_kinematics", "mj_comPos", "mj_comVel", "mj_subtreeVel", "mj_makeM", "mj_passive")
)
"""(model, data)"""
rne = _function("mj_rne", *_MODEL_AND_DATA, _INTEGER, _NUMBERS)
"""(model, data, whether with acceleration, forces)"""
mul_m = _function("mj_mulM", *_MODEL_AND_DATA, _NUMBERS, _NUMBERS)
"""(model, data, product, vector)"""
integrate_pos = _function("mj_integratePos", _ADDRESS, _NUMBERS, _NUMBERS, _NUMBER)
"""(model, qpos, velocity, time)"""
mat_to_quat = _function("mju_mat2Quat", _NUMBERS, _NUMBERS)
"""(quaternion, matrix)"""
mul_quat = _function("mju_mulQuat", _NUMBERS, _NUMBERS, _NUMBERS)
"""(product, first, second)"""
