"""Room for the extremals of a trip: a run, its sweep, and what Newton's steps know of each switch."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.methods.extremal.command import COMMAND_COLUMNS
from tgvdp.methods.extremal.drive import MOST_EVENTS, NUMBERS
from tgvdp.methods.extremal.rows import Rows, rows_of
from tgvdp.methods.extremal.sweep import CARRIED
from tgvdp.methods.extremal.switches import SWITCH_COLUMNS

MOST_COMMANDS = 400


class Work(NamedTuple):
    """A run and its sweep, and of each switch, (MOST_COMMANDS,) where not said otherwise:

    Attributes
    ----------
    whole, kept : Rows
        The run, and the best one before.
    place : (2,) float64
    now : (NUMBERS,) int64
    events : (MOST_EVENTS, 3) float64
        As of `drive`.
    carried : (CARRIED,) float64
    p_at, stepped_at : (size,) float64
        As of `sweep`.
    starts, pinned : int64
        As of `simulate` and `sweep`.
    found : (MOST_COMMANDS, SWITCH_COLUMNS) float64
    step, rate : float64
        Newton's step, m, and that by the multiplier.
    share, shrink : float64
        How much of its step a switch may take: for the room that there is, and after steps in vain.
    dearer : bool
        Whether the block of a switch costs more than in the best run.
    push : float64
        Step that makes a released switch ride the envelope, or 0.
    touch, miss, flow_on : float64
        Where the run from a pinned switch touches the envelope, by how much w misses it there, and the flow to there.
    gain, meets, leaves : float64
        Derivative of the cost, and where the run met and left the envelope, at the last look.
    trial, best : (MOST_COMMANDS, COMMAND_COLUMNS) float64
        Commands to be tried, and the best ones so far.
    best_step : float64
    """

    whole: Rows
    kept: Rows
    place: NDArray[np.float64]
    now: NDArray[np.int64]
    events: NDArray[np.float64]
    carried: NDArray[np.float64]
    p_at: NDArray[np.float64]
    stepped_at: NDArray[np.float64]
    starts: NDArray[np.int64]
    pinned: NDArray[np.int64]
    found: NDArray[np.float64]
    step: NDArray[np.float64]
    rate: NDArray[np.float64]
    share: NDArray[np.float64]
    shrink: NDArray[np.float64]
    dearer: NDArray[np.bool_]
    push: NDArray[np.float64]
    touch: NDArray[np.float64]
    miss: NDArray[np.float64]
    flow_on: NDArray[np.float64]
    gain: NDArray[np.float64]
    meets: NDArray[np.float64]
    leaves: NDArray[np.float64]
    trial: NDArray[np.float64]
    best: NDArray[np.float64]
    best_step: NDArray[np.float64]


def work_of(size: int) -> Work:
    """Room for runs of at most so many rows."""
    count = MOST_COMMANDS
    p_at, stepped_at = np.zeros((2, size))
    starts, pinned = np.zeros((2, count), dtype=np.int64)
    step, rate, share, shrink, push, touch, miss, flow_on, gain, meets, leaves, best_step = np.zeros((12, count))
    trial, best = np.zeros((2, count, COMMAND_COLUMNS))
    return Work(
        rows_of(size), rows_of(size), np.zeros(2), np.zeros(NUMBERS, dtype=np.int64), np.zeros((MOST_EVENTS, 3)),
        np.zeros(CARRIED), p_at, stepped_at, starts, pinned,
        np.zeros((count, SWITCH_COLUMNS)), step, rate, share, shrink, np.zeros(count, dtype=np.bool_), push, touch,
        miss, flow_on, gain, meets, leaves, trial, best, best_step,
    )  # fmt: skip
