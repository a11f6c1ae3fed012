"""The process in which an FMU is isolated: does what its parent asks over the socket that is standard input."""

from __future__ import annotations

import ctypes
import json
import os
import signal
import socket
import sys
from pathlib import Path
from typing import Any

import numpy as np

from components.contract import HEADER
from pipeline.errors import TowlineError
from pipeline.graph import Node
from pipeline.hosts.death import die_with
from pipeline.hosts.fmu import link
from pipeline.hosts.fmu.base import FmuHost
from pipeline.hosts.fmu.component import component_of
from pipeline.hosts.fmu.description import FmuError
from pipeline.hosts.fmu.host import instance_of

_C_FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 5)


class Isolated:
    """The FMU and its vectors p, u, x, y, w."""

    def __init__(self, wanted: dict[str, Any]):
        """wanted: as apart.Apart writes it. Raises TowlineError."""
        component = component_of(Path(wanted["path"]), wanted["interface"])
        if component.description.digest != wanted["hash"]:
            raise FmuError(f"{component.description.path.name} was changed during the run")
        parameters = component.parameters.model_validate_json(json.dumps(wanted["parameters"]), strict=True)
        inputs, outputs = component.inputs(parameters), component.outputs(parameters)
        node = Node(wanted["name"], wanted["path"], component, parameters, 0, 1, 0, inputs, outputs, 0, ())
        p = component.pack(parameters)
        sizes = [sum(port.size for port in ports) for ports in (inputs, outputs)]
        # Where a vector is empty, its address must still be one.
        self._u, self._y = (np.zeros(max(size, 1))[:size] for size in sizes)
        self._p, nothing = p, np.zeros(1)[:0]
        self._vectors = (p, self._u, nothing, self._y, nothing)
        self.host: FmuHost = instance_of(node, self._vectors, wanted["start_ns"], Path(wanted["folder"]))

    def make(self, kind: int, t_ns: int, dt_ns: int, data: bytes) -> bytes:
        """An init or a step: y. Raises FmuError."""
        numbers = np.frombuffer(data, np.float64)
        n_p = len(self._p) - HEADER
        self._p[HEADER:], self._u[:] = numbers[:n_p], numbers[n_p:]
        function = _C_FUNCTION(self.host.init if kind == link.INIT else self.host.step)
        addresses = [vector.ctypes.data for vector in self._vectors]
        status = function(t_ns, dt_ns, *addresses[:4], self.host.workspace or addresses[4])
        if status != 0:
            raise FmuError(self.host.reason(status))
        return self._y.tobytes()


def main() -> None:
    """Serve until the parent wants no more or is gone."""
    if not die_with(int(sys.argv[1])):
        return
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with socket.socket(fileno=os.dup(0)) as parent:
        try:
            _serve(parent)
        except link.EndedError:
            return


def _serve(parent: socket.socket) -> None:
    isolated: Isolated | None = None
    while True:
        kind, t_ns, dt_ns, data = link.asked(parent)
        if kind == link.END:
            if isolated is not None:
                isolated.host.close()
            return
        try:
            if kind == link.BEGIN:
                isolated, found = Isolated(json.loads(data)), b""
            else:
                assert isolated is not None
                found = _done(isolated, kind, t_ns, dt_ns, data)
        except TowlineError as error:
            link.answer(parent, link.FAILED, str(error).encode())
        else:
            link.answer(parent, link.ALL_FINE, found)


def _done(isolated: Isolated, kind: int, t_ns: int, dt_ns: int, data: bytes) -> bytes:
    if kind == link.SAVE:
        return isolated.host.save()
    if kind == link.RESTORE:
        isolated.host.restore(data)
        return b""
    if kind == link.MESSAGES:
        return json.dumps(isolated.host.take_messages()).encode()
    return isolated.make(kind, t_ns, dt_ns, data)


if __name__ == "__main__":
    main()
