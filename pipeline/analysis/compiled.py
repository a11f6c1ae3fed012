"""Compilation of the analysis' kernels, which run over whole batches of frames, and loading them without numba.

Importing numba and readying it for its own cache takes three times as long as judging a log of ten minutes. So the
machine code of a kernel that works on arrays is kept as an object file, which llvmlite loads by itself.

numba's cache sees an edit of the file a kernel stands in, not of the files its callees stand in: a kernel here
calls kernels of its own file only.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from ctypes import CFUNCTYPE, byref, c_int32, c_int64, c_void_p
from functools import cached_property, update_wrapper
from pathlib import Path
from typing import TYPE_CHECKING, Any

import llvmlite.binding as llvm
import numpy as np

from components.cache import cache_folder

if TYPE_CHECKING:
    from numba.core.dispatcher import Dispatcher

Kinds = tuple[tuple[str, int], ...]  # of each array: type and number of dimensions


class Kernel:
    """A compiled function. Called from Python with arrays in which it leaves its results, it does not need numba."""

    def __init__(self, function: Callable[..., Any]):
        """function: of arrays and numbers, as numba compiles them."""
        self.function = function
        self._loaded: dict[Kinds, Callable[..., int]] = {}
        update_wrapper(self, function)

    def __call__(self, *arguments: Any) -> Any:
        """Run it. Where numbers go in or come out, or an array is not contiguous, numba is used."""
        if "dispatcher" in self.__dict__ or not all(_is_plain(argument) for argument in arguments):
            return self.dispatcher(*arguments)
        kinds = tuple((array.dtype.str, array.ndim) for array in arguments)
        if kinds not in self._loaded:
            code = _read(self._path(kinds)) or self._compile(kinds)
            if code is None:
                return self.dispatcher(*arguments)
            self._loaded[kinds] = _link(code, kinds)
        result, trouble = c_void_p(), c_void_p()
        words = [word for array in arguments for word in _words(array)]
        if self._loaded[kinds](byref(result), byref(trouble), *words):
            raise RuntimeError(f"{self.function.__name__} failed: kernels do not raise")

    @cached_property
    def dispatcher(self) -> Dispatcher:
        """The function as numba calls it, from Python and from other kernels."""
        from numba import njit

        from components.compiled import OPTIONS

        return njit(cache=True, nogil=True, **OPTIONS)(self.function)

    @property
    def _numba_type_(self) -> Any:
        """What numba takes this object for, where a kernel calls it."""
        return self.dispatcher._numba_type_

    def _path(self, kinds: Kinds) -> Path:
        types = "".join(f"-{kind[1:]}x{dimensions}" for kind, dimensions in kinds)
        return cache_folder() / f"{self.function.__module__}.{self.function.__name__}{types}.object"

    def _compile(self, kinds: Kinds) -> bytes | None:
        """Compile and keep the object code: (name, 0, object). None if the function returns something."""
        from numba import from_dtype, njit, types

        from components.compiled import OPTIONS

        arrays = tuple(types.Array(from_dtype(np.dtype(kind)), dimensions, "C") for kind, dimensions in kinds)
        bare = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, **OPTIONS}
        compiled = njit(arrays, **bare)(self.function).overloads[arrays]
        if compiled.signature.return_type != types.none:
            return None
        library = compiled.library
        binary = library._codegen._tm.emit_object(library._final_module)
        code = compiled.fndesc.llvm_func_name.encode() + b"\0" + binary
        _write(self._path(kinds), code)
        return code


def kernel(function: Callable[..., Any]) -> Kernel:
    """Decorator of the analysis' kernels: bits that repeat, allocation refused."""
    return Kernel(function)


def _is_plain(argument: Any) -> bool:
    return isinstance(argument, np.ndarray) and argument.flags.carray and argument.dtype.isnative


def _write(path: Path, code: bytes) -> None:
    """Whole or not at all, with its checksum before it."""
    fresh = path.with_suffix(f".{os.getpid()}.tmp")
    fresh.write_bytes(hashlib.sha256(code).digest() + code)
    fresh.replace(path)


def _read(path: Path) -> bytes | None:
    """What was written there; None if there is nothing, or it is damaged."""
    try:
        text = path.read_bytes()
    except OSError:
        return None
    code = text[32:]
    return code if hashlib.sha256(code).digest() == text[:32] else None


def _link(code: bytes, kinds: Kinds) -> Callable[..., int]:
    """The function in (name, 0, object), ready to be called from Python as `_words` says; it keeps what owns its code.

    The object needs nothing but libm, which the process has.
    """
    name, _, binary = code.partition(b"\0")
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine()
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(binary))
    engine.finalize_object()
    words = [word for _, n in kinds for word in (*[c_void_p] * 2, *[c_int64] * 2, c_void_p, *[c_int64] * (2 * n))]
    function = CFUNCTYPE(c_int32, c_void_p, c_void_p, *words)(engine.get_function_address(name.decode()))
    function.engine = engine  # pyright: ignore
    return function


def _words(array: np.ndarray) -> tuple[int | None, ...]:
    """An array as numba passes it: owner (twice, none), size, bytes of an item, address, shape, strides."""
    return (None, None, array.size, array.itemsize, array.ctypes.data, *array.shape, *array.strides)
