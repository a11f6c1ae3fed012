"""Asks the allocator of least power whether some of a vessel's thrusters can hold it against a load."""

from __future__ import annotations

import ctypes

import numpy as np

from components.allocator.exact.component import COMPONENT
from components.allocator.exact.model import Exact
from components.compiled import bind

_FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 5)
_PERIOD_NS = 1_000_000_000  # any: each demand is asked for by itself


class Holding:
    """The allocator with the thrusters that are left."""

    def __init__(self, allocator: Exact, available: list[bool]):
        """available: for each thruster whether it can be used."""
        changed = allocator.model_copy(update={"available": tuple(map(float, available))})
        sizes = COMPONENT.pack(changed)
        self._entries = bind(COMPONENT)
        self._vectors = [sizes, *(np.zeros(int(n)) for n in sizes[1:5])]
        self._addresses = [vector.ctypes.data for vector in self._vectors]
        self._init = _FUNCTION(self._entries.init)
        given, at = COMPONENT.defaults(changed), 0
        for port in COMPONENT.inputs(changed):
            self._vectors[1][at : at + port.size] = given.get(port.name, (0.0,) * port.size)
            at += port.size
        at = 0
        for port in COMPONENT.outputs(changed):
            if port.name == "met":
                self._met = at
            at += port.size

    def holds(self, load: np.ndarray) -> bool:
        """Whether they can give the opposite of the load (surge, sway [N], yaw [N m])."""
        self._vectors[1][:3] = -load
        self._init(0, _PERIOD_NS, *self._addresses)
        return self._vectors[3][self._met] == 1.0
