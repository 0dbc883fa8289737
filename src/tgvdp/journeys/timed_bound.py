"""A certificate for journeys with windows: one multiplier for each part, and what the windows let time cost.

For any multipliers λ of the parts, every journey that keeps its windows takes E ≥ Σ c(λ) − max Σ λT: c(λ) is the least
E + Σ λT of a section's runs (`certificate.line`), and the largest Σ λT of all clocks within the windows follows stop by
stop and point by point, as it is a sum of terms of one time each, but for the dwells. Good multipliers are those of the
journey itself. They change where a window binds, and nowhere else; so they are made equal where none does.

Who waits draws P. So all energies are less P·T of the time that runs take, and P times what lies between the two ends
of the journey comes on top (`journeys.waiting`).
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.certificate.line_maker import least_cost_j
from tgvdp.cores import side_by_side
from tgvdp.errors import TgvdpError
from tgvdp.journeys.bound import JourneyBound
from tgvdp.journeys.passed import PassedRuns, passing
from tgvdp.journeys.waiting import waiting_for_free
from tgvdp.journeys.windows import Windows
from tgvdp.methods.budget import Clock

_Floats = NDArray[np.float64]

#: A part before a stop where the train waits has no multiplier: it gets this share of the journey's mean power, ...
_LEAST = 1e-3
#: ... and one that runs at its fastest has an infinite one: these multiples of it are tried.
_MOST = (4.0, 40.0, 400.0)


#: Who is nearer to the end of a window is there, s: running times are met to less.
_AT_END_S = 0.1
#: Relative to the largest of the terms of a sum: more than its rounding.
_ROUNDING = 1e-12


def timed_bound(
    sections: Sequence[PassedRuns],
    windows: Windows,
    waiting_w: float,
    run: NDArray[np.int64],
    departure_s: _Floats,
    clock: Clock,
) -> JourneyBound:
    """Bound the least energy of all journeys that keep the windows and end no later than each of some.

    Parameters
    ----------
    sections : sequence of PassedRuns
    windows : Windows
    waiting_w : float
        What is drawn in waiting, W.
    run : (n, sections) int64
        Each section's run of each journey.
    departure_s : (n, sections) float64
        When each section begins, on the journey's clock, s.
    clock : Clock
        Ends the work between two journeys; those that were not reached have no bound.
    """

    def bounded(at: int) -> float:
        return math.nan if clock.expired else _bound_j(sections, windows, waiting_w, run[at], departure_s[at], clock)

    lower_j = np.array(side_by_side(bounded, range(len(departure_s))))
    lower_j[np.isinf(lower_j)] = math.nan
    return JourneyBound(lower_j, not clock.expired)


def _bound_j(
    sections: Sequence[PassedRuns],
    windows: Windows,
    waiting_w: float,
    run: NDArray[np.int64],
    departure_s: _Floats,
    clock: Clock,
) -> float:
    """Bound for one journey, J."""
    runs = [section.runs[own] for section, own in zip(sections, run.tolist(), strict=True)]
    leaving_s = np.concatenate(
        [start_s + np.append(0.0, run.ends_s[:-1]) for start_s, run in zip(departure_s, runs, strict=True)]
    )
    coming_s = np.concatenate([start_s + run.ends_s for start_s, run in zip(departure_s, runs, strict=True)])
    fastest_s = np.concatenate(
        [_fastest_s(one, windows, own) for one, own in zip(sections, windows.sections, strict=True)]
    )
    box = box_of(windows, fastest_s.tolist(), float(coming_s[-1]))
    changes = changes_of(windows, box, leaving_s, coming_s, _AT_END_S)
    own = np.concatenate([run.multiplier_j_per_s for run in runs])
    size_j = sum(abs(run.profile.total_energy_j) for run in runs)
    mean_w = size_j / sum(run.profile.duration_s for run in runs)
    best_j = -math.inf
    for most in _MOST if own.max() > _MOST[0] * mean_w else _MOST[:1]:
        usable = np.clip(own, _LEAST * mean_w, most * mean_w)
        multiplier = one_where_none_binds(usable, coming_s - leaving_s, changes)
        parts_j = [
            -most_cost_j(windows, box, multiplier, waiting_w),
            *_least_costs_j(sections, windows, multiplier, size_j, clock),
        ]
        best_j = max(best_j, sum(parts_j) - _ROUNDING * sum(map(abs, parts_j)))
    return best_j


def _least_costs_j(
    sections: Sequence[PassedRuns], windows: Windows, multiplier: _Floats, size_j: float, clock: Clock
) -> Iterator[float]:
    """Lower bound of E + Σ λT of each section, less what is drawn in waiting, J; −∞ where its costate program fails."""
    for section, numbers in zip(sections, windows.sections, strict=True):
        own = multiplier[list(numbers)]
        at_m = [windows.arrivals[number].position_m for number in numbers[:-1]]
        credits = tuple(zip(at_m, np.diff(own).tolist(), strict=True))
        trip = replace(waiting_for_free(section.trip), credits=credits)
        try:
            yield least_cost_j(trip, section.fastest, float(own[-1]), size_j, clock)
        except TgvdpError:
            yield -math.inf


def _fastest_s(section: PassedRuns, windows: Windows, numbers: Sequence[int]) -> _Floats:
    """Times of the parts in the fastest run, s: no run is faster anywhere."""
    ends_m = np.array([windows.arrivals[number].position_m for number in numbers])
    return np.diff(passing(section.fastest, ends_m)[0], prepend=0.0)


class Box(NamedTuple):
    """Between which times the train can begin and end each part, s, (parts,) each."""

    first_departure_s: _Floats
    last_departure_s: _Floats
    first_arrival_s: _Floats
    last_arrival_s: _Floats


def box_of(windows: Windows, fastest_s: Sequence[float], arrival_s: float) -> Box:
    """Times that windows, dwells and fastest runs of the parts, s, leave to a journey that ends by an arrival, s."""
    count = len(fastest_s)
    first, last = np.empty((2, count)), np.empty((2, count))
    for at in range(count):
        departs, arrives = windows.departures[at], windows.arrivals[at]
        begins_s = windows.start_s if at == 0 else first[1, at - 1] + (windows.dwells_s[at - 1] or 0.0)
        first[0, at] = max(begins_s, departs.earliest_s)
        first[1, at] = max(first[0, at] + fastest_s[at], arrives.earliest_s)
    for at in reversed(range(count)):
        departs, arrives = windows.departures[at], windows.arrivals[at]
        ends_s = arrival_s if at == count - 1 else last[0, at + 1] - (windows.dwells_s[at] or 0.0)
        last[1, at] = min(ends_s, arrives.latest_s)
        last[0, at] = min(last[1, at] - fastest_s[at], departs.latest_s)
    return Box(first[0], last[0], first[1], last[1])


def one_where_none_binds(multiplier_j_per_s: _Floats, time_s: _Floats, changes: Sequence[bool]) -> _Floats:
    """Multipliers of parts made equal from one change to the next: their mean by times, s."""
    group = np.concatenate(([0], np.cumsum(changes, dtype=np.int64)))
    mean = np.bincount(group, time_s * np.log(multiplier_j_per_s)) / np.bincount(group, time_s)
    return np.asarray(np.exp(mean)[group])


def most_cost_j(windows: Windows, box: Box, multiplier_j_per_s: _Floats, waiting_w: float) -> float:
    """The largest Σ λT of all journeys within a box, less what is drawn in waiting all the time but for dwells, J."""
    rates = multiplier_j_per_s.tolist()
    ends = float(box.first_arrival_s[-1]), float(box.last_arrival_s[-1])
    stands_s = windows.start_s + sum(dwell_s or 0.0 for dwell_s in windows.dwells_s)
    cost_j: float = max((rates[-1] - waiting_w) * end_s for end_s in ends) + waiting_w * stands_s
    cost_j -= rates[0] * float(box.first_departure_s[0])
    for at, dwell_s in enumerate(windows.dwells_s):
        before, after = rates[at], rates[at + 1]
        arrival_s = float(box.first_arrival_s[at]), float(box.last_arrival_s[at])
        departure_s = float(box.first_departure_s[at + 1]), float(box.last_departure_s[at + 1])
        if dwell_s is None:
            cost_j += max((before - after) * own_s for own_s in arrival_s)
        else:  # the train stands for the dwell at least, which has a multiplier of its own, not below 0
            cost_j += min(
                max((before - own) * own_s for own_s in arrival_s)
                + max((own - after) * own_s for own_s in departure_s)
                - own * dwell_s
                for own in (0.0, before, after)
            )
    return cost_j


def changes_of(windows: Windows, box: Box, departure_s: _Floats, arrival_s: _Floats, slack_s: float) -> list[bool]:
    """Whether the multiplier may change behind each part but the last, of a journey's departures and arrivals, s."""
    found = []
    for at, dwell_s in enumerate(windows.dwells_s):
        bounds = [
            (arrival_s[at], box.first_arrival_s[at]),
            (arrival_s[at], box.last_arrival_s[at]),
            (departure_s[at + 1], box.first_departure_s[at + 1]),
            (departure_s[at + 1], box.last_departure_s[at + 1]),
        ]
        waits = dwell_s is not None and departure_s[at + 1] - arrival_s[at] > dwell_s + slack_s
        found.append(waits or any(abs(own_s - bound_s) <= slack_s for own_s, bound_s in bounds))
    return found
