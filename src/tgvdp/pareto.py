"""The Pareto front of running time against energy.

A member is on the front when no other point is at least as fast and at least as cheap. Sorted by time, energies then
fall strictly, so that a front is two arrays and each question about it is a binary search. Of equal points the first
one given stays.
"""

import math
from dataclasses import dataclass
from numbers import Real
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tgvdp.errors import InfeasibleError, InputError
from tgvdp.units import counted, joule_to_kwh

#: Slack of selections, relative to the reference: who asks for the delay of a member, as printed, gets that member.
SELECTION_RTOL = 1e-12


@dataclass(frozen=True, eq=False, repr=False)
class ParetoFront:
    """Points of which none is at least as fast and at least as cheap as another; `of` filters any points into one.

    Parameters
    ----------
    time_s : (n,) float64
        Running times, strictly increasing, read-only.
    energy_j : (n,) float64
        Energies, strictly decreasing, read-only.
    source : (n,) int64
        Index of each member among the points that were given to `of`, read-only.

    Raises
    ------
    InputError
        When a value is not finite, lengths differ, or a member is out of order or dominated.
    """

    time_s: NDArray[np.float64]
    energy_j: NDArray[np.float64]
    source: NDArray[np.int64]

    def __post_init__(self) -> None:
        time_s, energy_j = _points(self.time_s, self.energy_j)
        source = np.array(self.source, dtype=np.int64)
        if source.shape != time_s.shape:
            raise InputError(f"front: source must have {time_s.size} members, got {source.size}")
        if not ((time_s[1:] > time_s[:-1]).all() and (energy_j[1:] < energy_j[:-1]).all()):
            raise InputError("front: times must rise and energies fall strictly; ParetoFront.of filters any points")
        for name, values in (("time_s", time_s), ("energy_j", energy_j), ("source", source)):
            values.setflags(write=False)
            object.__setattr__(self, name, values)

    def __repr__(self) -> str:
        if len(self) == 0:
            return "<ParetoFront: no points>"
        first, last = (f"{self.time_s[at]:.1f} s, {joule_to_kwh(self.energy_j[at]):.2f} kWh" for at in (0, -1))
        return f"<ParetoFront: {counted(len(self), 'point')} from {first} to {last}>"

    @classmethod
    def of(cls, time_s: ArrayLike, energy_j: ArrayLike) -> Self:
        """Filter points into their front.

        Parameters
        ----------
        time_s, energy_j : (n,) array_like
            Running times in s and energies in J, in any order; n may be 0.

        Returns
        -------
        ParetoFront

        Raises
        ------
        InputError
            When a value is not finite or the lengths differ.
        """
        times, energies = _points(time_s, energy_j)
        order = np.lexsort((energies, times))
        sorted_j = energies[order]
        keep = np.ones(order.size, dtype=np.bool_)
        keep[1:] = sorted_j[1:] < np.minimum.accumulate(sorted_j)[:-1]
        source = order[keep]
        return cls(times[source], energies[source], source)

    def __len__(self) -> int:
        return self.time_s.size

    def hypervolume(self, time_s: float, energy_j: float) -> float:
        """Area in J·s that the front dominates up to a reference point: larger is better.

        Parameters
        ----------
        time_s, energy_j : float
            The reference point; members that are not better in both coordinates add nothing.

        Raises
        ------
        InputError
            When the reference point is not finite.
        """
        _require_finite("reference time", time_s, "s")
        _require_finite("reference energy", energy_j, "J")
        heights = np.maximum(energy_j - self.energy_j, 0.0)
        widths = np.diff(np.minimum(np.append(self.time_s, time_s), time_s))
        return float(heights @ widths)

    def at_delay(self, delay_s: float, reference_time_s: float) -> int:
        """Index of the cheapest member that is at most ``delay_s`` slower than the reference.

        Raises
        ------
        InputError
            When an argument is not finite.
        InfeasibleError
            When every member is slower.
        """
        _require_finite("delay", delay_s, "s")
        _require_finite("reference time", reference_time_s, "s")
        slack_s = SELECTION_RTOL * abs(reference_time_s)
        index = int(np.searchsorted(self.time_s - reference_time_s, delay_s + slack_s, side="right")) - 1
        if index < 0:
            least = f"the least delay is {self.time_s[0] - reference_time_s:g} s" if len(self) else "the front is empty"
            raise InfeasibleError(f"front: no member within a delay of {delay_s:g} s; {least}")
        return index

    def at_saving(self, saved_fraction: float, reference_energy_j: float) -> int:
        """Index of the fastest member that saves at least ``saved_fraction`` (0.1 = 10 %) of the reference energy.

        Raises
        ------
        InputError
            When an argument is not finite or the reference is not above 0 J.
        InfeasibleError
            When no member saves as much.
        """
        _require_finite("saving", saved_fraction, "(a fraction)")
        _require_finite("reference energy", reference_energy_j, "J")
        if not reference_energy_j > 0.0:
            raise InputError(f"front: reference energy must be above 0 J, got {reference_energy_j:g} J")
        saved = 1.0 - self.energy_j / reference_energy_j
        index = int(np.searchsorted(saved, saved_fraction - SELECTION_RTOL, side="left"))
        if index == len(self):
            most = f"the largest saving is {100.0 * saved[-1]:g} %" if len(self) else "the front is empty"
            raise InfeasibleError(f"front: no member saves {100.0 * saved_fraction:g} %; {most}")
        return index


def _points(time_s: ArrayLike, energy_j: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Own copies of two equally long, finite columns."""
    times, energies = _column("time_s", time_s), _column("energy_j", energy_j)
    for name, values, unit in (("time_s", times, "s"), ("energy_j", energies, "J")):
        if values.ndim != 1:
            raise InputError(f"front: {name} must have one dimension, got {values.ndim}")
        finite = np.isfinite(values)
        if not finite.all():
            wrong = int(finite.argmin())
            raise InputError(f"front: {name}[{wrong}] must be finite, got {values[wrong]} {unit}")
    if times.size != energies.size:
        raise InputError(f"front: time_s and energy_j must be equally long, got {times.size} and {energies.size}")
    return times, energies


def _column(name: str, values: ArrayLike) -> NDArray[np.float64]:
    try:
        return np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"front: {name} must be numbers, got {values!r:.60}") from None


def _require_finite(name: str, value: Any, unit: str) -> None:
    if isinstance(value, bool) or not isinstance(value, Real):
        raise InputError(f"front: {name} must be a number, got {value!r:.60}")
    if not math.isfinite(value):
        raise InputError(f"front: {name} must be finite, got {value} {unit}")
