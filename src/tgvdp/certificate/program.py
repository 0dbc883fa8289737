"""A linear program along a chain of nodes: the sum of least values of linear functions.

These are rows, in groups of which each has one least value. Rows of a group come in runs, within which a few
coefficients differ and no other: at one end of a cell, those of all speeds in a band.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import leaf, part

#: Coefficients that differ within a run.
DIFFER = 4


class Program(NamedTuple):
    """Rows in runs in groups, and room for the solution; float64 where not said otherwise.

    Attributes
    ----------
    coef, const : (R, 4), (R,)
        Of each row: what differs within its run.
    run : (Q + 1,) int64
        First row of each run.
    base : (Q, n)
        Coefficients of each run, beside those.
    column : (Q, 4) int64
        Which ones these are added to, rising.
    first : (G + 1,) int64
        First run of each group.
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
    run: NDArray[np.int64]
    base: NDArray[np.float64]
    column: NDArray[np.int64]
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


def program_for(nodes: int, own: int, rows: int, runs: int, groups: int) -> Program:
    """Room for a program of so many nodes with so many unknowns each; a group has one more."""
    return Program(
        np.zeros((rows, DIFFER)), np.zeros(rows), np.zeros(runs + 1, dtype=np.int64), np.zeros((runs, own + 1)),
        np.tile(np.arange(DIFFER), (runs, 1)), np.zeros(groups + 1, dtype=np.int64),
        np.zeros((groups, own + 1), dtype=np.int64), np.zeros((nodes, own)), np.zeros((nodes, own), dtype=np.bool_),
        np.zeros(rows), np.zeros(rows), np.zeros(rows), np.zeros(rows), np.zeros(rows), np.zeros(groups),
    )  # fmt: skip


def used_part(program: Program, groups: int) -> Program:
    """The first groups of a program."""
    runs = int(program.first[groups])
    rows = int(program.run[runs])
    of_rows = ("coef", "const", "slack", "share", "slack_step", "share_step", "crossed")
    most = dict.fromkeys(of_rows, rows) | {"run": runs + 1, "base": runs, "column": runs}
    most |= {"first": groups + 1, "unknown": groups, "least": groups}
    return program._replace(**{name: getattr(program, name)[:count] for name, count in most.items()})


@leaf
def of_run(program, q, u, values):
    """base·unknowns of a run."""
    total = 0.0
    for j in range(u.shape[0]):
        total += program.base[q, j] * values[u[j]]
    return total


@leaf
def of_row(program, i, q, u, values):
    """coef·unknowns of a row of a run."""
    total = 0.0
    for j in range(DIFFER):
        total += program.coef[i, j] * values[u[program.column[q, j]]]
    return total


class Place(NamedTuple):
    """Where the next group, run and row of a program are written."""

    g: int
    q: int
    i: int


@part
def end_run(program, place, rows):
    """End a run of so many rows more; returns the next place."""
    program.run[place.q + 1] = place.i + rows
    return Place(place.g, place.q + 1, place.i + rows)


@part
def end_group(program, place, room):
    """End a group; returns the next place."""
    program.first[place.g + 1] = place.q
    program.least[place.g] = room
    return Place(place.g + 1, place.q, place.i)
