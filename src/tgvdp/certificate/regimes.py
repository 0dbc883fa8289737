"""A run in phases: its cells labelled by regime.

The regimes are ordered by the costate p that they go with (per unit of inertia; a = 1/η_t the price of traction work,
η = η_r what a joule of dynamic braking returns; at the wheel a = 1, η = 0):

    traction  −a/2  coasting  −η/2  regeneration  0  full braking

At the levels between them effort may be partial: holding by traction, held back by the dynamic brake, or by friction.
"""

import math

from tgvdp._jit import kernel, leaf
from tgvdp.certificate.efforts import merge_tables, piece_at, piece_value
from tgvdp.physics.forces import mean_resistance

TRACTION = 0
HOLDING = 1  # partial traction
COASTING = 2
RETARDED = 3  # partial regeneration
REGENERATION = 4  # the whole dynamic brake
HELD_BACK = 5  # partial friction braking
BRAKING = 6
DYNAMIC_BRAKING = 7  # full braking that is all done by the dynamic brake: p from −η/2 on

#: Effort above this share of its limit counts as full.
_FULL_SHARE = 0.97
#: Effort below this share of the starting effort counts as none.
_NO_EFFORT = 1e-4
#: Relative distance of w from the limit within which a run touches it.
TOUCH = 1e-4
#: Relative change of w in a cell below which the speed is kept.
_STEADY = 1e-6
#: Relative difference of λ/(2v³) and ∂ρ/∂w above which a speed is not the optimal holding speed.
_OFF_HOLDING = 0.05
#: Partial effort over which p would change by less than this is none.
_NO_DRIFT = 3e-3
#: Another regime for less than this share of the cells before and after it, which are of the same one, is none.
_MOMENT = 0.05


@leaf
def is_standstill(end_w, next_w):
    """Whether the cell at an end of a trip holds a (near) standstill: no other cell spans such a ratio of speeds."""
    return end_w < 0.5 * next_w


@leaf
def is_partial(label):
    """Whether effort is partial: p keeps one level."""
    return label in (HOLDING, RETARDED, HELD_BACK)


@leaf
def lowest_costate(label, hold, retard):
    """Lowest p of a regime; ``hold`` and ``retard`` are the levels −a/2 and −η/2."""
    if label == TRACTION:
        return -math.inf
    if label <= COASTING:
        return hold
    return retard if label <= REGENERATION or label == DYNAMIC_BRAKING else 0.0


@leaf
def highest_costate(label, hold, retard):
    """Highest p of a regime."""
    if label <= HOLDING:
        return hold
    if label <= RETARDED:
        return retard
    return 0.0 if label <= HELD_BACK else math.inf


@kernel
def row_efforts(train, x, w, grade, air, effort):
    """Mean effort of each row in N, positive traction; ``effort`` (n − 1,) in place."""
    for i in range(x.shape[0] - 1):
        d = x[i + 1] - x[i]
        load = mean_resistance(train, air[i], math.sqrt(w[i]), math.sqrt(w[i + 1])) + grade[i]
        effort[i] = 0.5 * train.inertia_kg * (w[i + 1] - w[i]) / d + load


@leaf
def _by_w(pieces, n, v, m1, m3):
    """Derivative by w of a table of pieces, averaged over a cell: ``m1``, ``m3`` are the means of 1/v and 1/v³."""
    i = piece_at(pieces, n, v)
    return -0.5 * pieces[i, 1] * m3 + 0.5 * pieces[i, 3] * m1 + pieces[i, 4] + 1.5 * pieces[i, 5] * v


@leaf
def _regime(effort, v, no_effort, regeneration, pull, pulls, dynamic, dynamics, brake, brakes):
    """Regime that a mean effort per unit of inertia at speed v belongs to."""
    if abs(effort) <= no_effort:
        return COASTING
    if effort > 0.0:
        return TRACTION if effort >= _FULL_SHARE * piece_value(pull, piece_at(pull, pulls, v), v) else HOLDING
    most = piece_value(brake, piece_at(brake, brakes, v), v)
    full = -effort >= _FULL_SHARE * most
    if regeneration == 0.0:
        return BRAKING if full else HELD_BACK
    returned = piece_value(dynamic, piece_at(dynamic, dynamics, v), v)
    if full:
        return DYNAMIC_BRAKING if returned >= _FULL_SHARE * most else BRAKING
    if -effort < _FULL_SHARE * returned:
        return RETARDED
    return REGENERATION if -effort * _FULL_SHARE <= returned else HELD_BACK


