"""FMUs in libcosim, OSP's co-simulation library."""

from __future__ import annotations

from pathlib import Path

import fmpy
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave


class Cosim:
    """A simulation in libcosim of FMUs by name."""

    def __init__(self, step_ns: int, fmus: dict[str, Path]):
        self.execution = CosimExecution.from_step_size(step_ns)
        self.slaves = [CosimLocalSlave(str(path), name) for name, path in fmus.items()]
        self.index = {name: self.execution.add_local_slave(s) for name, s in zip(fmus, self.slaves, strict=True)}
        about = {name: fmpy.read_model_description(str(path)) for name, path in fmus.items()}
        self.references = {name: {v.name: v.valueReference for v in one.modelVariables} for name, one in about.items()}
        self.observer = CosimObserver.create_last_value()
        self.execution.add_observer(self.observer)

    def connect(self, source: str, output: str, target: str, entry: str) -> None:
        ends = self.references[source][output], self.references[target][entry]
        status = self.execution.connect_real_variables(self.index[source], ends[0], self.index[target], ends[1])
        assert status == 0

    def values(self, name: str, variables: list[str]) -> list[float]:
        return self.observer.last_real_values(self.index[name], [self.references[name][v] for v in variables])
