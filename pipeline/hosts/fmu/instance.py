"""An FMU's instance in this process: made, initialised, tuned, saved, restored and let go, and its errors."""

from __future__ import annotations

import ctypes
import math
import weakref
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from components.contract import HEADER
from pipeline.fmu.archive import extracted
from pipeline.graph import Node
from pipeline.hosts.fmu import streams
from pipeline.hosts.fmu.base import FmuHost
from pipeline.hosts.fmu.component import FmuComponent
from pipeline.hosts.fmu.description import FmuError
from pipeline.hosts.fmu.exchanges import Exchange, Table
from pipeline.hosts.fmu.kinds import HIGH, LOW
from pipeline.hosts.fmu.library import Library
from pipeline.hosts.fmu.table import (
    ASK,
    CALLS_MADE,
    ELEMENT,
    FINISH_STEP,
    HAS_EVENTS,
    MEET_EVENT,
    NOT_EXACT,
    NOT_WHOLE,
    REFUSED,
    RETURNED,
    TUNE,
    WHERE,
)
from pipeline.hosts.python import RAISED

_ASKED = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, ctypes.c_int64)
_single: weakref.WeakValueDictionary[str, Any] = weakref.WeakValueDictionary()  # hosts of FMUs that allow one, by hash


class Instance(FmuHost):
    """A host that calls the FMU itself. folder: of its files, where somebody else has extracted them."""

    def __init__(self, node: Node, vectors: Sequence[np.ndarray], start_ns: int, folder: Path | None = None):
        """As FmuHost."""
        super().__init__(node, vectors, start_ns)
        self._folder = folder
        self._library: Library | None = None
        inputs = list(zip(self.component.inputs_in_fmu, node.inputs, strict=True))
        outputs = list(zip(self.component.outputs_in_fmu, node.outputs, strict=True))
        self._table = Table(inputs, outputs, when=self._when(self.component))
        self._asked = _ASKED(self._answer)
        self._table.words[ASK] = ctypes.cast(self._asked, ctypes.c_void_p).value or 0
        self.workspace = self._table.address

    @property
    def library(self) -> Library:
        """The instance that runs."""
        assert self._library is not None
        return self._library

    def reason(self, status: int) -> str:
        """Why it stopped the run."""
        return super().reason(status) if status == RAISED else self._explained(status)

    def take_messages(self) -> list[str]:
        """Warnings and errors that the FMU has logged since the last time."""
        return self._library.messages.take() if self._library is not None else []

    def stands_since(self) -> int:
        """See FmuHost."""
        return int(self._table.words[CALLS_MADE])

    def save(self) -> bytes:
        """Its state, with what this host knows of it: tunable parameters, inputs, next event. Raises FmuError."""
        next_s = self.library.next_event_s
        known = [math.nan if next_s is None else next_s, *self._table.tuned, *self._table.noted(len(self._vectors[1]))]
        return np.array(known, "<f8").tobytes() + self.library.save()

    def restore(self, data: bytes) -> None:
        """Have the state that save() gave, in a fresh instance. Raises FmuError."""
        n_p, n_u = len(self.parameters.vector()), len(self._vectors[1])
        known = np.frombuffer(data, "<f8", count=1 + n_p + n_u)
        self._begin(self.start_ns / 1e9)
        self.library.end_initialization(self.start_ns / 1e9)
        self.library.restore(data[known.nbytes :])
        self.library.next_event_s = None if math.isnan(known[0]) else float(known[0])
        self._table.have_tuned(known[1 : 1 + n_p])
        self._table.note_inputs(known[1 + n_p :])

    def close(self) -> None:
        """Let the instance go and remove its files."""
        library, self._library = self._library, None
        if library is not None:
            library.free()
        super().close()

    def _open(self) -> Library:
        """Load the library, once."""
        if self._library is None:
            streams.divert()
            self.files.callback(streams.restore)
            folder = self._folder or self.files.enter_context(extracted(self.component.description.path))
            self._library = Library(self.component, folder, self._node.name)
        else:
            self._library.free()
        return self._library

    @staticmethod
    def _when(component: FmuComponent) -> str:
        """Which inputs are set in event mode only: "none", "discrete" or "all"."""
        return "discrete" if component.interface.has_events else "none"

    def _claim(self) -> None:
        """Refuse a second instance where the FMU allows one a process only."""
        if not self.component.interface.is_single:
            return
        other = _single.get(self.component.description.digest)
        if other is not None and other is not self and other.is_running:
            name = self.component.description.path.name
            text = f"{name} can be instantiated only once per process, and '{other.name}' runs it here already"
            raise FmuError(f"{text}; give one of them isolate: true")
        _single[self.component.description.digest] = self

    @property
    def is_running(self) -> bool:
        """Whether there is an instance."""
        return self._library is not None and self._library.is_instantiated

    def _begin(self, start_s: float) -> None:
        """A fresh instance in initialization mode, with its parameters."""
        library = self._open()
        self._claim()
        library.instantiate()
        parameters = self.parameters
        changed = [(parameters.VARIABLES[name], parameters.values(name)) for name in parameters.changed()]
        library.configure([(one, values) for one, values in changed if one.causality == "structuralParameter"])
        for one, values in changed:
            if one.causality != "structuralParameter":
                library.set(one, values)
        self._table.have_tuned(parameters.vector())
        self._table.attach(library)
        library.begin(start_s)

    def _init(self, t_ns: int, dt_ns: int, *vectors: np.ndarray) -> int:
        """The contract's init: inputs set in initialization mode, outputs got after it."""
        self._table.words[CALLS_MADE] += 1
        self._begin(t_ns / 1e9)
        has_events = self._table.words[HAS_EVENTS]
        self._table.words[HAS_EVENTS] = 0  # initialization mode takes them all
        self._exchange("fmu_inputs", t_ns, dt_ns)
        self._table.words[HAS_EVENTS] = has_events
        self._table.note_inputs(vectors[1])
        self.library.end_initialization(t_ns / 1e9)
        self._exchange("fmu_outputs", t_ns, dt_ns)
        self._table.words[CALLS_MADE] += 1
        return 0

    def _exchange(self, name: str, t_ns: int, dt_ns: int) -> None:
        """Set all inputs or get all outputs. Raises FmuError."""
        from pipeline.hosts.fmu import kernel

        p, u, x, y, _ = (ctypes.cast(v.ctypes.data, ctypes.POINTER(ctypes.c_double)) for v in self._vectors)
        w = ctypes.cast(self._table.address, ctypes.POINTER(ctypes.c_double))
        status = getattr(kernel, name).ctypes(t_ns, dt_ns, p, u, x, y, w)
        if status != 0:
            raise FmuError(self._explained(status))

    def _tunable_numbers(self) -> np.ndarray:
        """Tunable parameters as events left them."""
        return self._vectors[0][HEADER:]

    def _tune(self) -> None:
        """Give the FMU the tunable parameters that events changed."""
        numbers, at = self._tunable_numbers(), 0
        changed: list[tuple[Any, list[Any]]] = []
        for name in self.parameters.tunable():
            one = self.parameters.VARIABLES[name]
            n = len(self.parameters.numbers(name))
            new = numbers[at : at + n]
            if not np.array_equal(new, self._table.tuned[at : at + n]):
                whole = new.tolist() if one.kind.is_real else [int(value) for value in new]
                changed.append((one, whole))
            at += n
        self._set_tunable(lambda: [self.library.set(one, values) for one, values in changed])
        self._table.have_tuned(numbers)

    def _set_tunable(self, assign: Callable[[], object]) -> None:
        """Set parameters in the mode that allows it."""
        if self._table.words[HAS_EVENTS]:
            self.library.meet_event(assign)
        else:
            assign()

    def _explained(self, status: int) -> str:
        """In words, what the compiled functions found."""
        words, library = self._table.words, self.library
        exchange = self._table.exchanges[int(words[WHERE])]
        element = int(words[ELEMENT])
        kind = exchange.variables[0].kind
        if status == NOT_WHOLE:
            value = self._vectors[1][exchange.places[element]]
            takes = "0 or 1" if kind.is_boolean else f"whole numbers from {LOW[kind.code]:.0f} to {HIGH[kind.code]:.0f}"
            takes = f"numbers up to {HIGH[kind.code]:.3g}" if kind.is_real else takes
            return (
                f"its input {exchange.port_at(element)} is {value:.17g}, and the FMU takes {takes} there ({kind.name})"
            )
        if status == NOT_EXACT:
            value = exchange.values()[element]
            return (
                f"its output {exchange.port_at(element)} is {value}, beyond 2^53, which float64 does not hold exactly"
            )
        if status == REFUSED:
            verb = "Set" if exchange in self._table.sets else "Get"
            function = f"fmi{library.fmi}{verb}{kind.functions}"
            return str(library.failure(function, int(words[RETURNED]), self._blamed(exchange)))
        return f"status {status}"

    def _blamed(self, exchange: Exchange) -> str:
        """The variables of a call that failed; of those that are got, the ones that fail alone."""
        found = exchange.variables
        if exchange in self._table.gets and len(found) > 1:
            found = tuple(one for one in found if not self.library.can_get(one)) or found
        names = [f"'{one.title}'" for one in found]
        return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")

    def _answer(self, t_ns: int, dt_ns: int, what: int) -> int:
        """What the compiled step leaves to Python."""
        try:
            if what == TUNE:
                self._tune()
            elif what == MEET_EVENT:
                self.library.meet_event(self._set_discrete)
            elif what == FINISH_STEP:
                self._finish((t_ns - dt_ns) / 1e9, t_ns / 1e9)
        except BaseException as error:  # the C caller cannot pass it on; the conductor raises it again
            self._python.error = error
            return RAISED
        return 0

    def _set_discrete(self) -> None:
        """Set the inputs that change at events, whose values the compiled step has written already."""
        for one in self._table.sets:
            if one.is_discrete:
                values, at = one.values(), 0
                for variable, port in zip(one.variables, one.ports, strict=True):
                    self.library.set(variable, values[at : at + port.size])
                    at += port.size

    def _finish(self, begin_s: float, end_s: float) -> None:
        """Complete a step that the compiled function could not."""
        raise NotImplementedError
