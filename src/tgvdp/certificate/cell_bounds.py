"""The lower bound for given costates: least values of the Hamiltonian, summed over cells.

For fixed speed and effort H is linear in s within a cell (`certificate.hamiltonian`), so its minimum over them is
concave in s, and the trapezoid of its values at the ends of the cell bounds the integral. Where the speed bound rises
within the cell (`certificate.speed_bound`), runs at its start are slower than at its end: with w ≤ U(s), U linear, and
any μ ≥ 0

    H ≥ H + μ·(w − U(s))     for speeds between the ends of U, and H itself for slower ones,

each of which has a concave minimum, and so has the lesser of the two. The derivation and what is proven stand in
docs/certificate.md.
"""

import math
from typing import NamedTuple

from tgvdp._jit import kernel, leaf, part
from tgvdp.certificate.curved import least_at
from tgvdp.certificate.efforts import NOT_MERGED, largest_effort, load_at, load_in, merged_in, price_in
from tgvdp.certificate.hamiltonian import ROUNDINGS, Hamiltonian
from tgvdp.certificate.regimes import is_standstill

UNIT_ROUNDOFF = 2.0**-53
#: Gain by the rise of the speed bound within a cell at most, relative to λ/v, below which it is not worth the time.
_RISE_GAIN = 1e-6


@kernel
def standstill_terms(pieces, n, load, start, length, multiplier, end_w, top_w, per_joule):
    """Lower bound of time and energy in a cell at whose one end w is (nearly) 0, in two terms: see `standstill_cell`.

    The gain of w per metre is at most 2g, g = sup(M − load) after a stop, sup(B + load) before one (``start`` False).
    So w ≤ end_w + 2·g·x, and the time is at least 2d/(√end_w + √(end_w + 2gd)). The energy is at least ``per_joule``
    times the work, ½(w − end_w) + d·load(0) of starting, ½(end_w − w) + d·load(0) of stopping: a and η are the slopes
    of a convex e(f).

    Returns
    -------
    rest, reach_w : float
        The bound but for what depends on w at the other end, and the largest w there, m²/s².
    """
    w = end_w + 4.0 * length * (max(largest_effort(pieces, n, 0.0, 0.0), 0.0) + abs(load.r0))
    gain = 0.0
    while True:
        w = min(w, top_w)
        v = math.sqrt(w)
        gain = largest_effort(pieces, n, 0.0, v)
        gain += -load.r0 if start else load_at(load, v)
        gain = max(gain, 0.0)
        if end_w + 2.0 * gain * length <= w or w >= top_w:
            break
        w *= 2.0
    reach = end_w + 2.0 * gain * length
    least = multiplier * 2.0 * length / (math.sqrt(end_w) + math.sqrt(reach)) if reach > 0.0 else 0.0
    sign = 0.5 * per_joule if start else -0.5 * per_joule
    return least - sign * end_w + per_joule * load.r0 * length, min(w, reach)


@leaf
def standstill_cell(rest, reach_w, start, slope, per_joule):
    """Lower bound of a cell at a standstill plus slope·w at its other end, which is least at an end of its range."""
    sign = 0.5 * per_joule if start else -0.5 * per_joule
    return rest + min(0.0, (sign + slope) * reach_w)


class Side(NamedTuple):
    """Speeds between two kinks of a potential, whose costate is theirs alone: w from ``low_w`` to ``high_w``."""

    low_w: float
    high_w: float


#: All speeds: no kink.
WHOLE = Side(0.0, math.inf)


@kernel
def cell_kernel(h, side, p0, p1, r0, r1, length, top_v, start_w, end_w):
    """Lower bounds of H at the two ends of a cell, with all that tells how they change with the costate.

    ``p0``, ``p1`` are the costates at its ends, ``r0``, ``r1`` what they grow by per m/s (`certificate.curved`). w is
    at most linear between ``start_w`` and ``end_w``, and at most ``top_v``². On one side of a kink these are bounds for
    the speeds there; infinite where the cell has none of them.

    Returns
    -------
    least0, least1, size : float
        The bounds, and a bound of the rounding error of their mean in units of 2⁻⁵³.
    v0, v1 : float
        The speeds of the least values at the two ends.
    tilt0, tilt1 : float
        What μ adds to the slope of the costate there.
    """
    slope = (p1 - p0) / length
    growth = (r1 - r0) / length
    bottom_v = math.sqrt(side.low_w)
    top_v = min(math.sqrt(side.high_w) * (1.0 - 4.0 * UNIT_ROUNDOFF), top_v)  # an effort that jumps there is not theirs
    if bottom_v > top_v:
        return math.inf, math.inf, 0.0, top_v, top_v, 0.0, 0.0
    shift = slope * side.low_w
    low_w = max(min(start_w, end_w), side.low_w)
    low_v = min(math.sqrt(low_w), top_v)
    if low_v >= top_v:
        least0, size0, v0 = least_at(h, p0, slope, r0, growth, bottom_v, top_v)
        least1, size1, v1 = least_at(h, p1, slope, r1, growth, bottom_v, top_v)
        return least0 - shift, least1 - shift, 0.5 * (size0 + size1), v0, v1, 0.0, 0.0
    # μ is the mean fall of H from the slowest to the fastest of the speeds that not all runs may have
    fall = 0.0
    for p, r in ((p0, r0), (p1, r1)):
        slow, _, _ = least_at(h, p, slope, r, growth, low_v, low_v)
        fast, _, _ = least_at(h, p, slope, r, growth, top_v, top_v)
        fall += 0.5 * (slow - fast)
    tilt = 0.0
    if fall > _RISE_GAIN * h.multiplier / top_v:
        tilt = fall / (top_v * top_v - low_w)
    least0, tilted0, size0, v0, at0, tilt0 = _end_of_rise(
        h, p0, slope, r0, growth, bottom_v, low_v, top_v, start_w, tilt
    )
    least1, tilted1, size1, v1, at1, tilt1 = _end_of_rise(h, p1, slope, r1, growth, bottom_v, low_v, top_v, end_w, tilt)
    size = 0.5 * (size0 + size1)
    if tilted0 + tilted1 > least0 + least1:
        return tilted0 - shift, tilted1 - shift, size, at0, at1, tilt0, tilt1
    return least0 - shift, least1 - shift, size, v0, v1, 0.0, 0.0


