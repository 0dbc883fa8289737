"""Long tuples that are handed on as addresses, and items of arrays, are those of Python."""

from types import FunctionType
from typing import NamedTuple

import numpy as np
import pytest
from numba.core import config

from tgvdp._jit import part
from tgvdp._jit.steps import shortened
from tgvdp._jit.watch import is_compiled

pytestmark = pytest.mark.skipif(not is_compiled() or not shortened(), reason="compiled by numba's own steps alone")


class Long(NamedTuple):
    """Longer than any train."""

    x: np.ndarray
    table: np.ndarray
    flags: np.ndarray
    codes: np.ndarray
    rest: tuple[float, ...]
    number: float


class Longer(NamedTuple):
    """Holds another one."""

    one: Long
    x: np.ndarray


def long(shift):
    values = np.arange(12.0) + shift
    return Long(values, values.reshape(3, 4).copy(), values > 4.0, values.astype(np.int8), (shift,) * 30, 2.0 * shift)


@part
def weigh(one, other, i):
    if i > 40:
        return weigh_again(other, one, i)
    return one.number + 3.0 * other.x[i % 12] + one.table[i % 3, -1]


@part
def weigh_again(one, other, i):
    return one.x[-1] - other.number * i


def swapped(one, other, n):
    total = 0.0
    for i in range(n):
        total += weigh(one, other, i) * (i + 1)
        if i % 3 == 0:
            one, other = other, one
        before = one
        one, other = other, before
        total -= weigh(before, one, i)
    return total


def nested(longer, n):
    inner = longer.one
    total = 0.0
    for i in range(2 * n):
        longer.x[i] = total
        total += inner.x[i] * weigh(inner, longer.one, i) + longer.one.table[i % 3, i % 4]
    return total


def built(one, n):
    last = Long(one.table[0], one.table, one.flags, one.codes, one.rest, 1.0)
    total = 0.0
    for i in range(n):
        last = Long(last.table[i % 3], one.table, one.flags, one.codes, one.rest, last.number + last.x[0])
        total += weigh_again(last, one, i)
    return total


def items(one, n):
    one.flags[n] = not one.flags[-3]
    one.codes[-1] = n
    one.table[-1, n - 2] = one.codes[n] / 2
    bounded = max(one.x[n], one.codes[2]) + min(n, one.x[1]) + min(np.nan, one.x[0])
    bounded = max(one.x[3], bounded)
    return bounded + one.codes[one.codes[n]] + one.table[one.codes[1], 2] + (7.0 if one.flags[n] else 11.0)


class Short(NamedTuple):
    """Handed on word by word."""

    table: np.ndarray
    turned: np.ndarray
    scale: float


@part
def counted(short, n):
    total = 0.0
    for i in range(n):
        total += short.table[i % 3, i % 4] * (i + 1)
    for i in range(n, 2 * n):
        total -= short.scale * i
        for k in range(i):
            if k == n:
                break
            if k % 2:
                continue
            total += k
    for i in range(11, n, -2):
        total = 2.0 * total + i
    for i in range(n, 0):
        total = np.nan * i
    for step in (n, 2):
        for i in range(3, 14, step):
            total = 3.0 * total - i
        for i in range(10, -1, -step):
            total = total / 2.0 + i
    return total, i


def counted_twice(short, n):
    """Arrays without gaps and with them, parts of those, and what numba's own functions make of them."""
    total, last = counted(short, n)
    row, column = short.table[n % 3], short.table[:, n % 4]
    total += row.sum() + column.sum() + short.table.sum() + short.turned[1].sum() + short.turned[n, 0]
    other = Short(short.table[1:], short.turned, total)
    return counted(Short(short.table, short.turned, 2.0 * total), n)[0] + other.table[-1, -1] + other.table.size + last


def carried(short, n):
    """Values that are set in one block, and used in others, or set anew there."""
    first, other, kept = short.scale, short, 0.0
    for i in range(n):
        now = first + i
        if i % 2:
            first = now * other.scale
            other = Short(short.table, short.turned, now)
        elif i % 3:
            kept = now
        for k in range(2):
            kept += now * k + other.table[k, 0]
    return first + kept + other.scale


def short():
    table = np.arange(12.0).reshape(3, 4)
    return Short(table, np.arange(12.0).reshape(3, 4).T, 1.5)


CASES = {
    "swapped": (swapped, lambda: (long(1.0), long(20.5), 60)),
    "nested": (nested, lambda: (Longer(long(2.0), np.zeros(12)), 4)),
    "built": (built, lambda: (long(3.0), 5)),
    "items": (items, lambda: (long(0.0), 3)),
    "counted": (counted_twice, lambda: (short(), 3)),
    "carried": (carried, lambda: (short(), 7)),
}


@pytest.mark.parametrize("name", CASES)
def test_as_in_python(name, monkeypatch):
    from tgvdp._jit import optimise
    from tgvdp._jit.pipeline import compiled_and_linked

    monkeypatch.setattr(optimise, "_SMALL", 0)  # each call is one

    function, arguments = CASES[name]
    kernel, _ = compiled_and_linked(function)
    here, there = arguments(), arguments()
    expected = as_python(function)(*here)
    assert kernel(*there) == expected
    for one, other in zip(arrays(here), arrays(there), strict=True):
        np.testing.assert_array_equal(one, other)


def test_arrays_that_come_back_to_python_are_those_that_were_given():
    from tgvdp._jit.pipeline import compiled_and_linked

    def scaled(short):
        return Short(short.table, short.turned, 2.0 * short.scale)

    given = short()
    kernel, _ = compiled_and_linked(scaled)
    back = kernel(given)
    assert back.table is given.table
    assert back.turned is given.turned
    assert back.scale == 3.0


def as_python(function):
    """The function, with what it calls, uncompiled."""
    names = dict(globals())
    for name in ("weigh", "weigh_again", "counted"):
        names[name] = FunctionType(globals()[name].py_func.__code__, names)
    return FunctionType(function.__code__, names)


def arrays(value):
    if isinstance(value, np.ndarray):
        return [value]
    return [one for item in value for one in arrays(item)] if isinstance(value, tuple) else []


def item(one, i):
    return one.x[i]


def stored(one, i):
    one.x[i] = 7.0
    return 7.0


@pytest.mark.nojit
@pytest.mark.skipif(not config.BOUNDSCHECK, reason="bounds are checked on demand alone")
@pytest.mark.parametrize("function", [item, stored])
def test_computed_indices_count_from_the_start(function):
    from tgvdp._jit.pipeline import compiled_and_linked

    kernel, _ = compiled_and_linked(function)
    assert kernel(long(-4.0), 11) == 7.0
    for beyond in (-1, 12):
        with pytest.raises(IndexError):
            kernel(long(0.0), beyond)


def test_long_tuples_are_handed_on_as_addresses():
    from tgvdp._jit.pipeline import compiled_and_linked

    kernel, _ = compiled_and_linked(nested)
    kernel(*CASES["nested"][1]())
    (code,) = kernel.inspect_llvm().values()
    assert "ptr noalias" in code
    assert "i64 %arg.longer" not in code
