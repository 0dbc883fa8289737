"""How kernels count: loops over ranges of numbers, in a fifth of the code that numba writes for one.

numba counts how many numbers are left, beside the number itself, and looks whether the step is 0. Here the next number
is compared with the end; a range is the three numbers of it, an iterator where the next one stands.
"""

from typing import Any

from llvmlite import ir as llvm
from numba.core import cgutils
from numba.core import types as numba_types

types: Any = numba_types
#: The only kind of range that kernels have.
RANGE, ITERATOR = types.range_state64_type, types.range_iter64_type


def range_of(context: Any, builder: Any, *ends: Any) -> Any:
    """Return a range: of up to three numbers, as Python's."""
    word = context.get_value_type(types.intp)
    start, stop, step = ((word(0), *ends, word(1)), (*ends, word(1)), ends)[len(ends) - 1]
    return cgutils.make_anonymous_struct(builder, (start, stop, step), context.get_value_type(RANGE))


def iterator_of(context: Any, builder: Any, numbers: Any) -> Any:
    """Return what runs through a range."""
    start, stop, step = (builder.extract_value(numbers, i) for i in range(3))
    with builder.goto_entry_block():
        place = builder.alloca(start.type)
    builder.store(start, place)
    return cgutils.make_anonymous_struct(builder, (place, stop, step), context.get_value_type(ITERATOR))


def next_of(context: Any, builder: Any, iterator: Any, pair: Any) -> Any:
    """Return the next number, and whether it is one of the range; step to the one after it."""
    place, stop, step = (builder.extract_value(iterator, i) for i in range(3))
    number = builder.load(place)
    builder.store(builder.add(number, step, flags=["nsw"]), place)
    below, above = (builder.icmp_signed(than, number, stop) for than in "<>")
    if isinstance(step, llvm.Constant):
        inside = below if step.constant > 0 else above
    else:
        inside = builder.select(builder.icmp_signed(">", step, step.type(0)), below, above)
    return cgutils.make_anonymous_struct(builder, (number, inside), context.get_value_type(pair))
