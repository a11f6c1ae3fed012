"""Which host an FMU gets: called by its C pointers, integrated, or in a process of its own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.graph import Node
from pipeline.hosts.fmu.slave import FmuHost, Slave


def host_of(node: Node, vectors: Sequence[np.ndarray], start_ns: int) -> FmuHost:
    """The host of a node that is an FMU. vectors: p, u, x, y, w as the loop will use them."""
    return Slave(node, vectors, start_ns)
