"""Compiled functions whose last arguments are the same arrays in every call.

Handing over an array takes 0.05 us in a loop and more in a run, and what a class keeps for its arithmetic are ten or
twenty of them. They are bound once: machine code finds them where they were noted, and a call hands over only what is
another one each time.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from functools import partial
from typing import Any, Generic, TypeVar

import numpy as np
from numba import typeof, types
from numba.core.dispatcher import Dispatcher
from numba.core.sigutils import normalize_signature
from numba.extending import intrinsic

from humanoid_bt.core.compiled import compiled, inlined, stamp

_R = TypeVar("_R")


def bindable(signature: str, bound: str) -> Callable[[Callable[..., _R]], Bindable[_R]]:
    """Compile a function whose last arguments are bound before it is called.

    Args:
        signature: of what is given in each call; as in :func:`~humanoid_bt.core.compiled.compiled`.
        bound: the types of the arguments after these, as ``"f8[::1], i8"``.
    """
    return lambda function: Bindable(function, signature, bound)


class Bindable(Generic[_R]):
    """Such a function, see :func:`bindable`."""

    def __init__(self, function: Callable[..., _R], signature: str, bound: str) -> None:
        self._function, self._kinds = function, _kinds(bound)
        returned, _, given = signature.rpartition("(")
        self._call = compiled(f"{returned}(intp, {given}")(_caller(function, len(_kinds(given[:-1])), bound))

    def bind(self, *arguments: Any) -> Callable[..., _R]:
        """Return a function of the other arguments alone.

        Args:
            arguments: the last ones. Of arrays it counts what is in them when it is called.

        Raises:
            TypeError: an array is not of the type that was said.
        """
        if not isinstance(self._call, Dispatcher):
            return lambda *given: self._function(*given, *arguments)
        packed = [_packed(kind, value) for kind, value in zip(self._kinds, arguments, strict=True)]
        table = np.frombuffer(b"".join(packed), np.int64)
        call = partial(self._call, table.ctypes.data)
        vars(call)["bound"] = table, arguments  # which live as long as it
        return call


def _caller(function: Callable[..., _R], count: int, bound: str) -> Callable[..., _R]:
    """Return what calls a function with as many arguments as it is given, and those that are bound at an address."""
    code, name = function.__code__, function.__name__
    given = "".join(f"argument_{place}, " for place in range(count))
    text = f"def {name}(address, {given}): return function({given}*_unpacked(address, {bound!r}))"
    scope: dict[str, Any] = {"__name__": function.__module__, "function": inlined(function), "_unpacked": _unpacked}
    exec(compile("\n" * (code.co_firstlineno - 1) + text, code.co_filename, "exec"), scope)
    caller: Callable[..., _R] = scope[name]
    caller.__qualname__ = f"{function.__qualname__}.bound"  # as its code is kept
    return caller


@intrinsic(prefer_literal=True)
def _unpacked(_typing: Any, address: Any, bound: Any) -> Any:
    """Return the values, of some types, that :func:`_packed` has packed and that lie at an address."""
    kinds = _kinds(bound.literal_value)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        place, values = arguments[0], []
        for kind in kinds:
            data = builder.inttoptr(place, context.get_data_type(kind).as_pointer())
            values.append(context.unpack_value(builder, kind, data))
            place = builder.add(place, context.get_constant(types.intp, _size(kind)))
        return context.make_tuple(builder, signature.return_type, values)

    return types.Tuple(kinds)(address, bound), generate  # type: ignore[no-untyped-call]  # numba has no types


def _packed(kind: Any, value: Any) -> bytes:
    """Return a value as machine code has it: of an array, which nobody owns there, its size, its place, its shape."""
    if not isinstance(kind, types.Array):
        return struct.pack("d" if isinstance(kind, types.Float) else "q", value)
    found = typeof(value)  # type: ignore[no-untyped-call]  # numba has no types
    if found != kind:
        raise TypeError(f"{found} is not {kind}")
    return struct.pack(
        f"{_size(kind) // 8}q", 0, 0, value.size, value.itemsize, value.ctypes.data, *value.shape, *value.strides
    )


def _size(kind: Any) -> int:
    """Return how many bytes it takes, packed."""
    return 8 * (5 + 2 * kind.ndim) if isinstance(kind, types.Array) else 8


def _kinds(names: str) -> tuple[Any, ...]:
    arguments, _ = normalize_signature(f"void({names})")  # type: ignore[no-untyped-call]  # numba has no types
    return tuple(arguments)


stamp(_unpacked, _packed)
