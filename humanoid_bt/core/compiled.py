"""Machine code for the arithmetic that runs hundreds of times a second, from Python functions, by numba.

Between small arrays Python spends far more time on what surrounds an operation than on the operation. A function that
takes and changes arrays of numbers, and nothing else, is compiled as its module is imported: the first time on a
machine that takes a second or so, afterwards its code is loaded in two milliseconds. With ``NUMBA_DISABLE_JIT=1`` it
stays a Python function, for a debugger.

numba itself takes 0.3 s to load, so only what simulates a robot or controls one imports such functions.
"""

from __future__ import annotations

import hashlib
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from glob import escape
from pathlib import Path
from typing import ParamSpec, TypeVar

from numba import njit
from numba.core.dispatcher import Dispatcher

_P = ParamSpec("_P")
_R = TypeVar("_R")

_NOTICED = 0.5  # s that nobody waits for a function that is loaded

_STAMPS: dict[int, str] = {}
"""Of what is part of compiled functions: what changes with it."""


def compiled(signature: str) -> Callable[[Callable[_P, _R]], Callable[_P, _R]]:
    """Compile a function for arguments of these types.

    Arithmetic is what numpy's is: dividing by zero gives infinity, and nothing is reordered, so that a run is the same
    bit for bit on every machine of a kind.

    Args:
        signature: of numba's, as ``"f8(f8[::1], f8)"``: arrays whose numbers lie one after the other, and numbers.
    """

    def compile_it(function: Callable[_P, _R]) -> Callable[_P, _R]:
        begun = time.monotonic()
        done = _jit(function, signature)
        loaded = isinstance(done, Dispatcher) and bool(done.stats.cache_hits)  # which takes long on a busy machine
        if time.monotonic() - begun > _NOTICED and not loaded:
            _tell()
        return done

    return compile_it


def inlined(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Compile a function as a part of compiled ones that call it, for whatever types they call it with."""
    done = _jit(function)
    stamp(done, function)
    return done


def stamp(part: object, function: Callable[..., object]) -> None:
    """Let code that has some part be made anew once the file changes of the function that the part is made from."""
    _STAMPS[id(part)] = _hash(Path(function.__code__.co_filename).read_text(encoding="utf-8"), _taken(function))


def _jit(function: Callable[_P, _R], signature: str | None = None) -> Callable[_P, _R]:
    try:
        done = njit(cache=True, error_model="numpy")(function)
    except RuntimeError as error:  # nowhere to keep it: neither beside the file nor in a cache of the user's
        if "cannot cache" not in str(error):
            raise
        return njit(signature, error_model="numpy")(function)
    if isinstance(done, Dispatcher):
        _forget_outdated(done, function)
        if signature:
            done.compile(signature)
            done.disable_compile()
    return done


def _forget_outdated(done: Dispatcher, function: Callable[..., object]) -> None:
    """Forget code that holds what has changed elsewhere: numba sees only that the function's own file has."""
    if done.stats.cache_path is None:
        return
    folder, stamp = Path(done.stats.cache_path), _taken(function)
    stem = f"{Path(function.__code__.co_filename).stem}.{function.__qualname__}-{function.__code__.co_firstlineno}"
    kept = folder / f"{stem}.taken"
    with suppress(OSError):
        if kept.exists() and kept.read_text(encoding="utf-8") == stamp:
            return
    with suppress(OSError):
        for index in folder.glob(f"{escape(stem)}.*.nbi"):
            index.unlink(missing_ok=True)
        folder.mkdir(parents=True, exist_ok=True)
        kept.write_text(stamp, encoding="utf-8")


def _taken(function: Callable[..., object]) -> str:
    """Return what is another one once a number or a compiled function changes that a function takes from elsewhere."""
    values = {name: function.__globals__.get(name) for name in sorted(set(function.__code__.co_names))}
    numbers = (f"{name}={value}" for name, value in values.items() if isinstance(value, (int, float, str, tuple)))
    return _hash(*numbers, *(_STAMPS[id(value)] for value in values.values() if id(value) in _STAMPS))


def _hash(*texts: str) -> str:
    return hashlib.sha256("\n".join(texts).encode()).hexdigest()


@cache
def _tell() -> None:
    """Tell a person who waits, once, why it takes so long."""
    if sys.stderr.isatty():
        sys.stderr.write("compiling control for this machine, which takes some ten seconds the first time\n")
