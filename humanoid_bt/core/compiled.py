"""Machine code for the arithmetic that runs hundreds of times a second, from Python functions, by numba.

Between small arrays Python spends far more time on what surrounds an operation than on the operation. A function that
takes and changes arrays of numbers, and nothing else, is compiled as its module is imported: the first time on a
machine that takes a second or so, afterwards its code is loaded in two milliseconds. With ``NUMBA_DISABLE_JIT=1`` it
stays a Python function, for a debugger.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar

from numba import njit

_P = ParamSpec("_P")
_R = TypeVar("_R")


def compiled(signature: str) -> Callable[[Callable[_P, _R]], Callable[_P, _R]]:
    """Compile a function for arguments of these types.

    Arithmetic is what numpy's is: dividing by zero gives infinity, and nothing is reordered, so that a run is the same
    bit for bit on every machine of a kind.

    Args:
        signature: of numba's, as ``"f8(f8[::1], f8)"``: arrays whose numbers lie one after the other, and numbers.
    """
    return njit(signature, cache=True, error_model="numpy")


def inlined(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Compile a function as a part of compiled ones that call it, for whatever types they call it with."""
    return njit(cache=True, error_model="numpy")(function)
