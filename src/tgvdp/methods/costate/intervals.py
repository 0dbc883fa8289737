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
def _up_to_all(train, b, c, e, g):
    """Speeds b, e and g, of which g and b are c where all is braked from e on, the speed at which the brake is there.

    On a ramp there is so little of it that a run brakes as late as for a limit.
    """
    if (e < g and g >= b) or (b <= e and train.ramps_to_mps <= train.brakes_from_mps):
        return max(c, e), e, max(c, e)
    return b, e, g


@part
def through_cell(train, cell, before_b, before_c, before_e, before_g, b, c, e, g, scratch):
    """Speeds b, e and g at the start of a cell and at its end, between which they go along straight lines.

    Where what is coasted between g and b ends within the cell it does so at its end, where a run is that brakes along
    b; where it begins within it, at its start.
    """
    before_b, before_e, before_g = _up_to_all(train, before_b, before_c, before_e, before_g)
    b, e, g = _up_to_all(train, b, c, e, g)
    coasts = before_g < before_b
    if coasts and before_e < before_g and e >= g:
        b, e, g = matched(b, c, e, g, before_b, before_c, before_e, before_g)
    if coasts and e < g == b:
        if before_b < before_c:
            b = g = march(train, DYNAMIC, 1.0, cell, cell.length_m, before_b, e, scratch, 0)[1]
    elif e < g and before_e >= before_g:
        before_b, before_e, before_g = matched(before_b, before_c, before_e, before_g, b, c, e, g)
    elif e < g < b and not coasts:
        before_b = before_g = before_c if b >= c else max(min(0.5 * (g + b), before_c), before_e)
    return before_b, before_e, before_g, b, e, g
