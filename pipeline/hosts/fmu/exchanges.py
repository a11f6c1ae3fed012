"""The table of an instance: which variables each call sets or gets, and where their numbers are in u and y."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from components.contract import Port
from pipeline.hosts.fmu.description import CO_SIMULATION
from pipeline.hosts.fmu.kinds import FLOAT64
from pipeline.hosts.fmu.library import Library
from pipeline.hosts.fmu.table import (
    BEFORE,
    CODE,
    COLUMNS,
    CONVERTS,
    DO_STEP,
    FACTORS,
    FIRST,
    FLAGS,
    FUNCTION,
    HAS_EVENTS,
    HEAD,
    INSTANCE,
    IS_DISCRETE,
    LAST,
    N_GET,
    N_REFERENCES,
    N_SET,
    N_TUNABLE,
    N_VALUES,
    OFFSETS,
    PLACES,
    REFERENCES,
    TUNED,
    VALUES,
    VERSION,
)
from pipeline.hosts.fmu.variables import Variable


@dataclass(frozen=True)
class Exchange:
    """One call of a Set or Get function. places: of its values in u or y, in the order of the references.

    arrays: what the table points into, by column.
    """

    variables: tuple[Variable, ...]
    ports: tuple[Port, ...]
    places: np.ndarray
    first: int
    arrays: dict[int, Any]
    is_discrete: bool

    def values(self) -> list[Any]:
        """What its buffer holds, of the FMU's type."""
        return list(self.arrays[VALUES])

    def hold(self, u: np.ndarray) -> None:
        """Have its buffer hold the inputs (n_u,), as the compiled step does."""
        numbers = u[self.places]
        if self.arrays[CONVERTS]:
            numbers = (numbers - self.arrays[OFFSETS]) / self.arrays[FACTORS]
        whole = not self.variables[0].kind.is_real
        self.arrays[VALUES][:] = [int(number) for number in numbers] if whole else numbers.tolist()

    def port_at(self, element: int) -> str:
        """The name of a value, `nodes[2,1]` counted from 0 as ports are."""
        for port in self.ports:
            if element < port.size:
                place = np.unravel_index(element, port.shape) if port.shape else ()
                return port.name + (f"[{','.join(str(int(i)) for i in place)}]" if place else "")
            element -= port.size
        return "?"


class Table:
    """The words that the compiled step reads, and the memory that they point to. inputs come first."""

    def __init__(self, inputs: Sequence[tuple[Variable, Port]], outputs: Sequence[tuple[Variable, Port]], *, when: str):
        """inputs, outputs: in the order of u and y. when: which inputs are set in event mode only, "discrete", "all" or
        "none".
        """
        self.sets, self.gets = _exchanges(inputs, when), _exchanges(outputs, "none")
        self.exchanges = [*self.sets, *self.gets]
        self.words = np.zeros(HEAD + COLUMNS * len(self.exchanges), np.int64)
        self.flags, self.last = np.zeros(3, np.uint8), np.zeros(1)
        self.tuned = np.empty(0)
        self.words[HAS_EVENTS] = int(when != "none")
        self.words[[N_SET, N_GET]] = len(self.sets), len(self.gets)
        self.words[[FLAGS, LAST]] = self.flags.ctypes.data, self.last.ctypes.data
        for j, one in enumerate(self.exchanges):
            _fill(self.words[HEAD + j * COLUMNS :][:COLUMNS], one)

    @property
    def address(self) -> int:
        """Where the words are."""
        return self.words.ctypes.data

    def attach(self, library: Library) -> None:
        """Point to the functions and the instance of a library."""
        self.words[VERSION], self.words[INSTANCE] = library.fmi, library.address
        if library.interface.name == CO_SIMULATION:
            self.words[DO_STEP] = library.function("DoStep")
        for j, one in enumerate(self.exchanges):
            verb = "Set" if j < len(self.sets) else "Get"
            name = f"{verb}{one.variables[0].kind.functions}"
            self.words[HEAD + j * COLUMNS + FUNCTION] = library.function(name)

    def have_tuned(self, values: np.ndarray) -> None:
        """Note the tunable parameters that the FMU has now."""
        self.tuned = np.array(values, np.float64)
        self.words[[N_TUNABLE, TUNED]] = len(self.tuned), self.tuned.ctypes.data

    def noted(self, n_u: int) -> np.ndarray:
        """The inputs noted last, NaN where there are none: (n_u,)."""
        u = np.full(n_u, np.nan)
        for one in self.sets:
            u[one.places] = one.arrays[BEFORE]
        return u

    def note_inputs(self, u: np.ndarray) -> None:
        """Note the inputs that the FMU has now; event mode sets those that rest again with any that changes."""
        for one in self.sets:
            one.arrays[BEFORE][:] = u[one.places]
            if one.is_discrete:
                one.hold(u)


def _exchanges(ports: Sequence[tuple[Variable, Port]], when: str) -> list[Exchange]:
    """Calls, one a type; those of variables that are set in event mode only are apart."""
    groups: dict[tuple[str, bool], list[tuple[Variable, Port, int]]] = {}
    at = 0
    for one, port in ports:
        is_discrete = when == "all" or (when == "discrete" and (one.is_discrete or not one.kind.is_real))
        if port.size:
            groups.setdefault((one.kind.functions, is_discrete), []).append((one, port, at))
        at += port.size
    return [_exchange(members, is_discrete=key[1]) for key, members in groups.items()]


def _exchange(members: list[tuple[Variable, Port, int]], *, is_discrete: bool) -> Exchange:
    places = np.concatenate([np.arange(at, at + port.size) for _, port, at in members]).astype(np.int64)
    kind = members[0][0].kind
    factors = np.repeat([one.unit.factor for one, _, _ in members], [port.size for _, port, _ in members])
    offsets = np.repeat([one.unit.offset for one, _, _ in members], [port.size for _, port, _ in members])
    converts = any(not one.unit.is_none for one, _, _ in members)
    together = bool((np.diff(places) == 1).all())
    is_direct = kind.code == FLOAT64 and together and not converts and not is_discrete
    references = np.array([reference for one, _, _ in members for reference in one.references], np.uint32)
    arrays = {
        REFERENCES: references,
        VALUES: (kind.c_type * len(places))(),
        PLACES: places,
        FACTORS: factors.astype(np.float64),
        OFFSETS: offsets.astype(np.float64),
        BEFORE: np.full(len(places), np.nan),
        CODE: kind.code,
        CONVERTS: int(converts),
    }
    variables, ports = tuple(one for one, _, _ in members), tuple(port for _, port, _ in members)
    return Exchange(variables, ports, places, int(places[0]) if is_direct else -1, arrays, is_discrete)


def _fill(row: np.ndarray, one: Exchange) -> None:
    for column, array in one.arrays.items():
        if isinstance(array, int):
            row[column] = array
        else:
            row[column] = array.ctypes.data if isinstance(array, np.ndarray) else ctypes.addressof(array)
    row[N_REFERENCES], row[N_VALUES] = len(one.arrays[REFERENCES]), len(one.places)
    row[FIRST], row[IS_DISCRETE] = one.first, int(one.is_discrete)
