"""What FMUs tell by their log callbacks: kept by instance, the last one for the error that may follow."""

from __future__ import annotations

from collections import deque
from typing import Any

KEPT = 200  # messages of an instance that wait to be taken
LONGEST = 500  # characters of one that is passed on
OK = 0


class Messages:
    """The messages of one instance."""

    def __init__(self) -> None:
        self.last = ""
        self._kept: deque[str] = deque(maxlen=KEPT)

    def add(self, status: int, text: bytes | None) -> None:
        """Take one in; what tells of nothing wrong is not passed on."""
        self.last = (text or b"").decode(errors="replace").strip()[:LONGEST]
        if status != OK:
            self._kept.append(self.last)

    def take(self) -> list[str]:
        """Those that have come since the last time, oldest first."""
        found = list(self._kept)
        self._kept.clear()
        return found


_of_instances: dict[str, Messages] = {}
_callbacks: dict[int, Any] = {}  # by version of the standard; the FMUs hold pointers into them


def register(instance: str) -> Messages:
    """Messages of the instance of this name, which are those of no earlier one."""
    _of_instances[instance] = Messages()
    return _of_instances[instance]


def callbacks(fmi: int) -> Any:
    """The callback functions of FMI 1 or 2, of which the log's is variadic: fmpy's native one formats its texts."""
    if fmi not in _callbacks:
        from ctypes import byref

        from fmpy import fmi1, fmi2
        from fmpy.logging import addLoggerProxy

        module, about = (fmi1, fmi1.fmi1CallbackFunctions) if fmi == 1 else (fmi2, fmi2.fmi2CallbackFunctions)
        found = about()
        found.logger = (fmi1.fmi1CallbackLoggerTYPE if fmi == 1 else fmi2.fmi2CallbackLoggerTYPE)(_note)
        found.allocateMemory = module.defaultCallbacks.allocateMemory
        found.freeMemory = module.defaultCallbacks.freeMemory
        addLoggerProxy(byref(found))
        _callbacks[fmi] = found
    return _callbacks[fmi]


def _note(_environment: object, instance: bytes | None, status: int, _category: object, text: bytes | None) -> None:
    found = _of_instances.get((instance or b"").decode(errors="replace"))
    for messages in [found] if found is not None else _of_instances.values():
        messages.add(status, text)