@kernel
def label_cells(train, tables, length, grade, air, w, effort, price, top_v, pieces, label, source, growth):
    """Label cells by regime, with the coefficients of p' = source + growth·p in it.

    ``effort`` is the mean effort in N of the row that a cell belongs to; (K,) int8 ``label`` and (K, 4) float64
    ``source`` and ``growth`` in place: one column each for traction, coasting, regeneration and braking.
    """
    mass = train.inertia_kg
    r1 = train.davis_b / mass
    no_effort = _NO_EFFORT * train.traction[0, 2] / mass
    pull = pieces[0]
    brake = pieces[1]
    dynamic = pieces[2]
    pulls = 0
    brakes = 0
    dynamics = 0
    for k in range(length.shape[0]):
        r0 = (train.davis_a_n + grade[k]) / mass
        r2 = air[k] / mass
        if k == 0 or grade[k] != grade[k - 1] or air[k] != air[k - 1]:
            pulls, brakes, dynamics = merge_tables(train, r0, r1, r2, top_v, pieces)
        v0 = math.sqrt(w[k])
        v1 = math.sqrt(w[k + 1])
        v = 0.5 * (v0 + v1)
        label[k] = _regime(
            effort[k] / mass, v, no_effort, tables.regeneration, pull, pulls, dynamic, dynamics, brake, brakes
        )
        if v0 <= 0.0 or v1 <= 0.0:
            continue  # cells at a standstill have no costate
        m1 = 1.0 / v
        m3 = 1.0 / (v0 * v1 * v)
        load_w = 0.5 * r1 * m1 + r2
        pull_w = _by_w(pull, pulls, v, m1, m3)
        brake_w = _by_w(brake, brakes, v, m1, m3)
        dynamic_w = _by_w(dynamic, dynamics, v, m1, m3)
        for j in range(4):
            source[k, j] = 0.5 * price * m3
            growth[k, j] = 2.0 * load_w
        source[k, 0] -= tables.traction * pull_w
        growth[k, 0] -= 2.0 * pull_w
        source[k, 2] += tables.regeneration * dynamic_w
        growth[k, 2] += 2.0 * dynamic_w
        source[k, 3] += tables.regeneration * dynamic_w
        growth[k, 3] += 2.0 * brake_w


@kernel
def tidy_labels(sliver, length, w, cap, ceiling, hold, retard, label, source, growth):
    """Give cells that no optimal run could have the label of a neighbour; ``label`` (K,) in place.

    Such are phases shorter than ``sliver`` metres, or much shorter than the cells around it if these are of one regime,
    and partial effort away from both the limit and the optimal holding speed, at which p' = 0 whatever the gradient:
    the run only steps from one switching speed to the next. The limit is ``cap``, or where a run keeps a speed
    ``ceiling``: where effort drops it goes no faster. ``hold`` and ``retard`` are the levels of p.
    """
    count = label.shape[0]
    for sweep in range(2):
        k = 0
        while k < count:
            last = k
            span = 0.0
            drift = 0.0
            scale = 0.0
            free = is_partial(label[k])
            level = hold if label[k] == HOLDING else (retard if label[k] == RETARDED else 0.0)
            while last < count and label[last] == label[k]:
                span += length[last]
                drift += (source[last, 1] + level * growth[last, 1]) * length[last]
                scale += source[last, 1] * length[last]
                free = free and w[last] < cap[last] * (1.0 - TOUCH) and w[last + 1] < cap[last] * (1.0 - TOUCH)
                steady = abs(w[last + 1] - w[last]) <= _STEADY * w[last]
                free = free and not (steady and w[last] > ceiling[last] * (1.0 - TOUCH))
                last += 1
            short = span <= sliver
            if k > 0 and last < count and label[k - 1] == label[last]:
                short = short or span < _MOMENT * (length[k - 1] + length[last])
            if sweep == 1:
                partial = is_partial(label[k])
                short = (partial and scale < _NO_DRIFT) or (free and abs(drift) > _OFF_HOLDING * scale)
            if short:
                neighbour = label[k - 1] if k > 0 else (label[last] if last < count else label[k])
                for j in range(k, last):
                    label[j] = neighbour
            k = last


@leaf
def slides(k, w, cap):
    """Whether the run keeps the limit all along a cell."""
    top = cap[k] * (1.0 - TOUCH)
    return w[k] >= top and w[k + 1] >= top


@kernel
def phase_end(k, label, w, cap):
    """First cell after the phase of cell k: another regime, or the run meets or leaves the limit there."""
    j = k + 1
    while j < label.shape[0] and label[j] == label[k]:
        touches = w[j] >= min(cap[j - 1], cap[j]) * (1.0 - TOUCH)
        peak = w[j] >= w[j - 1] and w[j] >= w[j + 1] and (w[j] > w[j - 1] or w[j] > w[j + 1])
        meets_drop = label[k] == COASTING and cap[j] < cap[j - 1] and w[j] < w[j - 1]
        if not is_partial(label[k]) and touches and (peak or meets_drop):
            break
        j += 1
    return j
