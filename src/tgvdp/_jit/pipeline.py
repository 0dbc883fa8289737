"""How kernels are compiled: numba's own steps, without those that kernels have no use for.

numba turns each function into optimised machine code of its own, with a wrapper for Python, before its callers link it
in, optimise it again, and so on up the call tree. What kernels call needs none of that: it is compiled to LLVM's
intermediate code, and optimised once, within the kernel at the top of the tree.

All of it stands on numba's inner parts, so only the versions that it was tested with use it (`tgvdp._jit.steps`).
"""

import contextlib
import gc
import threading
from collections.abc import Callable
from typing import Any

import numba
from numba.core import config, typed_passes, untyped_passes
from numba.core.codegen import CodeLibrary, JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.typed_passes import NativeLowering
from numba.core.types.misc import unliteral

from tgvdp._jit import shortcuts
from tgvdp._jit.arguments import by_address, call_of
from tgvdp._jit.builder import raises
from tgvdp._jit.lowering import KernelLower
from tgvdp._jit.optimise import is_small, optimise, vectorise, written
from tgvdp._jit.shortcuts import KernelPasses

#: Steps for closures, generators, exceptions, context managers, literals, object mode, array expressions, and inlining
#: by numba: kernels have none of these. Each costs an analysis of the whole function.
_NEEDLESS = {
    untyped_passes.WithLifting,
    untyped_passes.InlineClosureLikes,
    untyped_passes.RewriteDynamicRaises,
    untyped_passes.MakeFunctionToJitFunction,
    untyped_passes.InlineInlinables,
    untyped_passes.DeadBranchPrune,
    untyped_passes.FindLiterallyCalls,
    untyped_passes.LiteralUnroll,
    untyped_passes.LiteralPropagationSubPipelinePass,
    typed_passes.IRLegalization,
    typed_passes.InlineOverloads,
    typed_passes.NopythonRewrites,
    typed_passes.NoPythonSupportedFeatureValidation,
    typed_passes.DumpParforDiagnostics,
}


class _KernelLibrary(JITCodeLibrary):  # type: ignore[misc]
    """Machine code of a kernel: optimised in one go, for there are no reference counts to be removed first.

    What it calls becomes its own: LLVM drops arguments that go unused, most words of a train, only where it sees all
    calls. Runs are driven in two thirds of the time so.
    """

    def _optimize_functions(self, ll_module: Any) -> None:
        ll_module.data_layout = self._codegen._data_layout

    def _optimize_final_module(self) -> None:
        others = [one.known for one in self._linking_libraries if isinstance(one, _LinkedLibrary)]
        optimise(self._final_module, self._codegen._tm, [self.known, *others])

    def written(self, function: Any) -> None:
        """Take note of a function that was written for this library, before LLVM reads it."""
        self.known = written(function)


class _LinkedLibrary(_KernelLibrary):
    """Intermediate code for kernels to link in, together with that of all functions that it calls."""

    def __init__(self, codegen: Any, name: str) -> None:
        super().__init__(codegen, name)
        self.calls: dict[CodeLibrary, None] = {}  # in order
        self.raises = True

    def written(self, function: Any) -> None:
        self.raises = raises(function)
        if is_small(function):
            function.attributes.add("alwaysinline")
        super().written(function)

    def add_linking_library(self, library: CodeLibrary) -> None:
        self.calls[library] = None

    def finalize(self) -> None:
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage.name == "external":
                function.linkage = "linkonce_odr"
        self._shared_module = self._final_module  # numba would copy it first: it would run this one
        self._finalize_dynamic_globals()
        self._finalized = True


class _VectorLibrary(_LinkedLibrary):
    """Intermediate code of a loop, optimised by itself: what it calls is inlined, and it runs in vector registers."""

    def finalize(self) -> None:
        for library in self.calls:
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self.calls = {}
        vectorise(self._final_module, self._codegen._tm)
        super().finalize()


@register_pass(mutates_CFG=True, analysis_only=False)
class _KernelLowering(NativeLowering):  # type: ignore[misc]
    _name = "kernel_lowering"
    lowering_class = KernelLower

    def run_pass(self, state: Any) -> bool:
        state.library = _KernelLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return bool(super().run_pass(state))


