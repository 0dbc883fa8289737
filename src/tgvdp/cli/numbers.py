"""Option types: numbers that are finite and in range, with a unit behind them if need be."""

import math
from collections.abc import Callable
from typing import Any

import click

from tgvdp.errors import InputError
from tgvdp.options.texts import parse_quantity
from tgvdp.units import LARGEST_WRITTEN


def number(
    unit: str,
    *,
    above: float | None = None,
    at_least: float | None = None,
    at_most: float | None = None,
    below: float | None = None,
) -> Callable[[str], float]:
    """Make the type of an option that takes a finite number of a unit, within bounds."""

    def convert(text: str) -> float:
        try:
            value = parse_quantity(text, unit)
        except InputError as error:
            raise click.BadParameter(str(error)) from None
        if not math.isfinite(value):  # click's own ranges let NaN pass
            raise click.BadParameter(f"must be finite, got {value} {unit}")
        if abs(value) > LARGEST_WRITTEN:
            raise click.BadParameter(f"must be within ±{LARGEST_WRITTEN:g} {unit}, got {value:g} {unit}")
        if above is not None and not value > above:
            raise click.BadParameter(f"must be above {above:g} {unit}, got {value:g} {unit}")
        if at_least is not None and not value >= at_least:
            raise click.BadParameter(f"must be at least {at_least:g} {unit}, got {value:g} {unit}")
        if at_most is not None and value > at_most:
            raise click.BadParameter(f"must be at most {at_most:g} {unit}, got {value:g} {unit}")
        if below is not None and not value < below:
            raise click.BadParameter(f"must be below {below:g} {unit}, got {value:g} {unit}")
        return value

    return convert


#: Option of the commands that read a line.
LINE_SPEED: dict[str, Any] = {
    "metavar": "KMH",
    "type": number("km/h", above=0.0),
    "help": "Speed limit wherever the file of the line gives none (railML, SFERA, OSRD paths, tables).",
}
