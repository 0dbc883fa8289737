"""How much longer a run shall take, by ranges of the line."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from tgvdp.errors import InputError
from tgvdp.model.checks import require_number


class Supplement(NamedTuple):
    """Time added to the fastest run over a range: a share of its time, s per m of line, and s in all of the range."""

    share: float = 0.0
    s_per_m: float = 0.0
    total_s: float = 0.0


class MarginRange(NamedTuple):
    """A supplement from one position of the line to another, m; infinite is the end of the run."""

    from_m: float
    to_m: float
    supplement: Supplement


def checked_ranges(ranges: Sequence[MarginRange], length_m: float) -> tuple[MarginRange, ...]:
    """Ranges in the order of a line that is so long, m.

    Raises
    ------
    InputError
        When there is none, two overlap, one does not lie on the line, or a figure is out of range.
    """
    if not ranges:
        raise InputError("margins: there is no range")
    ordered = tuple(sorted(ranges))
    for place, one in enumerate(ordered):
        for name, unit in (("share", "as a share"), ("s_per_m", "s/m"), ("total_s", "s")):
            require_number("margins", name, getattr(one.supplement, name), unit, at_least=0.0)
        if not 0.0 <= one.from_m < one.to_m or math.isnan(one.to_m):
            raise InputError(f"margins: a range from {one.from_m:.12g} m to {one.to_m:.12g} m is empty")
        if one.from_m >= length_m or length_m < one.to_m < math.inf:
            name, at_m = ("from", one.from_m) if one.from_m >= length_m else ("to", one.to_m)
            raise InputError(f"margins: {name} must lie within the line's {length_m:.12g} m, got {at_m:.12g} m")
        if place and one.from_m < ordered[place - 1].to_m:
            raise InputError(f"margins: two ranges hold {one.from_m:.12g} m")
    return ordered
