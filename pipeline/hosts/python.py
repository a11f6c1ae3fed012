"""Host of components that are Python callables: the same C signature, called back from the compiled loop."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from components.contract import Kernel, Port, numbers_in
from pipeline.hosts.pictures import ImageError, Pictures

_C_FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 5)
RAISED = -1


class PythonHost:
    """C entry points around Python functions; an exception becomes status RAISED and is kept in `error`."""

    def __init__(
        self,
        init: Kernel,
        step: Kernel,
        vectors: Sequence[np.ndarray],
        inputs: Sequence[Port] = (),
        outputs: Sequence[Port] = (),
    ):
        """vectors: p, u, x, y, w as the loop will use them, for as long as this host lives.

        inputs, outputs: needed where there are images among them.
        """
        self.error: BaseException | None = None
        p, u, x, y, w = vectors
        pictures = Pictures(inputs, outputs, u, y)
        self._vectors = p, u, x, y, w
        if pictures.is_any:
            self._vectors = p, u[: numbers_in(inputs)], x, y[: numbers_in(outputs)], w
            init, step = (_with_pictures(function, pictures) for function in (init, step))
        self._keep = [_C_FUNCTION(self._guard(function)) for function in (init, step)]
        self.workspace = 0  # the loop's own scratch
        self.init, self.step = (ctypes.cast(f, ctypes.c_void_p).value or 0 for f in self._keep)

    def reason(self, status: int) -> str:
        """What the functions raised, in one line; "" if that is not why the status is what it is."""
        if self.error is None or status != RAISED:
            return ""
        if isinstance(self.error, ImageError):
            return str(self.error)
        said = str(self.error).strip().partition("\n")[0]
        return f"its Python code raised {type(self.error).__name__}{': ' if said else ''}{said}"

    def _guard(self, function: Kernel) -> Callable[..., int]:
        vectors = self._vectors

        def guarded(t_ns: int, dt_ns: int, *_: int) -> int:
            try:
                return int(function(t_ns, dt_ns, *vectors))
            except BaseException as error:  # the C caller cannot pass it on; the conductor raises it again
                self.error = error
                return RAISED

        return guarded


def _with_pictures(function: Kernel, pictures: Pictures) -> Kernel:
    """The function as one over five vectors, its images passed beside them."""

    def step(*arguments: Any) -> int:
        drawn: dict[str, np.ndarray] = {}
        status = int(function(*arguments, pictures.seen, drawn))
        if status == 0:
            pictures.put(drawn)
        return status

    return step
