"""Intervals of speeds in which a dynamic brake that rises with speed works, below those at which a run coasts.

A station has b, from which on a run brakes, and an interval from e to g < b in which it does, too, all squared. It has
none where e = g, and where it goes up to b all is braked from e on.
"""

from tgvdp._jit import leaf, part
from tgvdp.physics.codes import DYNAMIC
from tgvdp.physics.march import march


@leaf
def matched(b, c, e, g, other_b, other_c, other_e, other_g):
    """Speeds b, e and g with an interval like that of a neighbour if they have none; c is where all brakes begin.

    One of no width where the neighbour's begins; or, where all is braked above b that the neighbour does not coast, one
    that ends, and b with it, amid the speeds at which it does, or at c where those go up to that.
    """
    if e < g or other_e >= other_g:
        return b, e, g
    if abs(b - other_e) < abs(b - other_b):
        coasts = c if other_b >= other_c else max(min(0.5 * (other_g + other_b), c), b)
        return coasts, b, coasts
    return b, other_e, other_e


@leaf
def _is_all(train, b, e, g):
    """Whether all is braked from e on: the interval goes up to b, or b is where the dynamic brake begins.

    Not on a ramp, where there is so little of it that a run brakes as late as for a limit.
    """
    return (e < g and g >= b) or (b <= e and train.ramps_to_mps <= train.brakes_from_mps)


@part
def through_cell(train, cell, before_b, before_c, before_e, before_g, b, c, e, g, scratch):
    """Speeds b, e and g at the start of a cell and at its end, between which they go along straight lines.

    Where all is braked g and b are c. Where what is coasted above an interval ends within the cell it does so at its
    end, where a run is that brakes along b; where it begins within it, at its start.
    """
    was_all = _is_all(train, before_b, before_e, before_g)
    is_all = _is_all(train, b, e, g)
    had_some = before_e < before_g
    has_some = e < g
    if was_all and (is_all or has_some):
        before_b = before_g = max(before_c, before_e)
        if not is_all and b < c:
            before_b = before_g = max(min(0.5 * (g + b), before_c), before_e)
    if is_all and (was_all or had_some):
        b = g = max(c, e)
        if not was_all and before_b < before_c:
            b = g = march(train, DYNAMIC, 1.0, cell, cell.length_m, before_b, e, scratch, 0)[1]
    if not was_all and not is_all:
        if had_some and not has_some:
            b, e, g = matched(b, c, e, g, before_b, before_c, before_e, before_g)
            if e < g and before_b < before_c:
                b = g = march(train, DYNAMIC, 1.0, cell, cell.length_m, before_b, e, scratch, 0)[1]
        else:
            before_b, before_e, before_g = matched(before_b, before_c, before_e, before_g, b, c, e, g)
    return before_b, before_e, before_g, b, e, g
