"""Runs for times over which the running time of blended policies jumps.

First the slow policy up to one station, then the fast one: moving that station cell by cell, and blending in its own
cell alone, leaves next to no jump. What is left comes from rows that a policy drives in one way or another; two runs
that are that near are blended themselves, speed by speed, and the time of the blend has no jump at all.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel
from tgvdp.methods.costate.mesh import Mesh, Run
from tgvdp.model.train import Train
from tgvdp.physics.forces import kernel_train, mean_effort
from tgvdp.physics.roots import Bracket
from tgvdp.runs.profile import profile_of

_Floats = NDArray[np.float64]

#: Two shares of the second policy that are nearer are one.
_SAME = 1e-9
#: Runs whose squared speeds differ by this share at most are blended without looking for nearer ones.
_NEAR = 0.05
#: An effort P/v is convex in w, so that a blend of two runs at full effort asks for more than there is: this share more
#: at most.
_EXCESS = 2e-4
#: Steps that find the share of a blend of two runs.
_STEPS = 60


def bridge(
    mesh: Mesh, fast: _Floats, slow: _Floats, target_s: float, tolerance_s: float, counters: dict[str, int]
) -> Run:
    """Run between those of two policies, (K + 1, 4), that takes a time; where none is found, the next faster one."""
    pair = _pair(mesh.drive(fast, counters).copied(), mesh.drive(slow, counters).copied())
    run = _blended(mesh, pair, target_s, tolerance_s) if pair.is_near else None
    if run is not None:
        return run
    first, last = 0, len(fast)
    while last - first > 1:
        middle = (first + last) // 2
        mixed = np.concatenate((slow[:middle], fast[middle:]))
        if mesh.drive(mixed, counters).time_s < target_s:
            first = middle
        else:
            last = middle
    here = np.concatenate((slow[:first], fast[first:]))
    there = np.concatenate((slow[:last], fast[last:]))
    pair = _pair(mesh.drive(here, counters).copied(), mesh.drive(there, counters).copied())
    lo, hi = 0.0, 1.0
    while hi - lo > _SAME and pair.apart_s > tolerance_s:
        run = _blended(mesh, pair, target_s, tolerance_s) if pair.is_near else None
        if run is not None:
            return run
        share = 0.5 * (lo + hi)
        run = mesh.drive(here + share * (there - here), counters).copied()
        if run.time_s < target_s:
            lo, pair = share, _pair(run, pair.late)
        else:
            hi, pair = share, _pair(pair.quick, run)
    return _blended(mesh, pair, target_s, tolerance_s) or pair.quick


class _Pair(NamedTuple):
    """A run and a later one, positions of the rows of both, m, and their squared speeds there, m²/s²."""

    quick: Run
    late: Run
    x_m: _Floats
    quick_w: _Floats
    late_w: _Floats

    @property
    def apart_s(self) -> float:
        """By how much one is later than the other."""
        return self.late.time_s - self.quick.time_s

    @property
    def is_near(self) -> bool:
        """Whether the two are so near that a blend of them is as good as one between nearer ones."""
        apart_w = np.abs(self.quick_w - self.late_w)
        return bool((apart_w <= _NEAR * np.maximum(self.quick_w, self.late_w)).all())


def _pair(quick: Run, late: Run) -> _Pair:
    x_m = np.union1d(quick.x_m, late.x_m)
    return _Pair(quick, late, x_m, np.interp(x_m, quick.x_m, quick.w), np.interp(x_m, late.x_m, late.w))


def _blended(mesh: Mesh, pair: _Pair, target_s: float, tolerance_s: float) -> Run | None:
    """Blend of the squared speeds of two runs that takes a time between theirs; None where efforts do not allow it."""
    quick, late, x_m, quick_w, late_w = pair
    if late.time_s <= target_s + tolerance_s:
        return late
    if abs(quick.time_s - target_s) <= tolerance_s or late.time_s <= quick.time_s:
        return quick
    step_m = x_m[1:] - x_m[:-1]
    bracket = Bracket(0.0, 1.0, quick.time_s - target_s, late.time_s - target_s)
    w, speed_mps = quick_w, np.sqrt(quick_w)
    for _ in range(_STEPS):
        share = bracket.secant()
        w = quick_w + share * (late_w - quick_w)
        speed_mps = np.sqrt(w)
        f = float((2.0 * step_m / (speed_mps[:-1] + speed_mps[1:])).sum()) - target_s
        if abs(f) <= 0.1 * tolerance_s:
            break
        bracket = bracket.narrowed(share, f)
    profile = profile_of(mesh.trip, x_m, w)
    if (profile.force_n[:-1] > (1.0 + _EXCESS) * most_effort_n(mesh.trip.train, speed_mps)).any():
        return None
    energy_j = profile.total_energy_j - mesh.tables.auxiliary_w * profile.duration_s
    return Run(profile.duration_s, energy_j, math.nan, x_m, w)


def most_effort_n(train: Train, speed_mps: _Floats) -> _Floats:
    """Highest mean effort of each row between speeds (K + 1,), m/s → (K,), N."""
    most_n = np.empty(len(speed_mps) - 1)
    _fill_most_efforts(kernel_train(train).traction, speed_mps, most_n)
    return most_n


@kernel
def _fill_most_efforts(table, speed_mps, most_n):
    for i in range(most_n.shape[0]):
        most_n[i] = mean_effort(table, speed_mps[i], speed_mps[i + 1])
