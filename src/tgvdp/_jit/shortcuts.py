"""Shortcuts through numba's analyses, taken while kernels are compiled: the same results in fewer steps."""

import contextlib
from collections.abc import Callable, Iterator
from typing import Any

from numba.core import errors as numba_errors
from numba.core import ir, postproc, ssa, transforms, typed_passes, types, untyped_passes
from numba.core.compiler_machinery import PassManager
from numba.core.cpu import CPUContext
from numba.core.typing.context import Context as TypingContext

errors: Any = numba_errors
#: What statements are made of that holds no variables.
_BARE = {str, int, float, bool, type(None), ir.Loc}
#: Steps that compute again and again how long variables live: to count references, which kernels do not.
_COUNTING = (
    untyped_passes.IRProcessing,
    untyped_passes.GenericRewrites,
    untyped_passes.ReconstructSSA,
    typed_passes.PreLowerStripPhis,
)


class KernelPasses(PassManager):  # type: ignore[misc]
    """Runs the steps of a compilation, without measuring and checking them."""

    def _runPass(self, index: int, step: Any, state: Any) -> None:
        step.analysis = self._analysis
        with _replaced(_CANONICAL) if isinstance(step, _COUNTING) else contextlib.nullcontext():
            step.run_initialization(state)
            step.run_pass(state)
            step.run_finalizer(state)


def _canonical(self: Any, *_: Any, **__: Any) -> None:
    self.func_ir.blocks = transforms.canonicalize_cfg(self.func_ir.blocks)
    self.func_ir.generator_info = None


_CANONICAL = [(postproc.PostProcessor, "run", _canonical)]


def _variables(self: Any, value: Any) -> list[Any]:
    """All variables in (a part of) a statement: numba asks for them at each turn."""
    if isinstance(value, (dict, list, tuple)):
        found: list[Any] = []
        for one in value.values() if isinstance(value, dict) else value:
            kind = type(one)
            if kind is ir.Var:
                found.append(one)
            elif kind not in _BARE:
                found += _variables(self, one)
        return found
    if isinstance(value, ir.Var):
        return [value]
    return list(value.list_vars()) if isinstance(value, ir.Inst) else []


def _without_log(states: Any, block: Any, handler: Any) -> Iterator[Any]:
    for statement in block.body:
        step = handler.on_assign if isinstance(statement, ir.Assign) else handler.on_other
        yield step(states, statement)


def _once(load: Callable[[Any], None]) -> Callable[[Any], None]:
    """Load numba's declarations once, not before each function that a kernel calls; new ones are still looked for.

    Numba puts those of intrinsics, as of the least of some numbers, into the first registry that it has loaded. It
    compiles in copies of a context, which share their registries.
    """
    known: dict[int, Any] = {}  # which keeps them, so that no others get their numbers

    def loaded(context: Any) -> None:
        registries = context._registries
        if id(registries) in known:
            for registry in list(registries):
                context.install_registry(registry)
        else:
            known[id(registries)] = registries
            load(context)

    return loaded


class _Resolutions:
    """Remembers what numba finds for an operator and the types of its operands.

    It tries dozens of rules for each `+` of each function, again and again.
    """

    def __init__(self) -> None:
        self._found: dict[tuple[Any, ...], Any] = {}
        self._find: Any = types.BaseFunction.get_call_type

    def replacement(self) -> Callable[..., Any]:
        find, found = self._find, self._found

        def get_call_type(function: Any, context: Any, args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
            key = (context, function, args, *kws.items())
            if key not in found:
                found[key] = find(function, context, args, kws)
            return found[key]

        return get_call_type


_resolutions = _Resolutions()


@contextlib.contextmanager
def _replaced(replacements: list[tuple[Any, str, Any]]) -> Iterator[None]:
    before = [(owner, name, getattr(owner, name)) for owner, name, _ in replacements]
    for owner, name, replacement in replacements:
        setattr(owner, name, replacement)
    try:
        yield
    finally:
        for owner, name, original in before:
            setattr(owner, name, original)


def taken() -> contextlib.AbstractContextManager[None]:
    """Take the shortcuts: a context, to be entered once at a time."""
    quiet = contextlib.nullcontext()
    return _replaced(
        [
            (types.BaseFunction, "get_call_type", _resolutions.replacement()),
            (ir.Inst, "_rec_list_vars", _variables),
            (ssa, "_run_ssa_block_pass", _without_log),
            *(
                (one, "load_additional_registries", _once(one.load_additional_registries))
                for one in (CPUContext, TypingContext)
            ),
            (errors.WarningsFixer, "catch_warnings", lambda *_, **__: quiet),  # kernels are warned of nothing
        ]
    )
