"""Compilation of a kernel as a part of others: it stays LLVM's code, which is optimised where it ends up."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import _dynfunc, types  # pyright: ignore[reportAttributeAccessIssue]
from numba.core.codegen import CPUCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import LoweringPass, PassManager, register_pass
from numba.core.registry import CPUDispatcher
from numba.core.typed_passes import NativeLowering


class PartLibrary(CPUCodeLibrary):
    """The code of a kernel and of those it calls, to be linked into another library.

    numba's own is optimised and made into machine code at each level of calls, together with all levels below it.
    """

    def _optimize_final_module(self) -> None:
        """Leave it to the library that this one is linked into."""

    def _finalize_final_module(self) -> None:
        """Keep it out of the engine, which would make machine code of it."""
        self._finalized = True


@register_pass(mutates_CFG=False, analysis_only=False)
class Insertion(LoweringPass):
    """Makes a part known to its callers, by an object in the place of the function that Python could call."""

    _name = "part_insertion"

    def __init__(self) -> None:
        """As numba makes every pass."""
        super().__init__()

    def run_pass(self, state: Any) -> bool:
        """Name the part in what lowering has left."""
        lowered = state["cr"]
        module, name = lowered.fndesc.lookup_module(), state.func_id.func_name
        key = _dynfunc.make_function(module, name, "", 0, lowered.env, (state.library,))
        state.targetctx.insert_user_function(key, lowered.fndesc, [state.library])
        state["cr"] = lowered._replace(cfunc=key)
        return True


class PartCompiler(CompilerBase):
    """numba's compiler as far as LLVM's code."""

    def define_pipelines(self) -> list[PassManager]:
        """The only one."""
        self.state.flags.no_compile = True
        self.state.library = PartLibrary(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state, "part")
        passes.add_pass_after(Insertion, NativeLowering)
        passes.finalize()
        return [passes]


class Part(CPUDispatcher):
    """A function that compiled ones call, compiled once for each set of argument types.

    numba would compile it anew for each constant that it is called with; LLVM sees the constants all the same.
    """

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]):
        """options: numba's, for njit."""
        bare = {"nopython": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        super().__init__(function, targetoptions={**options, **bare}, pipeline_class=PartCompiler)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """As numba calls it to find the type of a call."""
        general = {name: types.unliteral(kind) for name, kind in kws.items()}
        return super().get_call_template([types.unliteral(kind) for kind in args], general)
