"""Runs that take given times, side by side: blends of the extremals of a mesh around each time."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.cores import shares, side_by_side
from tgvdp.methods.costate.blend import Blend
from tgvdp.methods.costate.extremal import Extremal
from tgvdp.methods.costate.interpolate import RUN_COLUMNS, Scratch, drive
from tgvdp.methods.costate.mesh import Mesh, Run
from tgvdp.physics.cell import overrun
from tgvdp.physics.codes import NO_ROOM, NOT_MET, NOT_TRIED, OK

_Floats = NDArray[np.float64]

#: Cells of runs that are worth a thread of its own, a tenth of a microsecond or two each.
_LEAST_CELLS = 2500
#: Groups of times for each core: next to the fastest run they take more runs, and some end early.
_GROUPS_OF_A_CORE = 2
#: Rows of a run, per cell, for which there is room: most take half as many.
_ROWS_PER_CELL = 6
_NO_PASSED = np.empty((0, 0, 0))


class Met(NamedTuple):
    """How it went with one of the times.

    Attributes
    ----------
    status : int
        OK, NOT_MET, NOT_KEPT, or NOT_TRIED where an earlier time between the same extremals went wrong.
    second : int
        The slower one of the extremals around it.
    run : Run or None
        The run, where all is well.
    bracket : (2, K + 1, 4) float64 or None
        Where a time is not met, the policies between which running times jump over it.
    """

    status: int
    second: int
    run: Run | None = None
    bracket: _Floats | None = None


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
) -> list[Met]:
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
    list of Met
        One for each time. What is between two extremals does not depend on what is elsewhere.
    """
    policies = np.array([one.switch for one in extremals])
    known = np.array([one.outcome for one in extremals])
    wanted = _Wanted(policies, known, losses, tolerance_s)
    second = np.maximum(np.searchsorted(known[:-1, 0], target_s), min(1, len(known) - 1))
    groups = list(_groups(second, shares(len(target_s) * len(mesh.cells.length_m), _LEAST_CELLS, _GROUPS_OF_A_CORE)))
    if len(groups) > 1:
        mesh.share()
    found = side_by_side(lambda group: _met(mesh, wanted, target_s[group], second[group]), groups)
    counters["runs"] += sum(runs for _, runs in found)
    return [met for mets, _ in found for met in mets]


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


def _met(mesh: Mesh, wanted: _Wanted, target_s: _Floats, second: NDArray[np.intp]) -> tuple[list[Met], int]:
    """Meet times on this thread; returns how it went, and the number of runs."""
    room = mesh.room
    room.fit_kept(_ROWS_PER_CELL * len(mesh.cells.length_m) * len(target_s))
    room.resumed[0] = -1.0
    blend = Blend(*np.empty((3, *wanted.policies.shape[1:])))
    found: list[Met] = []
    count = 0
    runs = np.empty((len(target_s), RUN_COLUMNS))
    while len(found) < len(target_s):
        start = len(found)
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
        rows = runs[start : start + done].tolist()
        stored = int(next((row[1] for row in reversed(rows) if row[8] == OK), 0))
        x_m, w = room.kept.x[:stored].copy(), room.kept.w[:stored].copy()
        for from_row, to_row, time_s, energy_j, multiplier, low, high, second_at, how in rows:
            at = int(second_at)
            if how == OK:
                of_run = slice(int(from_row), int(to_row))
                found.append(Met(OK, at, Run(time_s, energy_j, multiplier, x_m[of_run], w[of_run])))
            elif how == NOT_MET:
                found.append(Met(NOT_MET, at, bracket=np.array([blend.at(low), blend.at(high)])))
            else:
                found.append(Met(int(how), at))
        if status == NOT_MET:
            rest = int(np.sum(second[len(found) :] == second[len(found) - 1]))
            found += [Met(NOT_TRIED, int(second[len(found) - 1]))] * rest
        elif status == NO_ROOM and not done:
            room.double_kept()
    return found, count
