"""The types of FMI's numbers as bytes in memory, and what each of them can hold."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import Any

EXACT = 2.0**53  # float64 holds every whole number up to here

(FLOAT64, FLOAT32, INT8, UINT8, INT16, UINT16, INT32, UINT32, INT64, UINT64, BOOL8, BOOL32) = range(12)
LARGEST_FLOAT32 = (2.0 - 2.0**-23) * 2.0**127
# What a value must lie between to be set, by code; a float64 is not asked for.
LOW = (0.0, -LARGEST_FLOAT32, -128.0, 0.0, -32768.0, 0.0, -(2.0**31), 0.0, -EXACT, 0.0, 0.0, 0.0)
HIGH = (0.0, LARGEST_FLOAT32, 127.0, 255.0, 32767.0, 65535.0, 2.0**31 - 1, 2.0**32 - 1, EXACT, EXACT, 1.0, 1.0)


@dataclass(frozen=True)
class Kind:
    """A type. functions: the part of its two functions' names behind Get and Set. code: -1 for texts."""

    name: str
    functions: str
    code: int
    c_type: Any

    @property
    def is_number(self) -> bool:
        """Whether float64 can stand for it."""
        return self.code >= 0

    @property
    def is_real(self) -> bool:
        """Whether it has a unit and need not be whole."""
        return self.code in (FLOAT64, FLOAT32)

    @property
    def is_boolean(self) -> bool:
        """Whether it is true or false."""
        return self.code in (BOOL8, BOOL32)


_OF_FMI_3 = {
    "Float64": (FLOAT64, ctypes.c_double),
    "Float32": (FLOAT32, ctypes.c_float),
    "Int8": (INT8, ctypes.c_int8),
    "UInt8": (UINT8, ctypes.c_uint8),
    "Int16": (INT16, ctypes.c_int16),
    "UInt16": (UINT16, ctypes.c_uint16),
    "Int32": (INT32, ctypes.c_int32),
    "UInt32": (UINT32, ctypes.c_uint32),
    "Int64": (INT64, ctypes.c_int64),
    "UInt64": (UINT64, ctypes.c_uint64),
    "Boolean": (BOOL8, ctypes.c_uint8),
    "String": (-1, ctypes.c_char_p),
    "Binary": (-1, ctypes.c_char_p),
}


def kinds(fmi: int) -> dict[str, Kind]:
    """The types of a version of the standard, by their names in the model description."""
    if fmi == 3:
        found = {name: Kind(name, name, *about) for name, about in _OF_FMI_3.items()}
        return found | {"Enumeration": Kind("Enumeration", "Int64", INT64, ctypes.c_int64)}
    boolean = (BOOL8, ctypes.c_uint8) if fmi == 1 else (BOOL32, ctypes.c_int32)
    return {
        "Real": Kind("Real", "Real", FLOAT64, ctypes.c_double),
        "Integer": Kind("Integer", "Integer", INT32, ctypes.c_int32),
        "Enumeration": Kind("Enumeration", "Integer", INT32, ctypes.c_int32),
        "Boolean": Kind("Boolean", "Boolean", *boolean),
        "String": Kind("String", "String", -1, ctypes.c_char_p),
    }
