"""What all hosts of FMUs are to the rest of the pipeline."""

from __future__ import annotations

import weakref
from collections.abc import Sequence
from contextlib import ExitStack

import numpy as np

from pipeline.graph import Node
from pipeline.hosts.fmu.component import FmuComponent
from pipeline.hosts.fmu.description import FmuError
from pipeline.hosts.fmu.parameters import FmuParameters
from pipeline.hosts.python import PythonHost


class FmuHost:
    """C entry points of one FMU instance, made by the first init, and its state saved and restored.

    init, step: addresses. workspace: what the loop is to pass as w; 0 for a scratch of its own.
    """

    workspace = 0

    def __init__(self, node: Node, vectors: Sequence[np.ndarray], start_ns: int):
        """vectors: p, u, x, y, w as the loop will use them, for as long as this host lives."""
        assert isinstance(node.component, FmuComponent)
        assert isinstance(node.parameters, FmuParameters)
        self.component, self.parameters, self.start_ns = node.component, node.parameters, start_ns
        self._node, self._vectors = node, tuple(vectors)
        self._python = PythonHost(self._init, self._advance, vectors)
        self.files = ExitStack()
        self._release = weakref.finalize(self, self.files.close)

    @property
    def init(self) -> int:
        """The address of a Python function."""
        return self._python.init

    @property
    def step(self) -> int:
        """The address of a Python function, unless there is a compiled one."""
        return self._python.step

    @property
    def error(self) -> BaseException | None:
        """What was raised here."""
        return self._python.error

    @property
    def can_save(self) -> bool:
        """Whether its state can be had as bytes."""
        return self.component.interface.can_save

    @property
    def name(self) -> str:
        """Of the component."""
        return self._node.name

    @property
    def file(self) -> str:
        """The FMU's name, for messages."""
        return self.component.description.path.name

    def reason(self, status: int) -> str:
        """Why it stopped the run."""
        return str(self.error) if isinstance(self.error, FmuError) else self._python.reason(status)

    def move(self, vectors: Sequence[np.ndarray]) -> None:
        """Take other memory for p, u, x, y and w; the instance stays as it is."""
        self._vectors = tuple(vectors)
        self._python = PythonHost(self._init, self._advance, vectors)

    def close(self) -> None:
        """Let the instance go and remove its files."""
        self._release()

    def abandon(self) -> None:
        """Remove its files alone: it hangs, and the process is about to end."""
        self.files.close()

    def take_messages(self) -> list[str]:
        """Warnings and errors that the FMU has logged since the last time."""
        raise NotImplementedError

    def stands_since(self) -> int:
        """A number that changes with each call of the FMU that begins or ends; odd within one."""
        return 0

    def save(self) -> bytes:
        """Its state. Raises FmuError."""
        raise NotImplementedError

    def restore(self, data: bytes) -> None:
        """Have the state that save() gave, in a fresh instance. Raises FmuError."""
        raise NotImplementedError

    def _init(self, t_ns: int, dt_ns: int, *vectors: np.ndarray) -> int:
        """The contract's init."""
        raise NotImplementedError

    def _advance(self, t_ns: int, dt_ns: int, *vectors: np.ndarray) -> int:
        """The contract's step."""
        raise NotImplementedError
