"""Runs a model exchange FMU: its derivatives integrated by CVode, through fmpy, with state, time and step events.

Inputs are held over a period and may jump between two, which is an event. The solver begins anew with each period,
so that nothing of it has to be saved: the whole state is the FMU's.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from fmpy.sundials import CVodeSolver

from pipeline.hosts.fmu.component import FmuComponent
from pipeline.hosts.fmu.description import FmuError
from pipeline.hosts.fmu.instance import Instance
from pipeline.hosts.fmu.library import CALLS, DISCARD, Library
from pipeline.hosts.fmu.table import CALLS_MADE

# Relative; absolute it is this times the nominal values. A solver that begins anew leaves an error of a few tolerances
# with each period, so it is a thousandth of what the FMU's default experiment wants of the whole.
TOLERANCE = 1e-9
PER_PERIOD = 1e-3
MOST_STEPS = 100_000  # of the solver within a period
REACHED_NS = 0.5  # times are whole nanoseconds
RECOVERABLE, FAILED = 1, -1  # to CVode: try a shorter step; give up


class _Held:
    """Inputs as the solver wants them: held."""

    @staticmethod
    def apply(_t: float) -> None:
        """Nothing changes within a period."""


class Solver(CVodeSolver):
    """CVode on an FMU. failure: why a function of the FMU failed within it."""

    def __init__(self, library: Library, start_s: float):
        """Of an instance in continuous-time mode."""
        self.failure: Exception | None = None
        fmu = library.model
        super().__init__(
            nx=library.states,
            nz=library.description.indicators,
            get_x=fmu.getContinuousStates,
            set_x=fmu.setContinuousStates,
            get_dx=fmu.getDerivatives if library.fmi == 2 else fmu.getContinuousStateDerivatives,
            get_z=fmu.getEventIndicators,
            get_nominals=fmu.getNominalsOfContinuousStates,
            set_time=fmu.setTime,
            input=_Held,
            startTime=start_s,
            relativeTolerance=PER_PERIOD * (library.description.tolerance or 0.0) or TOLERANCE,
            maxNumSteps=MOST_STEPS,
        )

    def __del__(self) -> None:
        """Free CVode, if it came to that before the FMU refused its states."""
        if hasattr(self, "cvode_mem"):
            super().__del__()

    def f(self, t: float, y: Any, ydot: Any, user_data: Any) -> int:
        """Derivatives; one that the FMU discards makes CVode try a shorter step."""
        return self._guarded(super().f, t, y, ydot, user_data)

    def g(self, t: float, y: Any, gout: Any, user_data: Any) -> int:
        """Event indicators."""
        return self._guarded(super().g, t, y, gout, user_data)

    def _guarded(self, function: Any, *arguments: Any) -> int:
        try:
            return function(*arguments)
        except Exception as error:  # the C caller cannot pass it on
            self.failure = error
            return RECOVERABLE if getattr(error, "status", None) == DISCARD else FAILED


class Exchange(Instance):
    """A model exchange FMU in this process."""

    _solver: Solver | None = None

    @staticmethod
    def _when(component: FmuComponent) -> str:
        return "all"

    def _begin(self, start_s: float) -> None:
        self._solver = None
        super()._begin(start_s)

    def _advance(self, t_ns: int, dt_ns: int, *vectors: np.ndarray) -> int:
        self._table.words[CALLS_MADE] += 1
        begin_s, end_s = (t_ns - dt_ns) / 1e9, t_ns / 1e9
        if self._needs_tuning():
            self._tune()
        self._exchange("fmu_inputs", t_ns, dt_ns)
        self._integrate(begin_s, end_s)
        self._exchange("fmu_outputs", t_ns, dt_ns)
        self._table.words[CALLS_MADE] += 1
        return 0

    def _needs_tuning(self) -> bool:
        return not np.array_equal(self._tunable_numbers(), self._table.tuned)

    def _integrate(self, at_s: float, end_s: float) -> None:
        """From one instant to another, through the events between. Raises FmuError."""
        library = self.library
        solver = self._solver = self._solver or Solver(library, at_s)
        solver.reset(at_s)
        stands = 0
        while (end_s - at_s) * 1e9 >= REACHED_NS:
            next_s = library.next_event_s
            until_s = end_s if next_s is None or next_s > end_s else max(next_s, at_s)
            reached_s, is_event = at_s, False
            if until_s > at_s:
                is_event, reached_s = self._leap(solver, at_s, until_s)
            stands = 0 if reached_s > at_s else stands + 1
            if stands > CALLS:
                raise FmuError(f"{self.file} makes no progress at {at_s:.9g} s, after {CALLS} events there")
            at_s = reached_s
            is_event |= library.completed_step()
            is_event |= next_s is not None and at_s >= next_s
            if is_event:
                library.meet_event(lambda: None)
                solver.reset(at_s)
        library.set_time(end_s)

    def _leap(self, solver: Solver, at_s: float, until_s: float) -> tuple[bool, float]:
        """(whether an event indicator crossed zero, where that was or the end)."""
        try:
            crossed, _, reached_s = solver.step(at_s, until_s)
        except RuntimeError as error:
            why = solver.failure
            if why is not None:
                raise self._failed(why) from why
            raise FmuError(f"{self.file} cannot be integrated beyond {at_s:.9g} s: {error}") from error
        solver.failure = None
        self.library.set_time(reached_s)
        return crossed, reached_s

    def _failed(self, why: Exception) -> Exception:
        function, status = getattr(why, "function", ""), getattr(why, "status", -1)
        return self.library.failure(function, status) if function else why
