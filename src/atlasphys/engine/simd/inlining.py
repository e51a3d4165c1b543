"""Routines as mere ingredients: their LLVM code is linked into the kernels that call them, and optimised and compiled only there.

Numba makes machine code of each compiled function, and optimises it again in every caller, and in each caller's caller. For functions that
only kernels call that is wasted, and most of the time that a kernel takes to compile.
"""

from __future__ import annotations

from typing import Any, ClassVar

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import FunctionPass, register_pass

from atlasphys.engine.simd.by_address import unchanging


class _NoEnvironment:
    """Stands for the code generator where a function's environment would be set in code that is not loaded."""

    def __init__(self, codegen: Any) -> None:
        self._codegen = codegen

    def __getattr__(self, name: str) -> Any:
        return getattr(self._codegen, name)

    def set_env(self, name: str, environment: Any) -> None:
        """Nothing to set."""


class Ingredient(JITCodeLibrary):
    """LLVM code that is never run by itself: not linked, not optimised, not loaded."""

    @property
    def codegen(self) -> Any:
        """The code generator, for Numba's bookkeeping."""
        return _NoEnvironment(self._codegen)

    def finalize(self) -> None:
        """Nothing is linked: that is left to the kernels."""
        self._raise_if_finalized()
        self._finalize_dynamic_globals()
        self._finalized = True

    def add_ir_module(self, ir_module: Any) -> None:
        """Take a function's code over."""
        for function in ir_module.functions:
            unchanging(function)
        super().add_ir_module(ir_module)

    def _optimize_functions(self, ll_module: Any) -> None:
        """Left to the kernels."""
        ll_module.data_layout = self._codegen._data_layout

    def get_pointer_to_function(self, name: str) -> int:
        """There is no machine code."""
        return 0


class Kernel(JITCodeLibrary):
    """Code with all its ingredients."""

    def finalize(self) -> None:
        """Link all that the function calls, directly or not, and compile it."""
        libraries = self._linking_libraries
        for library in libraries:  # which grows
            if isinstance(library, Ingredient):
                libraries.extend(inner for inner in library._linking_libraries if inner not in libraries)
        super().finalize()


@register_pass(mutates_CFG=False, analysis_only=True)
class _UseIngredient(FunctionPass):
    _name = "atlasphys_ingredient"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: Any) -> bool:
        """Have the function lowered into an ingredient."""
        state.library = Ingredient(state.targetctx.codegen(), state.func_id.func_qualname)
        return False


@register_pass(mutates_CFG=False, analysis_only=True)
class _UseKernel(FunctionPass):
    _name = "atlasphys_kernel"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: Any) -> bool:
        """Have the function lowered into a kernel."""
        state.library = Kernel(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return False


class _Compiler(CompilerBase):
    """Numba's pipeline, with a pass that chooses what a function is lowered into."""

    choice: ClassVar[type[FunctionPass]]

    def define_pipelines(self) -> list[Any]:
        """Numba asks for them."""
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        first, _ = passes.passes[0]
        passes.add_pass_after(self.choice, first)
        passes.finalize()
        return [passes]


class IngredientCompiler(_Compiler):
    """Makes ingredients."""

    choice = _UseIngredient


class KernelCompiler(_Compiler):
    """Makes kernels."""

    choice = _UseKernel
