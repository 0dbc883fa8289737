"""Costates of one phase of a run from what is known at its ends.

Within a phase p' = source + growth·p, with the coefficients of its regime (`regimes.label_cells`). It is
integrated from the end at which p is known; where it is known at both, the two must be made to meet.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, leaf
from tgvdp.certificate.regimes import highest_costate, is_partial, lowest_costate, slides
from tgvdp.physics.codes import COASTING, DYNAMIC, HOLDING, RETARDED, TRACTION

#: Newton steps at most to make the costate of a coasting phase meet both its ends, and how well, absolute.
_SHOTS = 12
_HIT = 1e-9


class Costates(NamedTuple):
    """Costate at the two ends of each cell, (K,) float64, and scratch, (K + 1,) float64."""

    left: NDArray[np.float64]
    right: NDArray[np.float64]
    ahead: NDArray[np.float64]
    back: NDArray[np.float64]


@leaf
def law_of(label):
    """Column of the coefficients of p' for a regime."""
    if label in (TRACTION, HOLDING):
        return 0
    if label == COASTING:
        return 1
    return 2 if label in (RETARDED, DYNAMIC) else 3


@leaf
def _law_at(run, p):
    """Column of the coefficients of p' that go with a value of p."""
    if p < run.hold:
        return 0
    if p < run.retard:
        return 1
    return 2 if p < 0.0 else 3


@leaf
def costate_step(run, k, p, d, law):
    """Value of p after ``d`` metres of cell k, negative: before, by the trapezoidal rule."""
    half = 0.5 * d * run.growth[k, law]
    half = min(max(half, -0.5), 0.5)
    return (p * (1.0 + half) + d * run.source[k, law]) / (1.0 - half)


@kernel
def _backward(run, first, last, p, out):
    """Integrate from p at the end of cell ``last`` − 1 back to ``first``; the end of each cell in ``out`` (K + 1)."""
    out[last] = p
    kind = run.label[last - 1]
    level = lowest_costate(run, kind) if is_partial(kind) else highest_costate(run, kind)
    ramp = p > level  # regimes too short to be seen: their laws go with p
    for k in range(last - 1, first - 1, -1):
        if is_partial(kind) and not ramp:
            p = level
        elif ramp or not slides(run, k):
            law = _law_at(run, p) if ramp else law_of(run.label[k])
            p = costate_step(run, k, p, -run.cells.length_m[k], law)
            if ramp and p <= level:
                ramp = False
                if is_partial(kind):
                    p = level
        out[k] = p


@kernel
def _forward(run, first, last, p, out):
    """Integrate from p at the start of cell ``first``; the start of each cell in ``out``.

    What p is off grows as speed decays. A train that drag slows a thousand times within a phase would have costates
    without a meaning there: in coasting they stay near what its regime allows.
    """
    out[first] = p
    lowest, highest = -math.inf, math.inf
    if run.label[first] == COASTING:
        lowest, highest = 2.0 * lowest_costate(run, COASTING), -lowest_costate(run, COASTING)
    for k in range(first, last):
        if not (is_partial(run.label[k]) or slides(run, k)):
            p = costate_step(run, k, p, run.cells.length_m[k], law_of(run.label[k]))
            p = min(max(p, lowest), highest)
        out[k + 1] = p


@leaf
def _stiffness(run, k):
    """∂²H/∂w² = ¾λ/v⁵, times the length of cell k."""
    return 3.0 * run.source[k, 1] / (run.w[k] + run.w[k + 1]) * run.cells.length_m[k]


@kernel
def _shoot(run, first, last, p, end_p, out):
    """Costates of coasting from p at the start of cell ``first`` to ``end_p``, along a run of another speed.

    The blend of two solutions is right to first order in their mismatch. Here the whole phase is driven faster or
    slower: D, the difference in w, decays as coasting has it, and p' = λ/(2v³) + 2p·∂ρ/∂w at w + D. The end of p is a
    convex, falling function of the first D, found by Newton's rule. Returns the last D, NaN where there is none.
    """
    shift = 0.0
    for _ in range(_SHOTS):
        out[first] = p
        by_shift = 0.0
        decay = 1.0
        for k in range(first, last):
            length = run.cells.length_m[k]
            half = 0.5 * length * run.growth[k, 1]
            here = 0.5 * (run.w[k] + run.w[k + 1])
            decay_k = decay * (1.0 - half)
            there = here + shift * decay_k
            if not (there > 0.1 * here and abs(half) < 0.5):
                return math.nan
            rate = run.source[k, 1] * (here / there) * math.sqrt(here / there)
            out[k + 1] = (out[k] * (1.0 + half) + length * rate) / (1.0 - half)
            by_shift = (by_shift * (1.0 + half) - 1.5 * length * rate * decay_k / there) / (1.0 - half)
            decay *= (1.0 - half) / (1.0 + half)
        missed = out[last] - end_p
        if abs(missed) <= _HIT:
            out[last] = end_p
            return shift * decay
        shift -= missed / by_shift
    return math.nan


@leaf
def _carried(run, k):
    """Factor by which a small change of p grows along cell k: as in `costate_step`; 1 where p is kept."""
    if is_partial(run.label[k]) or slides(run, k):
        return 1.0
    half = 0.5 * run.cells.length_m[k] * run.growth[k, law_of(run.label[k])]
    half = min(max(half, -0.5), 0.5)
    return (1.0 + half) / (1.0 - half)


@kernel
def _meet(run, first, last, start_p, back, spread):
    """Take from the solution ``back``, (K + 1,) in place, what it misses at the start of cell ``first``.

    What is left of it, c, costs ½∫(c' − growth·c)²/H_ww ds, least for c(s) = c(0)·S(s)/(S(0)·g(s)): g is how much a
    change of p has grown since the start, and S(s) = ∫H_ww·(g(s)/g)² ds over what is left of the phase.
    """
    spread[last] = 0.0
    for k in range(last - 1, first - 1, -1):
        spread[k] = _stiffness(run, k) + spread[k + 1] / _carried(run, k) ** 2
    missed = back[first] - start_p
    for k in range(first, last):
        here = missed * spread[k] / spread[first]
        missed /= _carried(run, k)
        back[k] -= here
    back[first] = start_p


@kernel
def fill_phase(run, k, last, start_pin, end_pin, costates):
    """Costates of the cells k to ``last`` − 1 from their values at the ends, either of which may be unknown (NaN).

    Returns ∫H_ww ds, and where p would end if nothing but its start were known: for large mismatches, as if costs were
    of second order.
    """
    left, right, ahead, back = costates
    use_back = not math.isnan(end_pin)
    use_ahead = not math.isnan(start_pin)
    if use_back:
        _backward(run, k, last, end_pin, back)
    if use_ahead:
        _forward(run, k, last, start_pin, ahead)
    reach = ahead[last] if use_ahead else math.nan
    total = 0.0
    for j in range(k, last):
        total += _stiffness(run, j)
    if use_ahead and use_back and run.label[k] == COASTING:
        shift = _shoot(run, k, last, start_pin, end_pin, ahead)
        use_back = math.isnan(shift)
        if not use_back:
            reach = end_pin + shift * total
    if use_ahead and use_back:
        _meet(run, k, last, start_pin, back, ahead)
    for j in range(k, last):
        left[j] = back[j] if use_back else ahead[j]
        right[j] = back[j + 1] if use_back else ahead[j + 1]
    return total, reach
