"""The largest sum of least values of linear functions along a chain of nodes: an interior point method.

Each group of rows has a least value min(const + coef·unknowns), over four unknowns of one or two neighbouring nodes,
and the sum of all of them and of a linear function is to be as large as possible. With a slack of each row to a number
below its group this is a linear program. Newton steps keep the product of each slack and its multiplier about the
same, ever smaller number (Mehrotra, SIAM J. Optim. 2, 1992, without his corrections); the multipliers of a group become
weights that add up to 1. What is left of a step is a system of blocks along the chain, solved from end to end.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, leaf, part

#: Unknowns of a node.
AT_NODE = 3
#: Share of the way to the next bound that a step takes.
_SHARE = 0.95
#: Share of the mean product that a step aims at after one that went most of its way, some of it, and little.
_AIMS = 0.1, 0.3, 0.6
#: Second derivative of unknowns that stay as they are, and of all others, relative to their own.
_HELD, _LEAST_BEND = 1e30, 1e-9
#: Steps at most.
_MOST_STEPS = 250


class Program(NamedTuple):
    """Rows in groups, and room for the solution; float64 where not said otherwise.

    Attributes
    ----------
    coef, const : (R, 4), (R,)
        Of each row.
    first : (G + 1,) int64
        First row of each group.
    unknown : (G, 4) int64
        Which they are, `AT_NODE` times the node and which one of it; those of a later node last.
    linear : (N, AT_NODE)
        Coefficients of the linear function.
    held : (N, AT_NODE) bool
        Unknowns that stay as they are.
    slack, share, slack_step, share_step : (R,)
        Slacks and multipliers.
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
    least: NDArray[np.float64]


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
        least=program.least[:groups],
    )


class Progress(NamedTuple):
    """Steps that were made, the share of the mean product that the next one aims at, and whether there is none."""

    steps: int
    aimed: float
    ended: bool


BEGIN = Progress(0, _AIMS[1], False)


class Blocks(NamedTuple):
    """A system along a chain: right side (N, 3), blocks on and beside the diagonal (N, 3, 3), solution (N, 3)."""

    side: NDArray[np.float64]
    own: NDArray[np.float64]
    link: NDArray[np.float64]
    step: NDArray[np.float64]


@leaf
def _row(program, i, u, values):
    """coef·unknowns of a row."""
    total = 0.0
    for j in range(4):
        total += program.coef[i, j] * values[u[j] // AT_NODE, u[j] % AT_NODE]
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
def _fill(program, aim, mean, moments, blocks):
    """The system of a step that aims at a product of slack and share; ``mean`` (4,) and ``moments`` (5, 4) are room."""
    blocks.own[:] = 0.0
    blocks.link[:] = 0.0
    for k in range(program.linear.shape[0]):
        for j in range(AT_NODE):
            blocks.side[k, j] = program.linear[k, j]
    for g in range(program.least.shape[0]):
        u = program.unknown[g]
        weight = 0.0
        mean[:] = 0.0
        for i in range(program.first[g], program.first[g + 1]):
            one = program.share[i] / program.slack[i]
            weight += one
            for j in range(4):
                mean[j] += one * program.coef[i, j]
        for j in range(4):
            mean[j] /= weight
        moments[:] = 0.0
        for i in range(program.first[g], program.first[g + 1]):
            one = program.share[i] / program.slack[i]
            for j in range(4):
                off = program.coef[i, j] - mean[j]
                moments[4, j] += aim / program.slack[i] * off
                for m in range(j, 4):
                    moments[j, m] += one * off * (program.coef[i, m] - mean[m])
        for j in range(4):
            node, which = u[j] // AT_NODE, u[j] % AT_NODE
            blocks.side[node, which] += mean[j] + moments[4, j]
            for m in range(j, 4):
                if u[m] // AT_NODE > node:
                    blocks.link[node, which, u[m] % AT_NODE] += moments[j, m]
                else:
                    blocks.own[node, which, u[m] % AT_NODE] += moments[j, m]
                    if m > j:
                        blocks.own[node, u[m] % AT_NODE, which] += moments[j, m]


@part
def _solve(held, blocks):
    """Solve a system by Cholesky's decomposition of its blocks, in place."""
    side, own, link, step = blocks
    for k in range(side.shape[0]):
        for j in range(AT_NODE):
            own[k, j, j] += _HELD if held[k, j] else _LEAST_BEND * own[k, j, j] + 1e-300
            if k > 0:
                for i in range(AT_NODE):
                    side[k, j] -= link[k - 1, i, j] * side[k - 1, i]
                    for m in range(AT_NODE):
                        own[k, j, m] -= link[k - 1, i, j] * link[k - 1, i, m]
        for j in range(AT_NODE):  # lower triangle, and side and link divided by it
            for m in range(j + 1):
                for i in range(m):
                    own[k, j, m] -= own[k, j, i] * own[k, m, i]
                if m < j:
                    own[k, j, m] /= own[k, m, m]
            own[k, j, j] = math.sqrt(max(own[k, j, j], 1e-300))
            for i in range(j):
                side[k, j] -= own[k, j, i] * side[k, i]
                for m in range(AT_NODE):
                    link[k, j, m] -= own[k, j, i] * link[k, i, m]
            side[k, j] /= own[k, j, j]
            for m in range(AT_NODE):
                link[k, j, m] /= own[k, j, j]
    for k in range(side.shape[0] - 1, -1, -1):
        for j in range(AT_NODE - 1, -1, -1):
            value = side[k, j]
            if k + 1 < side.shape[0]:
                for m in range(AT_NODE):
                    value -= link[k, j, m] * step[k + 1, m]
            for i in range(j + 1, AT_NODE):
                value -= own[k, i, j] * step[k, i]
            step[k, j] = value / own[k, j, j]


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
            rest += one * program.slack_step[i] - aim / program.slack[i]
        for i in range(program.first[g], program.first[g + 1]):
            slack, share = program.slack[i], program.share[i]
            by_slack = program.slack_step[i] - rest / weight
            by_share = (aim - share * (slack + by_slack)) / slack
            program.slack_step[i] = by_slack
            program.share_step[i] = by_share
            if by_slack < 0.0:
                far = min(far, -_SHARE * slack / by_slack)
            if by_share < 0.0:
                far_share = min(far_share, -_SHARE * share / by_share)
    return far, far_share


@kernel
def improve(program, values, enough, most, before, mean, moments, blocks):
    """Move the unknowns towards the largest sum.

    Parameters
    ----------
    program : Program
    values : (N, AT_NODE) float64, modified in place
        Unknowns.
    enough : float
        Sum of the products of slacks and shares that is small enough: what the sum may still gain.
    most : int
        Steps at most until it returns.
    before : Progress
        What it returned before, to go on; `BEGIN` to begin.
    mean, moments : (4,), (5, 4) float64
    blocks : Blocks
        Scratch.

    Returns
    -------
    Progress
    """
    steps, aimed, ended = before
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
        aim = aimed * product / rows
        _fill(program, aim, mean, moments, blocks)
        _solve(program.held, blocks)
        far, far_share = _steps(program, aim, blocks.step)
        for i in range(rows):
            program.slack[i] += far * program.slack_step[i]
            program.share[i] += far_share * program.share_step[i]
        for k in range(values.shape[0]):
            for j in range(AT_NODE):
                values[k, j] += far * blocks.step[k, j]
        went = min(far, far_share)
        aimed = _AIMS[0] if went > 0.8 else (_AIMS[1] if went > 0.4 else _AIMS[2])
    return Progress(steps, aimed, ended)
