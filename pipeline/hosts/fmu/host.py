"""Which host an FMU gets: called by its C pointers, integrated, or in a process of its own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.graph import Node
from pipeline.hosts.fmu.base import FmuHost
from pipeline.hosts.fmu.component import FmuComponent
from pipeline.hosts.fmu.description import MODEL_EXCHANGE
from pipeline.hosts.fmu.slave import Slave


def host_of(node: Node, vectors: Sequence[np.ndarray], start_ns: int) -> FmuHost:
    """The host of a node that is an FMU. vectors: p, u, x, y, w as the loop will use them."""
    assert isinstance(node.component, FmuComponent)
    if node.component.interface.name == MODEL_EXCHANGE:
        from pipeline.hosts.fmu.exchange import Exchange  # with sundials

        return Exchange(node, vectors, start_ns)
    return Slave(node, vectors, start_ns)
