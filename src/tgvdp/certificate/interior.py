"""The largest sum of least values of linear functions along a chain of nodes: an interior point method.

Each group of rows has a least value min(const + coef·unknowns), over unknowns of one or two neighbouring nodes,
and the sum of all of them and of a linear function is to be as large as possible. With a slack of each row to a number
below its group this is a linear program. Newton steps keep the product of each slack and its multiplier about the
same, ever smaller number, corrected for what both steps together change (Mehrotra, SIAM J. Optim. 2, 1992); the
multipliers of a group become weights that add up to 1. What is left of a step is a system of `blocks` along the chain.
Means and moments of a group are those of its runs (`program`), joined.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, part
from tgvdp.certificate.blocks import Blocks, blocks_for, factor, solve
from tgvdp.certificate.program import DIFFER, Program, of_row, of_run

#: Share of the way to the next bound that a step takes.
_SHARE = 0.95
#: Steps at most.
_MOST_STEPS = 250


class Progress(NamedTuple):
    """Steps that were made, and whether there is no other."""

    steps: int
    ended: bool


BEGIN = Progress(0, False)


class Room(NamedTuple):
    """What steps are made in, float64.

    Weights of all runs, (Q,), their mean coefficients, (Q, 4), and those of groups, (G, n); moments of a group, (n, n);
    what a run is off the mean of its group, and a sum, (n,).
    """

    blocks: Blocks
    weight: NDArray[np.float64]
    run_mean: NDArray[np.float64]
    mean: NDArray[np.float64]
    moments: NDArray[np.float64]
    off: NDArray[np.float64]
    pushed: NDArray[np.float64]


def room_for(program: Program) -> Room:
    """Room for the steps of a program."""
    groups, count = program.unknown.shape
    runs = len(program.base)
    blocks = blocks_for(*program.linear.shape)
    return Room(
        blocks, np.zeros(runs), np.zeros((runs, DIFFER)), np.zeros((groups, count)), np.zeros((count, count)),
        np.zeros(count), np.zeros(count),
    )  # fmt: skip


@part
def _begin(program, values):
    """Slacks and shares at given unknowns."""
    for g in range(program.least.shape[0]):
        u = program.unknown[g]
        first, last = program.run[program.first[g]], program.run[program.first[g + 1]]
        least = math.inf
        for q in range(program.first[g], program.first[g + 1]):
            run = of_run(program, q, u, values)
            for i in range(program.run[q], program.run[q + 1]):
                program.slack[i] = program.const[i] + run + of_row(program, i, q, u, values)
                least = min(least, program.slack[i])
        program.least[g] = least - program.least[g]
        total = 0.0
        for i in range(first, last):
            program.slack[i] -= program.least[g]
            total += 1.0 / program.slack[i]
        for i in range(first, last):
            program.share[i] = 1.0 / (program.slack[i] * total)


@part
def _weigh_run(program, q, room):
    """The weight of a run, each row by how near it is to its bound, and its mean coefficients."""
    weight, mean = 0.0, room.run_mean[q]
    mean[:] = 0.0
    for i in range(program.run[q], program.run[q + 1]):
        one = program.share[i] / program.slack[i]
        weight += one
        for j in range(DIFFER):
            mean[j] += one * program.coef[i, j]
    for j in range(DIFFER):
        mean[j] /= max(weight, 1e-300)  # rows of a whole run may be that far from their bounds
    room.weight[q] = weight


@part
def _weigh_group(program, g, room):
    """Weights and mean coefficients of a group and of its runs."""
    weight, mean = 0.0, room.mean[g]
    mean[:] = 0.0
    for q in range(program.first[g], program.first[g + 1]):
        _weigh_run(program, q, room)
        weight += room.weight[q]
        for j in range(mean.shape[0]):
            mean[j] += room.weight[q] * program.base[q, j]
        for j in range(DIFFER):
            mean[program.column[q, j]] += room.weight[q] * room.run_mean[q, j]
    for j in range(mean.shape[0]):
        mean[j] /= weight


@part
def _put_off(program, g, q, room):
    """What the mean coefficients of a run are off those of its group."""
    for j in range(room.off.shape[0]):
        room.off[j] = program.base[q, j] - room.mean[g, j]
    for j in range(DIFFER):
        room.off[program.column[q, j]] += room.run_mean[q, j]


@part
def _fill_moments(program, g, room):
    """Second moments of the rows of a group, about its mean, above the diagonal."""
    moments, off = room.moments, room.off
    moments[:] = 0.0
    for q in range(program.first[g], program.first[g + 1]):
        column, mean = program.column[q], room.run_mean[q]
        for i in range(program.run[q], program.run[q + 1]):
            one = program.share[i] / program.slack[i]
            for j in range(DIFFER):
                by = one * (program.coef[i, j] - mean[j])
                for m in range(j, DIFFER):
                    moments[column[j], column[m]] += by * (program.coef[i, m] - mean[m])
        if program.first[g + 1] - program.first[g] > 1:
            _put_off(program, g, q, room)
            for j in range(off.shape[0]):
                by = room.weight[q] * off[j]
                for m in range(j, off.shape[0]):
                    moments[j, m] += by * off[m]


@part
def _fill_blocks(program, room):
    """The blocks of the system of a step."""
    own = program.linear.shape[1]
    blocks, moments = room.blocks, room.moments
    count = moments.shape[0]
    blocks.own[:] = 0.0
    blocks.link[:] = 0.0
    for g in range(program.least.shape[0]):
        u = program.unknown[g]
        _weigh_group(program, g, room)
        _fill_moments(program, g, room)
        for j in range(count):
            node, which = u[j] // own, u[j] % own
            for m in range(j, count):
                other = u[m] - own * node
                if other >= own:
                    blocks.link[node, which, other - own] += moments[j, m]
                else:
                    blocks.own[node, which, other] += moments[j, m]
                    if m > j:
                        blocks.own[node, other, which] += moments[j, m]


@part
def _fill_side(program, aim, room):
    """The right side of the system of a step that aims at products of slack and share."""
    own, side, pushed = program.linear.shape[1], room.blocks.side, room.pushed
    for k in range(program.linear.shape[0]):
        for j in range(own):
            side[k * own + j] = program.linear[k, j]
    for g in range(program.least.shape[0]):
        for j in range(pushed.shape[0]):
            pushed[j] = room.mean[g, j]
        for q in range(program.first[g], program.first[g + 1]):
            column, mean, total = program.column[q], room.run_mean[q], 0.0
            for i in range(program.run[q], program.run[q + 1]):
                push = (aim - program.crossed[i]) / program.slack[i]
                total += push
                for j in range(DIFFER):
                    pushed[column[j]] += push * (program.coef[i, j] - mean[j])
            _put_off(program, g, q, room)
            for j in range(pushed.shape[0]):
                pushed[j] += total * room.off[j]
        for j in range(pushed.shape[0]):
            side[program.unknown[g, j]] += pushed[j]


@part
def _steps(program, aim, step):
    """Steps of slacks and shares that belong to one of the unknowns; how far they may go, of slacks and of shares."""
    far, far_share = 1.0, 1.0
    for g in range(program.least.shape[0]):
        u = program.unknown[g]
        weight, rest = 0.0, 1.0
        for q in range(program.first[g], program.first[g + 1]):
            run = of_run(program, q, u, step)
            for i in range(program.run[q], program.run[q + 1]):
                one = program.share[i] / program.slack[i]
                program.slack_step[i] = run + of_row(program, i, q, u, step)
                weight += one
                rest += one * program.slack_step[i] - (aim - program.crossed[i]) / program.slack[i]
        for i in range(program.run[program.first[g]], program.run[program.first[g + 1]]):
            slack, share = program.slack[i], program.share[i]
            by_slack = program.slack_step[i] - rest / weight
            by_share = (aim - program.crossed[i] - share * (slack + by_slack)) / slack
            program.slack_step[i] = by_slack
            program.share_step[i] = by_share
            if by_slack < 0.0:
                far = min(far, -_SHARE * slack / by_slack)
            if by_share < 0.0:
                far_share = min(far_share, -_SHARE * share / by_share)
    return far, far_share


@part
def _products(program, far, far_share):
    """Sum of the products of slacks and shares after so much of their steps."""
    total = 0.0
    for i in range(program.const.shape[0]):
        slack = program.slack[i] + far * program.slack_step[i]
        total += slack * (program.share[i] + far_share * program.share_step[i])
    return total


@part
def _find_step(program, product, room):
    """The next step of all unknowns: what a step to the bounds themselves comes to tells what to aim at.

    Returns how far slacks and shares may go.
    """
    rows = program.const.shape[0]
    blocks = room.blocks
    _fill_blocks(program, room)
    factor(program.held, blocks)
    program.crossed[:] = 0.0
    _fill_side(program, 0.0, room)
    solve(blocks)
    far, far_share = _steps(program, 0.0, blocks.step)
    left = _products(program, far, far_share) / product
    for i in range(rows):
        program.crossed[i] = program.slack_step[i] * program.share_step[i]
    aim = left * left * left * product / rows
    _fill_side(program, aim, room)
    solve(blocks)
    return _steps(program, aim, blocks.step)


@kernel
def improve(program, values, enough, most, before, room):
    """Move the unknowns towards the largest sum.

    Parameters
    ----------
    program : Program
    values : (N·m,) float64, modified in place
        Unknowns.
    enough : float
        Sum of the products of slacks and shares that is small enough: what the sum may still gain.
    most : int
        Steps at most until it returns.
    before : Progress
        What it returned before, to go on; `BEGIN` to begin.
    room : Room

    Returns
    -------
    Progress
    """
    steps, ended = before
    if steps == 0:
        _begin(program, values)
    rows = program.const.shape[0]
    for _ in range(most):
        product = 0.0
        for i in range(rows):
            product += program.slack[i] * program.share[i]
        ended = not product > enough or steps == _MOST_STEPS
        if ended:
            break
        steps += 1
        far, far_share = _find_step(program, product, room)
        for i in range(rows):
            program.slack[i] += far * program.slack_step[i]
            program.share[i] += far_share * program.share_step[i]
        for k in range(values.shape[0]):
            values[k] += far * room.blocks.step[k]
    return Progress(steps, ended)
