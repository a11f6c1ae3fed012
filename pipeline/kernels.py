"""What keeps a component's functions from being kernels: their kind, raising, and what numba refuses, in one line."""

from __future__ import annotations

import dis
import inspect
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from types import CodeType, FunctionType, ModuleType

from components.contract import Component
from pipeline import installation

ARGUMENTS = "t_ns, dt_ns, p, u, x, y, w"  # and images_in, images_out where there are images
_RAISE = dis.opmap["RAISE_VARARGS"]  # what `raise` and `assert` are compiled to
_NOISE = re.compile(r"Failed in|During|- Resolution|- Of which|>>>|File |None$|There are")
_CALL = re.compile(r">>> (.+)")
_PLACE = re.compile(r"at (.+?\.py) \((\d+)\)")
_ALLOCATES = ("NRT required", "Only accept returning of array passed")  # numba without its runtime


def fault(component: Component) -> str:
    """Why its init and step cannot be compiled, and what would be right; "" where nothing is known to be wrong.

    A kernel that raises would only print a traceback: its C function returns 0, and the run would go on.
    """
    for name in ("init", "step"):
        function = getattr(component, name)
        if not callable(function) or (component.compiled and not isinstance(function, FunctionType)):
            what = "a plain function, made by def" if component.compiled else "a function"
            return f"{name} is a {type(function).__name__}; expected {what}"
        if not any(_takes(function, count) for count in ((7,) if component.compiled else (7, 9))):
            return f"{name} does not take the arguments of a component; expected def {name}({ARGUMENTS})"
    for function in _reached(component) if component.compiled else ():
        line = _raising_line(function.__code__)
        if line:
            where = f"{function.__name__} at line {line} of {Path(function.__code__.co_filename).name}"
            remedy = "return a positive status and explain it in status_text"
            return f"{where} raises, and a compiled kernel cannot raise; {remedy}"
    return ""


def calls_kernels(component: Component) -> bool:
    """Whether its init or step calls a compiled function by name."""
    return set(_reached(component)) != {component.init, component.step}


def _takes(function: Callable[..., object], count: int) -> bool:
    try:
        inspect.signature(function).bind(*range(count))
    except TypeError:
        return False
    except ValueError:  # a callable that does not tell
        return True
    return True


def refusal(error: Exception) -> str:
    """Why numba did not compile a kernel, in one line, with the place in the component's source if it tells."""
    if of_the_disk := installation.told(error):
        return of_the_disk
    text = str(error)
    lines = [line.strip() for line in text.splitlines()]
    said = [line for line in lines if line and not _NOISE.match(line)]
    reason = said[0].partition(" for '$")[0] if said else type(error).__name__
    if reason.endswith("signature:") and (call := _CALL.search(text)):
        reason = f"{reason} {call[1]}"
    if any(sign in text for sign in _ALLOCATES):
        reason = f"it allocates memory, which a kernel may not ({reason})"
    return reason[:300] + _place(text)


def names_in(component: Component) -> set[str]:
    """All names that the component's functions and the kernels they call use."""
    reached = _reached(component) if component.compiled else ()
    return {name for function in reached for code in _codes(function.__code__) for name in code.co_names}


def _place(text: str) -> str:
    """The innermost place that numba names outside its own sources and the generated binding."""
    for path, line in _PLACE.findall(text):
        if "site-packages" not in path and not Path(path).name.startswith("bind_"):
            return f", line {line} of {Path(path).name}"
    return ""


def _reached(component: Component) -> Iterator[FunctionType]:
    """init, step and all kernels that they call by name, each once."""
    found = [function for function in (component.init, component.step) if isinstance(function, FunctionType)]
    for function in found:
        yield function
        found.extend(callee for callee in _callees(function) if callee not in found)


def _callees(function: FunctionType) -> Iterator[FunctionType]:
    """The Python functions of the compiled ones that a function names, of its module, its closure or another module."""
    names = {name for code in _codes(function.__code__) for name in (*code.co_names, *code.co_freevars)}
    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    scope = function.__globals__ | {name: cell.cell_contents for name, cell in cells}
    values = [scope[name] for name in sorted(names) if name in scope]
    modules = [value for value in values if isinstance(value, ModuleType)]
    values += [vars(module)[name] for module in modules for name in sorted(names) if name in vars(module)]
    for value in values:
        python = getattr(value, "py_func", None)  # numba's compiled functions have it
        if isinstance(python, FunctionType):
            yield python


def _codes(code: CodeType) -> Iterator[CodeType]:
    """A function's code and that of the functions inside it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


def _raising_line(function: CodeType) -> int:
    """The first line with a raise or an assert; 0 where there is none."""
    for code in _codes(function):
        if _RAISE in code.co_code[::2]:
            return next(
                i.positions.lineno or 0 for i in dis.get_instructions(code) if i.opcode == _RAISE and i.positions
            )
    return 0
