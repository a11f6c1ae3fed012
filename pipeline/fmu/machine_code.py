"""The machine code of a component's two functions, for a library that needs no interpreter.

It is made from the very code that a native run executes, as optimised by numba and LLVM; only what Python would need
around it is left out, and instructions are chosen for any processor of this kind instead of this one.
"""

from __future__ import annotations

import platform
from typing import Any

import llvmlite.binding as llvm

from components.compiled import EntryPoints, bind
from components.contract import Component
from pipeline.errors import TowlineError
from pipeline.kernels import refusal

INIT, STEP = "kernel_init", "kernel_step"  # as native/core.c calls them
ANY = {"x86_64": "x86-64"}  # LLVM's name of the oldest processor of a kind; "generic" for others

_emitted: dict[int, tuple[Component, bytes]] = {}  # by identity: the code is the same whatever the parameters


def object_code(component: Component) -> bytes:
    """A relocatable object file with the hidden functions kernel_init and kernel_step, which need libc and libm only.

    Their C signature is that of native/core.c's Kernel. Raises TowlineError if the component is not compiled.
    """
    if not component.compiled:
        raise TowlineError(f"{component.name} is a Python callable; an FMU is made of compiled components only")
    if id(component) not in _emitted:
        try:
            entry = bind(component)
        except Exception as error:  # numba's are of many kinds
            raise TowlineError(f"{component.name} cannot be compiled: {refusal(error)} (--debug shows all)") from error
        _emitted[id(component)] = component, _emit(entry)
    return _emitted[id(component)][1]


def _emit(entry: EntryPoints) -> bytes:
    module = _only(entry.keep.init, INIT)
    module.link_in(_only(entry.keep.step, STEP))
    machine = _machine()
    passes = llvm.create_new_module_pass_manager()
    passes.add_global_dead_code_eliminate_pass()
    options = llvm.create_pipeline_tuning_options(speed_level=0)
    passes.run(module, llvm.create_pass_builder(machine, options))
    _rename(module)
    return machine.emit_object(module)


def _machine() -> Any:
    cpu = ANY.get(platform.machine(), "generic")
    target = llvm.Target.from_triple(llvm.get_process_triple())
    return target.create_target_machine(cpu=cpu, opt=3, reloc="pic", codemodel="small")


def _only(function: Any, name: str) -> Any:
    """The module of one of numba's C functions in which only what the function calls is visible, as `name`.

    Python's own wrapper is passed by: its name is that of the function with a prefix.
    """
    library = function._library
    module = llvm.parse_bitcode(library._get_module_for_linking().as_bitcode())
    compiled = function._wrapper_name.removeprefix("cfunc.")
    for value in (*module.functions, *module.global_variables):
        if value.name == compiled:
            value.name, value.linkage, value.visibility = name, "external", "hidden"
        elif not value.is_declaration:
            value.linkage = "internal"
    return module


def _rename(module: Any) -> None:
    """Number what is inside: numba's names count the functions that a process happened to compile before."""
    module.name = "kernels"
    for kind, values in (("function", module.functions), ("constant", module.global_variables)):
        for i, value in enumerate(values):
            if not value.is_declaration and value.name not in (INIT, STEP):
                value.name = f"{kind}_{i}"
