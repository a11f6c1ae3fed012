"""A call of a user's own kernels as Python, where numpy sees what compiled code does not: an index beyond a vector."""

from __future__ import annotations

import traceback
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from components.contract import Component
from pipeline.kernels import calls_kernels


def beyond(component: Component, vectors: Sequence[np.ndarray], start_ns: int, dt_ns: int) -> str:
    """Where init or the first step reads or writes beyond its vectors, in one line; "" where neither does.

    vectors: p, u, x, y, w as they are before init; they are not changed. Kernels that call other kernels are not
    tried: these would be compiled once more for it. What else goes wrong is left to the run, whose numbers are
    another language's: there a division by zero does not raise.
    """
    if calls_kernels(component):
        return ""
    copies = [vector.copy() for vector in vectors]
    for name, t_ns in (("init", start_ns), ("step", start_ns + dt_ns)):
        try:
            with np.errstate(all="ignore"):
                getattr(component, name)(t_ns, dt_ns, *copies)
        except IndexError as error:
            place = traceback.extract_tb(error.__traceback__)[-1]
            where = f"{name} at line {place.lineno} of {Path(place.filename).name}"
            return f"{where} goes beyond a vector, whose length ports and sizes tell: {error}"
        except Exception:
            return ""
    return ""
