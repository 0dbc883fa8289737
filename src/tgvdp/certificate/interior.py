"""The largest sum of least values of linear functions along a chain of nodes: an interior point method.

Each group of rows has a least value min(const + coef·unknowns), over unknowns of one or two neighbouring nodes,
and the sum of all of them and of a linear function is to be as large as possible. With a slack of each row to a number
below its group this is a linear program. Newton steps keep the product of each slack and its multiplier about the
same, ever smaller number, corrected for what both steps together change (Mehrotra, SIAM J. Optim. 2, 1992); the
multipliers of a group become weights that add up to 1. What is left of a step is a system of `blocks` along the chain.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, leaf, part
from tgvdp.certificate.blocks import Blocks, blocks_for, factor, solve

#: Share of the way to the next bound that a step takes.
_SHARE = 0.95
#: Steps at most.
_MOST_STEPS = 250


class Program(NamedTuple):
    """Rows in groups, and room for the solution; float64 where not said otherwise.

    Attributes
    ----------
    coef, const : (R, n), (R,)
        Of each row.
    first : (G + 1,) int64
        First row of each group.
    unknown : (G, n) int64
        Which they are, m times the node and which one of it; those of a later node last. One that stands there twice
        has a coefficient of 0 the second time.
    linear : (N, m)
        Coefficients of the linear function.
    held : (N, m) bool
        Unknowns that stay as they are.
    slack, share, slack_step, share_step, crossed : (R,)
        Slacks and multipliers, their steps, and products of these.
    least : (G,)
        How far below the least value of each group its number begins; then that number to begin with.
    """

    coef: NDArray[np.float64]
    const: NDArray[np.float64]
    first: NDArray[np.int64]
    unknown: NDArray[np.int64]
    linear: NDArray[np.float64]
    held: NDArray[np.bool_]
    slack: NDArray[np.float64]
    share: NDArray[np.float64]
    slack_step: NDArray[np.float64]
    share_step: NDArray[np.float64]
    crossed: NDArray[np.float64]
    least: NDArray[np.float64]


def program_for(nodes: int, own: int, rows: int, groups: int) -> Program:
    """Room for a program of so many nodes with so many unknowns each; a group has one more."""
    return Program(
        np.zeros((rows, own + 1)), np.zeros(rows), np.zeros(groups + 1, dtype=np.int64),
        np.zeros((groups, own + 1), dtype=np.int64), np.zeros((nodes, own)), np.zeros((nodes, own), dtype=np.bool_),
        np.zeros(rows), np.zeros(rows), np.zeros(rows), np.zeros(rows), np.zeros(rows), np.zeros(groups),
    )  # fmt: skip


def used_part(program: Program, groups: int) -> Program:
    """The first groups of a program."""
    rows = int(program.first[groups])
    return program._replace(
        coef=program.coef[:rows],
        const=program.const[:rows],
        first=program.first[: groups + 1],
        unknown=program.unknown[:groups],
        slack=program.slack[:rows],
        share=program.share[:rows],
        slack_step=program.slack_step[:rows],
        share_step=program.share_step[:rows],
        crossed=program.crossed[:rows],
        least=program.least[:groups],
    )


class Progress(NamedTuple):
    """Steps that were made, and whether there is no other."""

    steps: int
    ended: bool


BEGIN = Progress(0, False)


class Room(NamedTuple):
    """What steps are made in, float64: mean rows of all groups, (G, n); moments of one, (n, n); and a sum, (n,)."""

    blocks: Blocks
    mean: NDArray[np.float64]
    moments: NDArray[np.float64]
    pushed: NDArray[np.float64]


def room_for(program: Program) -> Room:
    """Room for the steps of a program."""
    groups, count = program.unknown.shape
    blocks = blocks_for(*program.linear.shape)
    return Room(blocks, np.zeros((groups, count)), np.zeros((count, count)), np.zeros(count))


@leaf
def _row(program, i, u, values):
    """coef·unknowns of a row."""
    total = 0.0
    for j in range(u.shape[0]):
        total += program.coef[i, j] * values[u[j]]
    return total


@part
def _begin(program, values):
    """Slacks and shares at given unknowns."""
    for g in range(program.least.shape[0]):
        u = program.unknown[g]
        least = math.inf
        for i in range(program.first[g], program.first[g + 1]):
            program.slack[i] = program.const[i] + _row(program, i, u, values)
            least = min(least, program.slack[i])
        program.least[g] = least - program.least[g]
        total = 0.0
        for i in range(program.first[g], program.first[g + 1]):
            program.slack[i] -= program.least[g]
            total += 1.0 / program.slack[i]
        for i in range(program.first[g], program.first[g + 1]):
            program.share[i] = 1.0 / (program.slack[i] * total)


@part
def _mean_of(program, g, mean):
    """The mean coefficients of the rows of a group, each weighed by how near it is to its bound."""
    weight = 0.0
    mean[:] = 0.0
    for i in range(program.first[g], program.first[g + 1]):
        one = program.share[i] / program.slack[i]
        weight += one
        for j in range(mean.shape[0]):
            mean[j] += one * program.coef[i, j]
    for j in range(mean.shape[0]):
        mean[j] /= weight


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
        mean = room.mean[g]
        _mean_of(program, g, mean)
        moments[:] = 0.0
        for i in range(program.first[g], program.first[g + 1]):
            one = program.share[i] / program.slack[i]
            for j in range(count):
                off = one * (program.coef[i, j] - mean[j])
                for m in range(j, count):
                    moments[j, m] += off * (program.coef[i, m] - mean[m])
        for j in range(count):
            node, which = u[j] // own, u[j] % own
            for m in range(j, count):
                if u[m] // own > node:
                    blocks.link[node, which, u[m] % own] += moments[j, m]
                else:
                    blocks.own[node, which, u[m] % own] += moments[j, m]
                    if m > j:
                        blocks.own[node, u[m] % own, which] += moments[j, m]


@part
def _fill_side(program, aim, room):
    """The right side of the system of a step that aims at products of slack and share."""
    own, side, pushed = program.linear.shape[1], room.blocks.side, room.pushed
    for k in range(program.linear.shape[0]):
        for j in range(own):
            side[k * own + j] = program.linear[k, j]
    for g in range(program.least.shape[0]):
        mean = room.mean[g]
        pushed[:] = 0.0
        for i in range(program.first[g], program.first[g + 1]):
            push = (aim - program.crossed[i]) / program.slack[i]
            for j in range(mean.shape[0]):
                pushed[j] += push * (program.coef[i, j] - mean[j])
        for j in range(mean.shape[0]):
            side[program.unknown[g, j]] += mean[j] + pushed[j]


@part
def _steps(program, aim, step):
    """Steps of slacks and shares that belong to one of the unknowns; how far they may go, of slacks and of shares."""
    far, far_share = 1.0, 1.0
    for g in range(program.least.shape[0]):
        u = program.unknown[g]
        weight, rest = 0.0, 1.0
        for i in range(program.first[g], program.first[g + 1]):
            one = program.share[i] / program.slack[i]
            program.slack_step[i] = _row(program, i, u, step)
            weight += one
            rest += one * program.slack_step[i] - (aim - program.crossed[i]) / program.slack[i]
        for i in range(program.first[g], program.first[g + 1]):
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
