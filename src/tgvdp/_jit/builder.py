"""Writes LLVM's intermediate code without what numba's own way to hand on tuples leaves behind.

numba puts every tuple together from the words of the arguments, and takes it apart again for each function that gets
it: half of all code was that, most of it for nothing.
"""

from collections import Counter
from typing import Any

from llvmlite import ir as llvm
from llvmlite.ir import instructions as code

#: What does nothing but give a value: it may go where nobody uses that.
_PURE = {"insertvalue", "extractvalue", "getelementptr", "load", "alloca", "mul", "icmp"}


class Builder(llvm.IRBuilder):  # type: ignore[misc]
    """Takes parts of tuples from where they were before they were put in."""

    def extract_value(self, agg: Any, idx: Any, name: str = "") -> Any:
        path = tuple(idx) if isinstance(idx, (tuple, list)) else (idx,)
        while path:
            if isinstance(agg, code.ExtractValue):
                agg, path = agg.aggregate, (*agg.indices, *path)
            elif not isinstance(agg, code.InsertValue):
                break
            elif _differ(agg.indices, path):
                agg = agg.aggregate
            elif len(agg.indices) <= len(path):
                agg, path = agg.value, path[len(agg.indices) :]
            else:  # only a part of what is asked for was put in there
                break
        return super().extract_value(agg, path, name) if path else agg


def _differ(one: Any, other: Any) -> bool:
    return any(a != b for a, b in zip(one, other, strict=False))


def drop_unused(function: Any) -> None:
    """Take out of a function what gives values that nothing uses."""
    uses = Counter(id(used) for block in function.blocks for one in block.instructions for used in _operands(one))
    dropped: set[int] = set()
    todo = [one for block in function.blocks for one in block.instructions if not uses[id(one)]]
    while todo:
        one = todo.pop()
        if getattr(one, "opname", None) in _PURE:
            dropped.add(id(one))
            for used in _operands(one):
                uses[id(used)] -= 1
                if not uses[id(used)]:
                    todo.append(used)
    for block in function.blocks:
        block.instructions = [one for one in block.instructions if id(one) not in dropped]


def _operands(one: Any) -> Any:
    return [value for value, _ in one.incomings] if isinstance(one, code.PhiInstr) else one.operands


def raises(function: Any) -> bool:
    """Whether a function may return another code than that of success, which is 0."""
    ends = [block.terminator for block in function.blocks]
    codes = [end.return_value for end in ends if isinstance(end, code.Ret)]
    return any(getattr(one, "constant", None) != 0 for one in codes)
