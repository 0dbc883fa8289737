"""Shortcuts through numba's analyses find what numba finds, and numba is left as it was."""

import pytest
from numba.core import compiler, ir, postproc, ssa, types
from numba.core.registry import cpu_target
from numba.core.typing import signature

from tgvdp._jit.steps import shortened
from tgvdp._jit.watch import is_compiled

pytestmark = pytest.mark.skipif(not is_compiled() or not shortened(), reason="compiled by numba's own steps alone")


def some_function(rows, n):
    total, i = 0.0, 0
    while i < n:
        rows[i, 0] = total
        total = max(total, rows[i, -1]) if i % 2 else -total
        i += 1
    return total, (n, i)


def found():
    """Variables of each statement, before and after each variable has one assignment."""
    blocks = compiler.run_frontend(some_function).blocks
    single = ssa._run_ssa(blocks)
    return [
        [one.name for one in statement.list_vars()]
        for some in (blocks, single)
        for block in some.values()
        for statement in block.body
    ]


def test_same_variables_in_the_same_order():
    from tgvdp._jit import shortcuts

    expected = found()
    with shortcuts.taken():
        assert found() == expected
    assert len(expected) > 40


def test_numba_is_left_as_it_was():
    from tgvdp._jit import pipeline, shortcuts

    parts = [(ir.Inst, "_rec_list_vars"), (ssa, "_run_ssa_block_pass"), (postproc.PostProcessor, "run")]
    before = [getattr(owner, name) for owner, name in parts]
    with shortcuts.taken():
        assert ir.Inst._rec_list_vars is not before[0]
    kernel, _ = pipeline.compiled_and_linked(lambda x: x + 1)
    assert pipeline.quick_compilation(kernel)(1) == 2
    with pytest.raises(Exception, match="unknown"):
        pipeline.quick_compilation(pipeline.compiled_and_linked(lambda x: unknown)[0])(1)  # noqa: F821
    assert [getattr(owner, name) for owner, name in parts] == before


def test_what_is_declared_later_is_found():
    """Numba compiles in copies of a context, which come and go: one with the number of another found no intrinsics."""
    from tgvdp._jit import shortcuts

    context = cpu_target.target_context
    with shortcuts.taken():
        context.refresh()

        def marker(): ...

        next(iter(context._registries)).lower(marker, types.int64)(lambda *_: None)
        context.refresh()
        assert context.get_function(marker, signature(types.int64, types.int64), _firstcall=False)
