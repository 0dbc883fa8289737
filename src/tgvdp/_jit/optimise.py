"""How the intermediate code of a kernel is optimised: by fewer of LLVM's passes, each run once over all of it.

LLVM's own first level runs most of its passes on each function again whenever something was inlined there. These take
half of that time, and kernels run as fast: that is decided by what is inlined. New passes of LLVM's that are no part of
its own levels are none of them: `newgvn` fails on kernels that check bounds. Nothing runs in vector registers so but
short loops that are set apart, and optimised by themselves.
"""

from collections import Counter
from typing import Any

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


def is_small(function: Any) -> bool:
    """Whether a function, as it was written, does little beside passing on what it is given."""
    did = Counter(one.opname for block in function.blocks for one in block.instructions)
    return sum(times * (_CALL if what == "call" else what not in _MOVES) for what, times in did.items()) < _SMALL


def optimise(module: Any, machine: Any) -> None:
    """Optimise a module for a machine."""
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
