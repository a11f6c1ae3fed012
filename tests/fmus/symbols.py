"""Which symbols a component's object code may leave undefined, and which it does."""

from __future__ import annotations

import io

from elftools.elf.elffile import ELFFile

from components.contract import Component
from pipeline.fmu.machine_code import object_code

# Functions of C99's <math.h>, and of <string.h> that compilers put in for copies and fills.
LIBC_AND_LIBM = set(
    [
        "acos",
        "acosh",
        "asin",
        "asinh",
        "atan",
        "atan2",
        "atanh",
        "cbrt",
        "ceil",
        "copysign",
        "cos",
        "cosh",
        "erf",
        "erfc",
        "exp",
        "exp2",
        "expm1",
        "fabs",
        "floor",
        "fma",
        "fmax",
        "fmin",
        "fmod",
        "hypot",
        "ldexp",
        "frexp",
        "lgamma",
        "log",
        "log10",
        "log1p",
        "log2",
        "modf",
        "nearbyint",
        "pow",
        "remainder",
        "rint",
        "round",
        "sin",
        "sincos",
        "sinh",
        "sqrt",
        "tan",
        "tanh",
        "tgamma",
        "trunc",
        "memcpy",
        "memmove",
        "memset",
    ]
)


def undefined_symbols(component: Component) -> set[str]:
    """Names that the linker has to find elsewhere."""
    symbols = ELFFile(io.BytesIO(object_code(component))).get_section_by_name(".symtab").iter_symbols()
    return {s.name for s in symbols if s["st_shndx"] == "SHN_UNDEF" and s.name}
