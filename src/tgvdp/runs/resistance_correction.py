"""From a run on steps of the resistance to a run under the true one (see `line.resolved`).

With the same effort at each position, the true run differs inside a step by

    w_true(x) = w_step(x) + 2/m_eff·∫(G_step − G + (C_step − C)·w) ds,    zero at both ends of the step.

Where something else than the effort is given, that is kept instead: a speed that is held, a comfort limit, a braking
rate. Rows are cut until the difference is nearly linear along each of them.
"""

import numpy as np

from tgvdp.line.piecewise import Floats
from tgvdp.line.resolved import ResolvedLine
from tgvdp.model.train import Train
from tgvdp.physics.forces import kernel_train
from tgvdp.runs.effort_jumps import cut_at_jumps
from tgvdp.runs.resistance_correction_follow import follow_rows
from tgvdp.runs.resistance_correction_kernel import count_parts, cut_rows


def follow(train: Train, line: ResolvedLine, x_m: Floats, w: Floats) -> tuple[Floats, Floats]:
    """Follow the true resistance with a run that was found on steps.

    Parameters
    ----------
    train : Train
    line : ResolvedLine
    x_m, w : (n,) float64
        Rows of the run: positions from the origin, m, with all breaks among them, and squared speeds, m²/s².

    Returns
    -------
    x_m, w : (m,) float64
        Rows of the run with the same effort, or the same acceleration or speed where that is what is kept; at most
        the speed limit.
    """
    given = x_m
    x_m, w = cut_at_jumps(train, line, x_m, w)
    if line.even and x_m is given:
        return x_m, w
    known = kernel_train(train)
    parts = np.empty(len(x_m) - 1, dtype=np.int64)
    count = count_parts(line, x_m, w, parts) + 1
    cut_m, cut_w, followed = np.empty((3, count))
    cut_rows(known, line, x_m, w, parts, cut_m, cut_w)
    drops_mps = np.array(train.traction_limit.jumps_mps)
    kept = np.empty((2, count - 1), dtype=np.bool_)
    follow_rows(known, line, drops_mps, cut_m, cut_w, followed, np.empty((7, count)), *kept)
    return cut_m, followed
