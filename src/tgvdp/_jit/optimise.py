"""How the intermediate code of a kernel is optimised: by fewer of LLVM's passes, each run once over all of it.

LLVM's own first level runs most of its passes on each function again whenever something was inlined there. These take
half of that time, and searches 3 % more: most is decided by what is inlined. New passes of LLVM's that are no part of
its own levels are none of them: `newgvn` fails on kernels that check bounds. Nothing runs in vector registers so but
short loops that are set apart, and optimised by themselves.
"""

import functools
from collections import Counter
from collections.abc import Sequence
from typing import Any, NamedTuple

import llvmlite.binding as llvm

#: Functions that do less than this are inlined wherever they are called.
_SMALL = 25
#: What moves words to where they are needed, and goes when a function is inlined; and what a call is worth.
_MOVES = {"alloca", "load", "store", "getelementptr", "extractvalue", "insertvalue", "bitcast", "br", "ret"}
_CALL = 5
_PASSES = (
    *("global_dead_code_eliminate", "always_inliner", "sroa", "simplify_cfg"),
    *("ipsccp", "dead_arg_elimination", "post_order_function_attributes", "instruction_combine", "simplify_cfg"),
    *("reassociate", "mem_copy_opt", "sinking", "instruction_combine"),
    *("loop_rotate", "simplify_cfg", "aggressive_dce"),
)


class Written(NamedTuple):
    """What is known of a function as it was written: its name, how often it calls others, and whether it is inlined."""

    name: str
    calls: Counter[str]
    is_inlined: bool


def written(function: Any) -> Written:
    """What is known of a function before LLVM reads it."""
    instructions = (one for block in function.blocks for one in block.instructions)
    calls = Counter(one.callee.name for one in instructions if one.opname == "call")
    return Written(function.name, calls, "alwaysinline" in function.attributes)


def called_once(functions: Sequence[Written]) -> list[str]:
    """Functions that all others together call from one place, once those that are inlined are.

    To inline them takes no more code, and what they are given need not be handed on: searches take 3 % less.
    """
    callers: dict[str, list[tuple[Written, int]]] = {}
    for function in functions:
        for name, times in function.calls.items():
            callers.setdefault(name, []).append((function, times))

    @functools.cache
    def places(name: str) -> int:
        return sum(times * (places(one.name) if one.is_inlined else 1) for one, times in callers.get(name, ()))

    return [function.name for function in functions if not function.is_inlined and places(function.name) == 1]


def is_small(function: Any) -> bool:
    """Whether a function, as it was written, does little beside passing on what it is given."""
    did = Counter(one.opname for block in function.blocks for one in block.instructions)
    return sum(times * (_CALL if what == "call" else what not in _MOVES) for what, times in did.items()) < _SMALL


def optimise(module: Any, machine: Any, functions: Sequence[Written]) -> None:
    """Optimise a module for a machine, of which some functions are known."""
    for name in called_once(functions):
        module.get_function(name).add_function_attribute("alwaysinline")
    for function in module.functions:
        if function.linkage.name == "linkonce_odr":
            function.linkage = "internal"
    passes = llvm.create_new_module_pass_manager()
    for name in _PASSES:
        getattr(passes, f"add_{name}_pass")()
    passes.run(module, llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(1)))


def vectorise(module: Any, machine: Any) -> None:
    """Optimise a module of a few short loops for a machine, so that these run in vector registers.

    By LLVM's second level, which takes many times as long as `optimise`. Loops are not unrolled: most are short.
    """
    options = llvm.create_pipeline_tuning_options(2)
    options.loop_vectorization = True
    options.loop_interleaving = options.loop_unrolling = options.slp_vectorization = False
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