@part
def _end_of_rise(h, p, slope, r, growth, bottom_v, low_v, top_v, bound_w, tilt):
    """Least H at an end of a cell in which the speed bound rises, and least H with μ; rounding; where each is."""
    slow, size, slow_v = least_at(h, p, slope, r, growth, bottom_v, low_v)
    fast, fast_size, fast_v = least_at(h, p, slope, r, growth, low_v, top_v)
    least = min(slow, fast)
    v = slow_v if slow <= fast else fast_v
    size = max(size, fast_size)
    if tilt <= 0.0:
        return least, -math.inf, size, v, v, 0.0
    shift = tilt * bound_w
    fast, fast_size, fast_v = least_at(h, p, slope + tilt, r, growth, low_v, top_v)
    size = max(size, fast_size + ROUNDINGS * shift)
    if slow <= fast - shift:
        return least, slow, size, v, slow_v, 0.0
    return least, fast - shift, size, v, fast_v, tilt


@part
def _terms_of_nodes(k, left, right, node_cap, w):
    """What the jump of p at the start of a cell costs, and the ends of the trip; sum, and sum of magnitudes."""
    count = left.shape[0]
    turned = 0.0
    if k == 0:
        turned = left[0] * w[0]
    elif k > 1 or not is_standstill(w[0], w[1]):
        turned = min(0.0, left[k] - right[k - 1]) * node_cap[k]
    at_end = -right[k] * w[count] if k == count - 1 else 0.0
    return turned + at_end, abs(turned) + abs(at_end)


@kernel
def bound_kernel(train, tables, cells, caps, w, multiplier, left, right, top_v, pieces, wanted, bound, doubt):
    """Lower bounds of E + λT cell by cell, per unit of inertia.

    Parameters
    ----------
    train : KernelTrain
    tables : EnergyTables
        Of a kind without a map. Auxiliary power is part of the multiplier.
    cells : Cells
    caps : Caps
    w : (K + 1,) float64
        Squared speeds of the run that the costates belong to, m²/s²: of use are those at the two ends, and whether
        the cells there are cells of a standstill.
    multiplier : float
        λ per unit of inertia.
    left, right : (K,) float64
        Costate p at the two ends of each cell.
    top_v : float
        Largest speed of all, m/s.
    pieces : (3, 3n, 6) float64
        Scratch for the pieces of the effort curves.
    wanted : (K,) bool
        Cells whose bounds are wanted.
    bound : (K,) float64, modified in place
        Lower bound of ∫H over each of them, with the jump of p at its left end and the terms of the trip's ends.
    doubt : (K,) float64, modified in place
        Bounds of their rounding errors, in units of 2⁻⁵³.
    """
    count = cells.length_m.shape[0]
    last = count - 1
    mass = train.inertia_kg
    first_stands = is_standstill(w[0], w[1])
    last_stands = is_standstill(w[count], w[last])
    merged = NOT_MERGED
    for k in range(count):
        if not wanted[k]:
            continue
        d = cells.length_m[k]
        load = load_in(train, cells, k)
        price = price_in(train, cells, k, multiplier)
        cap = caps.cell[k]
        merged = merged_in(train, cells, k, top_v, pieces, merged)
        _, pulls, brakes, dynamics = merged
        if k == 0 and first_stands:
            per_joule = tables.traction
            rest, reach_w = standstill_terms(pieces[0], pulls, load, True, d, price, w[0], cap, per_joule)
            bound[k] = standstill_cell(rest, reach_w, True, left[1], per_joule)
            doubt[k] = ROUNDINGS * (abs(bound[k]) + per_joule * (w[0] + abs(load.r0) * d))
        elif k == last and last_stands:
            per_joule = tables.regeneration
            rest, reach_w = standstill_terms(pieces[1], brakes, load, False, d, price, w[count], cap, per_joule)
            bound[k] = standstill_cell(rest, reach_w, False, -right[k - 1], per_joule)
            doubt[k] = ROUNDINGS * (abs(bound[k]) + per_joule * (w[count] + abs(load.r0) * d))
        else:
            turned, turned_size = _terms_of_nodes(k, left, right, caps.node, w)
            size = (train.davis_a_n + abs(cells.grade_n[k])) / mass
            h = Hamiltonian(pieces, pulls, brakes, dynamics, tables.traction, tables.regeneration, load, size, price)
            cell_v = min(math.sqrt(cap) * (1.0 + 4.0 * UNIT_ROUNDOFF), top_v)
            rise = caps.rise[k]
            start, end, rounding, _, _, _, _ = cell_kernel(
                h, WHOLE, left[k], right[k], 0.0, 0.0, d, cell_v, rise[0], rise[1]
            )
            bound[k] = 0.5 * d * (start + end) + turned
            doubt[k] = d * rounding + ROUNDINGS * turned_size
