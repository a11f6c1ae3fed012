"""An FMU's library loaded by fmpy, and one instance of it: what differs between the versions of the standard."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from pipeline.hosts.fmu.component import FmuComponent
from pipeline.hosts.fmu.description import MODEL_EXCHANGE, FmuError
from pipeline.hosts.fmu.messages import Messages, callbacks, register
from pipeline.hosts.fmu.variables import Variable

STATUSES = ("ok", "warning", "discard", "error", "fatal", "pending")
DISCARD, ERROR, FATAL = 2, 3, 4
LAST_SUCCESSFUL_TIME, TERMINATED = 2, 3  # of fmi2GetRealStatus and fmi2GetBooleanStatus
CALLS = 1000  # updates of discrete states at one instant; an FMU that needs more never comes to rest
WORTH_SAYING = ("warning", "error", "fatal", "discard")


class CallError(FmuError):
    """A function of an FMU failed. status: as it returned it."""

    def __init__(self, text: str, status: int):
        super().__init__(text)
        self.status = status


class Library:
    """One instance of an FMU. is_lost: after an error that leaves nothing but to let it go. is_dead: after
    a fatal one, which forbids even that.

    next_event_s: when the FMU wants its next event, as it last said; None for never.
    """

    def __init__(self, component: FmuComponent, folder: Path, name: str):
        """Load the library from the extracted FMU. Raises FmuError."""
        self._component, self.description, self.name = component, component.description, name
        self.interface = component.interface
        self.fmi = self.description.fmi
        self.messages: Messages = register(name)
        self.is_lost = self.is_dead = self.is_instantiated = False
        self.next_event_s: float | None = None
        self._fmu = self._load(folder)

    def _load(self, folder: Path) -> Any:
        from fmpy import fmi1, fmi2, fmi3

        is_exchange = self.interface.name == MODEL_EXCHANGE
        kinds = {1: fmi1.FMU1Slave, 2: fmi2.FMU2Model if is_exchange else fmi2.FMU2Slave}
        kinds[3] = fmi3.FMU3Model if is_exchange else fmi3.FMU3Slave
        before = os.getcwd()
        try:
            return kinds[self.fmi](
                guid=self.description.token,
                unzipDirectory=str(folder),
                modelIdentifier=self.interface.identifier,
                instanceName=self.name,
            )
        except Exception as error:  # the linker's among them
            text = (str(error).splitlines() or [type(error).__name__])[0]
            raise FmuError(f"{self.description.path.name} cannot be loaded: {text}{self._needs()}") from error
        finally:
            os.chdir(before)  # fmpy leaves it elsewhere where loading fails

    def _needs(self) -> str:
        """What may be missing on this machine, as the end of a sentence."""
        tool = "; it needs the tool that made it on this machine (needsExecutionTool)"
        return tool if self.interface.needs_tool else ""

    @property
    def address(self) -> int:
        """Of the instance."""
        return int(getattr(self._fmu.component, "value", self._fmu.component) or 0)

    def function(self, name: str) -> int:
        """The address of one of its C functions, by its name behind the prefix."""
        prefix = {1: f"{self.interface.identifier}_fmi", 2: "fmi2", 3: "fmi3"}[self.fmi]
        return ctypes.cast(self._fmu.dll[f"{prefix}{name}"], ctypes.c_void_p).value or 0

    def instantiate(self) -> None:
        """Make the instance. Raises FmuError."""
        try:
            self._instantiate()
        except FmuError as error:
            if self.address:
                raise
            text = "cannot be instantiated: its library and description may be of different makes"
            said = f"{self._needs()}{self.last_words()}"
            raise FmuError(f"{self.description.path.name} {text}{said}") from error
        self.is_instantiated = True
        self._choose_messages()

    def _instantiate(self) -> None:
        has_events = self.interface.has_events
        if self.fmi == 1:
            self._do(self._fmu.instantiate, functions=callbacks(1), loggingOn=True)
        elif self.fmi == 2:
            self._do(self._fmu.instantiate, callbacks=callbacks(2), loggingOn=True)
        elif self.interface.name == MODEL_EXCHANGE:
            self._do(self._fmu.instantiate, loggingOn=True, logMessage=self._note)
        else:
            early = has_events or self.interface.returns_early
            self._do(
                self._fmu.instantiate,
                loggingOn=True,
                eventModeUsed=has_events,
                earlyReturnAllowed=early,
                logMessage=self._note,
            )
        if not self.address:
            raise FmuError("no instance")

    def _note(self, _environment: object, status: int, _category: object, text: bytes) -> None:
        self.messages.add(status, text)

    def _choose_messages(self) -> None:
        """Have warnings and errors told and nothing else, where the FMU can tell them apart."""
        wanted = [name for name in self.description.categories if any(one in name.lower() for one in WORTH_SAYING)]
        if self.fmi == 1 or not wanted:
            return
        try:
            self._fmu.setDebugLogging(False, [])
            self._fmu.setDebugLogging(True, wanted)
        except Exception:  # an FMU without this function tells all, or nothing
            return

    def _do(self, call: Callable[..., Any], *arguments: Any, **named: Any) -> Any:
        """Call one of fmpy's methods. Raises FmuError, with the FMU's last message."""
        from fmpy.fmi1 import FMICallException

        try:
            return call(*arguments, **named)
        except FMICallException as error:
            raise self.failure(error.function, error.status) from error
        except Exception as error:
            text = (str(error).splitlines() or [type(error).__name__])[0]
            raise FmuError(f"{self.description.path.name}: {text}{self.last_words()}") from error

    def failure(self, function: str, status: int, what: str = "") -> CallError:
        """The error that a status of one of its functions stands for."""
        self.is_lost = self.is_lost or status >= ERROR
        self.is_dead = self.is_dead or status == FATAL
        name = function.replace("fmi1", "fmi")
        said = STATUSES[status] if 0 <= status < len(STATUSES) else f"status {status}, which the standard does not know"
        where = f" for {what}" if what else ""
        return CallError(f"{name} of {self.description.path.name} returned {said}{where}{self.last_words()}", status)

    def last_words(self) -> str:
        """Its last message, as the end of a sentence."""
        return f" (its last message: {self.messages.last})" if self.messages.last else ""

    def set(self, one: Variable, values: Sequence[Any]) -> None:
        """Give a variable its values, as the FMU has them. Raises FmuError."""
        if one.kind.name == "Binary":
            values = [bytes.fromhex(value) for value in values]
        try:
            self._do(getattr(self._fmu, f"set{one.kind.functions}"), list(one.references), list(values))
        except CallError as error:
            raise self.failure(f"fmi{self.fmi}Set{one.kind.functions}", error.status, f"'{one.title}'") from error

    def can_get(self, one: Variable) -> bool:
        """Whether a variable's values can be had, which the standard allows after an error too."""
        number = {"nValues": one.size} if self.fmi == 3 else {}
        try:
            self._do(getattr(self._fmu, f"get{one.kind.functions}"), list(one.references), **number)
        except FmuError:
            return False
        return True

    def configure(self, structural: Sequence[tuple[Variable, Sequence[Any]]]) -> None:
        """Set structural parameters, which decide the lengths of arrays."""
        if structural:
            self._do(self._fmu.enterConfigurationMode)
            for one, values in structural:
                self.set(one, values)
            self._do(self._fmu.exitConfigurationMode)

    def begin(self, start_s: float) -> None:
        """Enter initialization mode; FMI 1 has none."""
        tolerance = self.description.tolerance
        if self.fmi == 2:
            self._do(self._fmu.setupExperiment, tolerance=tolerance, startTime=start_s)
            self._do(self._fmu.enterInitializationMode)
        elif self.fmi == 3:
            self._do(self._fmu.enterInitializationMode, tolerance=tolerance, startTime=start_s)

    def end_initialization(self, start_s: float) -> None:
        """Be ready to step: out of initialization mode, events of the start done."""
        if self.fmi == 1:
            self._do(self._fmu.initialize, tStart=start_s)
            return
        self._do(self._fmu.exitInitializationMode)
        if self.interface.name == MODEL_EXCHANGE:
            self.update_discrete_states()
            self._do(self._fmu.enterContinuousTimeMode)
        elif self.interface.has_events:
            self.update_discrete_states()
            self._do(self._fmu.enterStepMode)

    def meet_event(self, discrete: Callable[[], object]) -> None:
        """Go through event mode, setting discrete inputs in it by the function given."""
        self._do(self._fmu.enterEventMode)
        discrete()
        self.update_discrete_states()
        is_exchange = self.interface.name == MODEL_EXCHANGE
        self._do(self._fmu.enterContinuousTimeMode if is_exchange else self._fmu.enterStepMode)

    def update_discrete_states(self) -> None:
        """Iterate over its discrete states until they rest. Raises FmuError."""
        update = self._fmu.newDiscreteStates if self.fmi == 2 else self._fmu.updateDiscreteStates
        for _ in range(CALLS):
            needed, terminate, _, _, has_next, next_s = self._do(update)
            self.next_event_s = next_s if has_next else None
            if terminate:
                raise FmuError(f"{self.description.path.name} ends the simulation at an event{self.last_words()}")
            if not needed:
                return
        raise FmuError(f"{self.description.path.name} does not come to rest at an event, after {CALLS} updates")

    @property
    def model(self) -> Any:
        """fmpy's model, for its solver."""
        return self._fmu

    @property
    def states(self) -> int:
        """How many continuous states a model exchange FMU has."""
        return self.description.states if self.fmi == 2 else self._do(self._fmu.getNumberOfContinuousStates)

    def set_time(self, t_s: float) -> None:
        """Tell a model exchange FMU the time."""
        self._do(self._fmu.setTime, t_s)

    def completed_step(self) -> bool:
        """Tell it that the solver has made a step; whether it wants an event."""
        if not self.interface.needs_completed_steps:
            return False
        wants_event, terminates = self._do(self._fmu.completedIntegratorStep)
        if terminates:
            raise FmuError(f"{self.description.path.name} ends the simulation{self.last_words()}")
        return wants_event

    def last_successful_time(self) -> float:
        """Where a step that was discarded ended; FMI 1 and 2."""
        found = ctypes.c_double()
        get = self._raw("GetRealStatus", ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p)
        if get(self.address, LAST_SUCCESSFUL_TIME, ctypes.addressof(found)) > 1:
            raise FmuError(f"{self.description.path.name} discards a step and does not say where{self.last_words()}")
        return found.value

    def is_terminated(self) -> bool:
        """Whether an FMU of FMI 2 discarded the step because it wants no more of them."""
        if self.fmi != 2:
            return False
        found = ctypes.c_int()
        get = self._raw("GetBooleanStatus", ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p)
        return get(self.address, TERMINATED, ctypes.addressof(found)) <= 1 and bool(found.value)

    def _raw(self, name: str, *takes: Any) -> Any:
        return ctypes.CFUNCTYPE(ctypes.c_int, *takes)(self.function(name))

    def save(self) -> bytes:
        """Its state as bytes. Raises FmuError."""
        state = self._do(self._fmu.getFMUState)
        try:
            return bytes(self._do(self._fmu.serializeFMUState, state))
        finally:
            self._do(self._fmu.freeFMUState, state)

    def restore(self, data: bytes) -> None:
        """Have the state that save() gave. Raises FmuError."""
        state = self._do(self._fmu.deserializeFMUState, data)
        try:
            self._do(self._fmu.setFMUState, state)
        finally:
            self._do(self._fmu.freeFMUState, state)

    def free(self) -> None:
        """Let the instance go. The library stays loaded: unloading what started threads of its own can crash."""
        if not self.is_instantiated:
            return
        self.is_instantiated = False
        if self.is_dead:
            return
        if self.fmi == 1:
            self._let_go(self._fmu.terminate, lambda: self._fmu.fmi1FreeSlaveInstance(self._fmu.component))
        elif self.fmi == 2:
            self._let_go(self._fmu.terminate, lambda: self._fmu.fmi2FreeInstance(self._fmu.component))
        else:
            self._let_go(self._fmu.terminate, lambda: self._fmu.fmi3FreeInstance(self._fmu.component))

    def _let_go(self, terminate: Callable[[], Any], release: Callable[[], Any]) -> None:
        try:
            if not self.is_lost:
                terminate()
        except Exception:  # it is let go all the same
            self.is_lost = True
        release()
