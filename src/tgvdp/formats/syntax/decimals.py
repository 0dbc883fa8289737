"""From SI back to the units of people: the shortest decimal number that reads back as exactly the same value."""

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from tgvdp.units import to_si

_DIGITS = (15, 16, 17)
_NEIGHBOURS = 4


def decimal(value: float, unit: float, read: Callable[[float], float]) -> float:
    """Number of a unit that a reader turns into a value in SI.

    Where no number of that unit reads back exactly (rounding skips some values), the nearest one does to 1 in 10¹⁶.

    Parameters
    ----------
    value : float
        In SI, finite.
    unit : float
        Size of the unit in SI.
    read : callable
        What the reader does with a number of that unit.
    """
    guess = value / unit
    for digits in _DIGITS:
        short = float(f"{guess:.{digits}g}")
        if read(short) == value:
            return short
    below = above = guess
    for _ in range(_NEIGHBOURS):
        below, above = math.nextafter(below, -math.inf), math.nextafter(above, math.inf)
        for near in (below, above):
            if read(near) == value:
                return near
    return guess


def in_unit(values: Sequence[float], quantity: str, units: Sequence[str]) -> tuple[str, list[float]]:
    """Write values of a quantity in the first of some units that can hold all of them exactly; the last one always can.

    Returns
    -------
    unit : str
    numbers : list of float
    """
    for unit in units:
        read = partial(to_si, unit=unit, quantity=quantity)
        numbers = [decimal(value, read(1.0), read) for value in values]
        if all(read(number) == value for number, value in zip(numbers, values, strict=True)):
            return unit, numbers
    return unit, numbers


def tidy(tree: Any) -> Any:
    """Copy a tree with whole numbers written without a point, as people write them."""
    if isinstance(tree, dict):
        return {key: tidy(value) for key, value in tree.items()}
    if isinstance(tree, list | tuple):
        return [tidy(value) for value in tree]
    if isinstance(tree, float) and tree.is_integer() and abs(tree) < 1e15:
        return int(tree)
    return tree
