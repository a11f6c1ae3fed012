"""The C source that an FMU's library is compiled from beside native/: its sizes, tables and formulas."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from components.contract import N_W, N_X
from pipeline.fmu.traced import Leaf, Operand, Result, Step
from pipeline.fmu.variables import SEED, Contents, Variable

BLOCKS = {"time": "TIME", "input": "INPUT", "output": "OUTPUT", "parameter": "PARAMETER"}
CONSTANTS = {"real": "REAL", "integer": "INTEGER", "boolean": "BOOLEAN", "text": "TEXT"}


def model(contents: Contents, variables: tuple[Variable, ...], token: str, step_ns: int, step_is_fixed: bool) -> str:
    """model.c: what core.h declares. variables: in the order of their value references."""
    p = contents.component.pack(contents.parameters, contents.seed)
    lengths = {
        "N_U": _count(contents.variables, "input"),
        "N_X": int(p[N_X]),
        "N_Y": _count(contents.variables, "output"),
        "N_Q": _count(contents.variables, "parameter"),
        "N_P": len(p),
        "N_W": int(p[N_W]),
        "N_VARIABLES": len(variables),
        "N_STATUS_TEXTS": len(contents.component.status_text),
    }
    starts = {role: _starts(contents.variables, role) for role in ("input", "parameter")}
    constants = {kind: _starts(contents.variables, "constant", kind) for kind in CONSTANTS}
    texts = contents.component.status_text.items()
    return "\n".join(
        [
            '#include <math.h>\n\n#include "core.h"\n',
            f"const size_t {', '.join(f'{name} = {length}' for name, length in lengths.items())};",
            f"const int64_t STEP_NS = INT64_C({step_ns});\nconst int STEP_IS_FIXED = {int(step_is_fixed)};",
            f"const char MODEL_NAME[] = {_string(contents.component.name)}, MODEL_TOKEN[] = {_string(token)};",
            _table("double MODEL_U", map(_double, starts["input"])),
            _table("double MODEL_Q", map(_double, starts["parameter"])),
            _table("double MODEL_P", map(_bound, p)),
            _table("double MODEL_REALS", map(_double, constants["real"])),
            _table("int64_t MODEL_INTEGERS", (f"INT64_C({value})" for value in constants["integer"])),
            _table("int MODEL_BOOLEANS", (str(int(value)) for value in constants["boolean"])),
            _table("char *const MODEL_TEXTS", map(_string, constants["text"])),
            _table("Limit MODEL_LIMITS", _limits(contents.variables)),
            _table("Variable MODEL_VARIABLES", map(_variable, variables)),
            _table("StatusText MODEL_STATUS_TEXTS", (f"{{{code}, {_string(text)}}}" for code, text in texts)),
            _formulas(contents.formulas.steps, contents.formulas.assigned),
        ]
    )


def _count(variables: Iterable[Variable], role: str) -> int:
    return sum(one.size for one in variables if one.role == role)


def _starts(variables: Iterable[Variable], role: str, kind: str = "real") -> list:
    return [value for one in variables if one.role == role and one.type == kind for value in one.start]


def _table(name: str, values: Iterable[str]) -> str:
    """A constant array; one without members gets a zero, which C asks for and nothing reads."""
    return f"const {name}[] = {{\n    " + (",\n    ".join(values) or "0") + ",\n};"


def _double(value: float) -> str:
    return float(value).hex()


def _bound(value: float) -> str:
    return _double(value) if np.isfinite(value) else f"{'-' if value < 0 else ''}INFINITY"


def _string(text: str) -> str:
    """A C string literal of the text's UTF-8, everything but plain characters as octal."""
    plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789 .,:;_-+*/=()[]{}<>'#"
    return '"' + "".join(c if c in plain else "".join(f"\\{b:03o}" for b in c.encode()) for c in text) + '"'


def _limits(variables: Iterable[Variable]) -> Iterable[str]:
    for one in variables:
        for bounds in one.bounds if one.role == "parameter" else ():
            flags = (bounds.low_is_open, bounds.high_is_open, one.tunable, one.name == SEED)
            yield f"{{{_bound(bounds.low)}, {_bound(bounds.high)}, {', '.join(str(int(flag)) for flag in flags)}}}"


def _variable(one: Variable) -> str:
    block = BLOCKS.get(one.role) or CONSTANTS[one.type]
    return f"{{{_string(one.name)}, {block}, {one.first}, {one.size}}}"


def _operand(operand: Operand) -> str:
    if isinstance(operand, Leaf):
        return f"q[{operand.i}]"
    return f"t[{operand.i}]" if isinstance(operand, Result) else f"({_double(operand)})"


def _expression(step: Step) -> str:
    operands = [_operand(operand) for operand in step.operands]
    match step.operation, operands:
        case "neg", [a]:
            return f"-{a}"
        case "abs", [a]:
            return f"fabs({a})"
        case sign, [a, b]:
            return f"{a} {sign} {b}"
    raise ValueError(f"no such step: {step}")


def _formulas(steps: tuple[Step, ...], assigned: dict[int, Operand]) -> str:
    lines = [f"double t[{len(steps)}];"] if steps else []
    lines += [f"t[{i}] = {_expression(step)};" for i, step in enumerate(steps)]
    lines += [f"p[{i}] = {_operand(operand)};" for i, operand in assigned.items()]
    lines += ["(void)q, (void)p;"]
    return "void model_parameters(const double *q, double *p) {\n    " + "\n    ".join(lines) + "\n}\n"
