"""Option types: numbers that are finite and in range. click's own ranges let NaN pass."""

import math
from collections.abc import Callable

import click


def number(unit: str, *, above: float = -math.inf, at_least: float = -math.inf) -> Callable[[str], float]:
    """Make the type of an option that takes a finite number of a unit, with a lower bound."""

    def convert(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            raise click.BadParameter(f"must be a number of {unit}, got {text!r}") from None
        if not math.isfinite(value):
            raise click.BadParameter(f"must be finite, got {value} {unit}")
        if not value > above:
            raise click.BadParameter(f"must be above {above:g} {unit}, got {value:g} {unit}")
        if not value >= at_least:
            raise click.BadParameter(f"must be at least {at_least:g} {unit}, got {value:g} {unit}")
        return value

    return convert
