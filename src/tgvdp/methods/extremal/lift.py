"""What a touch of the envelope between a pinned switch and the next one is worth to the costate."""

import math

from tgvdp._jit import kernel
from tgvdp.methods.extremal.rows import is_anchor
from tgvdp.methods.extremal.switches import ACTIVE, PINNED, SIGMA
from tgvdp.methods.extremal.terms import terms_of


@kernel
def lift(train, course, commands, count, rows, n, starts, pinned, found, p_at):
    """Add to the costate between pinned switches and where the run touches the envelope what the touch is worth.

    As much as makes p at the switch its level: p' is linear in p, so that it grows as the flow shrinks.
    """
    e = 0
    for c in range(1, count):
        if pinned[c] != PINNED or found[c, ACTIVE] == 0.0:
            continue
        first = starts[c]
        touch = first
        least = math.inf
        j = first + 1
        while j < n and not is_anchor(rows.regime[j]) and rows.regime[j] == rows.regime[first + 1]:
            while e < course.x_m.shape[0] - 2 and course.x_m[e + 1] <= rows.x[j]:
                e += 1
            share = (rows.x[j] - course.x_m[e]) / (course.x_m[e + 1] - course.x_m[e])
            top = course.w[e] + (course.w[e + 1] - course.w[e]) * share
            if top - rows.w[j] < least * (1.0 + 1e-9):
                least = top - rows.w[j]
                touch = j
            j += 1
        lifted = -0.5 * found[c, SIGMA]
        p_at[first] += lifted
        for j in range(first + 1, touch):
            k = rows.cell[j]
            v = math.sqrt(0.5 * (rows.w[j - 1] + rows.w[j]))
            _, f_w, _, _, load_w, _ = terms_of(train, rows.regime[j], course.grade[k], course.air[k], v)
            lifted *= math.exp(-2.0 * (f_w - load_w) * (rows.x[j] - rows.x[j - 1]))
            p_at[j] += lifted
