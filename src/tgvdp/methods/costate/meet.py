"""Runs that take given times, side by side: blends of the extremals of a mesh around each time."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.cores import shares, side_by_side
from tgvdp.methods.costate.blend import Blend
from tgvdp.methods.costate.extremal import Extremal
from tgvdp.methods.costate.found import Found
from tgvdp.methods.costate.interpolate import RUN_COLUMNS, Scratch, drive
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.physics.cell import Rows, overrun
from tgvdp.physics.codes import NO_ROOM, NOT_MET, NOT_TRIED, OK
from tgvdp.runs.batch import Batch

_Floats = NDArray[np.float64]

#: Cells of runs that are worth a thread of its own, a tenth of a microsecond or two each.
_LEAST_CELLS = 2500
#: Groups of times for each core: next to the fastest run they take more runs, and some end early.
_GROUPS_OF_A_CORE = 2
#: Rows of a run, per cell, for which there is room: most take half as many.
_ROWS_PER_CELL = 6
_NO_PASSED = np.empty((0, 0, 0))


class Met(NamedTuple):
    """How it went with n times.

    Attributes
    ----------
    status : (n,) float64
        OK, NOT_MET, NOT_KEPT, or NOT_TRIED where an earlier time between the same extremals went wrong.
    second : (n,) int64
        The slower one of the extremals around each.
    found : Found
        The runs of those with which all is well.
    brackets : dict of int to (2, K + 1, 4) float64
        Of times that are not met, by their numbers: the policies between which running times jump over them.
    """

    status: _Floats
    second: NDArray[np.int64]
    found: Found
    brackets: dict[int, _Floats]


class _Wanted(NamedTuple):
    """What is asked for of all threads: extremals with their policies, what a run may lose, and how well it is met."""

    policies: _Floats
    known: _Floats
    losses: _Floats
    tolerance_s: float


def meet(
    mesh: Mesh,
    extremals: Sequence[Extremal],
    losses: _Floats,
    target_s: _Floats,
    tolerance_s: float,
    counters: dict[str, int],
) -> Met:
    """Drive blends of neighbouring extremals that take given times.

    Parameters
    ----------
    mesh : Mesh
    extremals : sequence of Extremal
        In the order of their running times.
    losses : (m,) float64
        As of `interpolate.drive`.
    target_s : (n,) float64
        Increasing running times that are wanted, s.
    tolerance_s : float
        How well.
    counters : dict of str to int, modified in place

    Returns
    -------
    Met
        What is between two extremals does not depend on what is elsewhere.
    """
    policies = np.concatenate([one.switch for one in extremals]).reshape(len(extremals), *extremals[0].switch.shape)
    known = np.array([one.outcome for one in extremals])
    wanted = _Wanted(policies, known, losses, tolerance_s)
    second = np.maximum(np.searchsorted(known[:-1, 0], target_s), min(1, len(known) - 1))
    groups = list(_groups(second, shares(len(target_s) * len(mesh.cells.length_m), _LEAST_CELLS, _GROUPS_OF_A_CORE)))
    if len(groups) > 1:
        mesh.share()
    done = side_by_side(lambda group: _met(mesh, wanted, target_s[group], second[group]), groups)
    counters["runs"] += sum(one.runs for one in done)
    return Met(
        np.concatenate([one.status for one in done]), second, Found.joined([one.found for one in done]),
        {group.start + i: bracket for group, one in zip(groups, done, strict=True) for i, bracket in one.brackets},
    )  # fmt: skip


def _groups(second: NDArray[np.intp], count: int) -> Iterator[slice]:
    """Cut times into groups of about as many, with all that are between the same extremals in one of them."""
    start = 0
    for share in range(1, count + 1):
        end = max(start, len(second) * share // count)
        while 0 < end < len(second) and second[end] == second[end - 1]:
            end += 1
        if end > start:
            yield slice(start, end)
        start = end


class _Group(NamedTuple):
    """How it went with some times that are met on one thread, as of `Met`, and the number of runs."""

    status: _Floats
    found: Found
    brackets: list[tuple[int, _Floats]]
    runs: int


def _met(mesh: Mesh, wanted: _Wanted, target_s: _Floats, second: NDArray[np.int64]) -> _Group:
    """Meet times on this thread."""
    room = mesh.room
    room.fit_kept(_ROWS_PER_CELL * len(mesh.cells.length_m) * len(target_s))
    room.resumed[0] = -1.0
    blend = Blend(*np.empty((4, *wanted.policies.shape[1:])))
    found: list[Found] = []
    brackets: list[tuple[int, _Floats]] = []
    start = count = 0
    runs = np.empty((len(target_s), RUN_COLUMNS))
    while start < len(target_s):
        done, status, driven = drive(
            mesh.train, mesh.tables, mesh.course, mesh.trip.start_speed_mps**2, wanted.policies, _NO_PASSED,
            wanted.known, wanted.losses, mesh.least_energy_j, target_s[start:], wanted.tolerance_s, room.kept,
            Scratch(room.march, room.passed, blend, room.samples, room.resumed), runs[start:],
        )  # fmt: skip
        count += driven
        if overrun(room.march):
            room.double_march()
            room.resumed[0] = -1.0
            continue
        found.append(_kept(runs[start : start + done], room.kept))
        start += done
        if status == NOT_MET:
            low, high = runs[start - 1, 5:7]
            brackets.append((start - 1, np.array([blend.at(low), blend.at(high)])))
            rest = int(np.searchsorted(second, second[start - 1], side="right"))
            runs[start:rest, 7] = NOT_TRIED
            start = rest
        elif status == NO_ROOM and not done:
            room.double_kept()
    return _Group(runs[:, 7], Found.joined(found), brackets, count)


def _kept(runs: _Floats, rows: Rows) -> Found:
    """Those of some runs, (n, RUN_COLUMNS), with which all is well: their rows lie one behind the other."""
    runs = runs[runs[:, 7] == OK]
    first = np.zeros(len(runs) + 1, dtype=np.int64)
    first[1:] = runs[:, 1]
    stored = first[-1]
    return Found(runs[:, 2:5], Batch(rows.x[:stored].copy(), rows.w[:stored].copy(), first))
