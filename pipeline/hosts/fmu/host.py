"""Which host an FMU gets: called by its C pointers, integrated, or in a process of its own."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pipeline.graph import Node
from pipeline.hosts.fmu.base import FmuHost
from pipeline.hosts.fmu.component import FmuComponent
from pipeline.hosts.fmu.description import MODEL_EXCHANGE
from pipeline.hosts.fmu.instance import Instance


def host_of(node: Node, vectors: Sequence[np.ndarray], start_ns: int) -> FmuHost:
    """The host of a node that is an FMU. vectors: p, u, x, y, w as the loop will use them."""
    assert isinstance(node.component, FmuComponent)
    if node.component.isolate:
        from pipeline.hosts.fmu.apart import Apart

        return Apart(node, vectors, start_ns)
    return instance_of(node, vectors, start_ns)


def instance_of(node: Node, vectors: Sequence[np.ndarray], start_ns: int, folder: Path | None = None) -> Instance:
    """The host that calls the FMU in this process. folder: of its files, where they are extracted already."""
    assert isinstance(node.component, FmuComponent)
    if node.component.interface.name == MODEL_EXCHANGE:
        from pipeline.hosts.fmu.exchange import Exchange  # with sundials

        return Exchange(node, vectors, start_ns, folder)
    from pipeline.hosts.fmu.slave import Slave  # with the compiled step

    return Slave(node, vectors, start_ns, folder)