@register_pass(mutates_CFG=True, analysis_only=False)
class _LinkedLowering(NativeLowering):  # type: ignore[misc]
    """`NativeLowering` without its end: machine code."""

    _name = "linked_lowering"
    lowering_class = KernelLower
    library_class = _LinkedLibrary

    def run_pass(self, state: Any) -> bool:
        library = state.library = self.library_class(state.targetctx.codegen(), state.func_id.func_qualname)
        state.flags.no_compile = True
        super().run_pass(state)
        entry_point = object()  # callers only tell it from others
        call = call_of(state.cr.fndesc, [library, *library.calls], raises=library.raises)
        state.targetctx.insert_func_defn([(call, entry_point, call.signature)])
        state.cr = state.cr._replace(cfunc=entry_point)
        return True


@register_pass(mutates_CFG=True, analysis_only=False)
class _VectorLowering(_LinkedLowering):
    _name = "vector_lowering"
    library_class = _VectorLibrary


class _KernelCompiler(CompilerBase):  # type: ignore[misc]
    """Compiles what Python calls."""

    lowering: type[NativeLowering] = _KernelLowering

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.state.targetctx = by_address(self.state.targetctx)

    def define_pipelines(self) -> list[PassManager]:
        passes = KernelPasses("kernel")
        for one, text in DefaultPassBuilder.define_nopython_pipeline(self.state).passes:
            if one not in _NEEDLESS:
                passes.add_pass(self.lowering if one is NativeLowering else one, text)
        passes.finalize()
        return [passes]


class _LinkedCompiler(_KernelCompiler):
    """Compiles what kernels call, to be linked into them."""

    lowering = _LinkedLowering


class _VectorCompiler(_KernelCompiler):
    """Compiles loops that kernels call."""

    lowering = _VectorLowering


class _QuickCompilation(contextlib.ContextDecorator):
    """Compiles without garbage collections, by `shortcuts`, and what is not `optimise`'s by LLVM's first level.

    That is what allocates, and functions of numba's; it runs no slower so. Compilations nest; numba lets one thread
    compile at a time.
    """

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._depth = 0
        self._before: tuple[Any, bool] = (config.OPT, False)
        self._shortcuts: contextlib.AbstractContextManager[None] = contextlib.nullcontext()

    def __enter__(self) -> None:
        self._lock.acquire()
        self._depth += 1
        if self._depth == 1:
            self._before = (config.OPT, gc.isenabled())
            config.OPT = config._OptLevel(min(int(config.OPT), 1))
            gc.disable()
            self._shortcuts = shortcuts.taken()
            self._shortcuts.__enter__()

    def __exit__(self, *_: object) -> None:
        self._depth -= 1
        if self._depth == 0:
            self._shortcuts.__exit__(None, None, None)
            config.OPT, collecting = self._before
            if collecting:
                gc.freeze()
                gc.unfreeze()  # all that was made is old now: a look through so many young objects takes 0.2 s
                gc.enable()
        self._lock.release()


quick_compilation = _QuickCompilation()


def compiled_and_linked(function: Callable[..., Any], *, is_loop: bool = False, **options: Any) -> tuple[Any, Any]:
    """Return the dispatcher of a function for Python, and that of what is linked into the kernels that call it.

    That of a loop runs in vector registers. The latter is compiled once, not once for each constant that callers pass:
    numba specialises on literal integers. Nothing is allocated in kernels, so that they need none of the reference
    counts that numba keeps (``_nrt``).
    """
    options |= {"_nrt": False}
    compiled: Any = numba.njit(pipeline_class=_KernelCompiler, **options)(function)
    compiler = _VectorCompiler if is_loop else _LinkedCompiler
    linked: Any = numba.njit(pipeline_class=compiler, no_cpython_wrapper=True, **options)(function)
    linked.add_overload = lambda result: linked.overloads.__setitem__(tuple(result.signature.args), result)

    def get_call_template(args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
        plain = {name: unliteral(kind) for name, kind in kws.items()}
        return linked.get_call_template(tuple(unliteral(kind) for kind in args), plain)

    compiled.get_call_template = get_call_template
    compiled.get_overload = linked.get_overload
    compiled.linked = linked
    return compiled, linked
