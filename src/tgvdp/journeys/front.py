"""The front of a journey: least energy of all sections together for each running time of the whole journey.

The sections' fronts are sampled on common steps of time and merged exactly (`merge`), which finds the right stretch of
fronts that are not convex. From there all sections go to one multiplier (`multiplier`): each round solves the
sections at the supplements that the last one leads to, and knows their multipliers better.
"""

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.cores import side_by_side
from tgvdp.journeys.merge import Sums, least_sums
from tgvdp.journeys.multiplier import Split, demand_of, on_hull, split
from tgvdp.journeys.practices import practices
from tgvdp.journeys.section import SectionRuns
from tgvdp.methods.costate.multipliers import OutOfTime
from tgvdp.pareto import ParetoFront

_Floats = NDArray[np.float64]

#: Steps of time within the mean supplement of a section at the journey's longest running time, and how many of them
#: the sections' fronts are sampled at first.
_STEPS = 16
_FIRST_STEPS = 32
#: Rounds of solving the sections at their split, at most, and the share of the journey's energy that another one has to
#: promise.
ROUNDS = 5
SAVING = 2e-5
#: A sample that is above the hull of its front by less than this share of the energy is on it: so exact are runs.
_ON_HULL = 1e-4
#: A run that misses what it was given by more than this multiple of the tolerance stands before a jump.
_SHORT = 2.0
#: Relative difference below which steps are whole.
_SAME = 1e-9


class Allocations(NamedTuple):
    """Running time in s and energy in J of the journey, (n,), and each section's run among its own, (n, sections)."""

    time_s: _Floats
    energy_j: _Floats
    run: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class JourneyFront:
    """The front of a journey.

    Attributes
    ----------
    front : ParetoFront
        Running times without dwell, s, and energies, J.
    run : (n, sections) int64
        Each section's run at each point, among its `SectionRuns`.
    departure_s : (n, sections) float64
        When each section begins, on the clock of the journey, s.
    multiplier_j_per_s : (n, sections) float64
        The multiplier of each section: one for all but where windows part them; infinite for the fastest journey, and
        below 0 where a section runs longer than its thriftiest run in place of waiting.
    practices : dict of str to Allocations
        What today's practices make of the same running times; they know no windows.
    complete : bool
        False when a time limit ended the search.
    exhausted : bool
        Whether the front ends with the thriftiest journey: running longer saves nothing.
    left : tuple of str
        Which window is left, and by how much, where runs do not meet their times, and which arrivals are too early.
    waiting_s : (n,) float64
        How long the train waits for windows, dwells aside, s.
    waiting_w : float
        What it draws then, W: the front counts it.
    """

    front: ParetoFront
    run: NDArray[np.int64]
    departure_s: _Floats
    multiplier_j_per_s: _Floats
    practices: dict[str, Allocations]
    complete: bool
    exhausted: bool
    waiting_s: _Floats
    waiting_w: float = 0.0
    left: tuple[str, ...] = ()


def journey_front(
    sections: Sequence[SectionRuns],
    supplement_s: _Floats,
    tolerance_s: float,
    dwell_s: float = 0.0,
    expired: Callable[[], bool] = bool,
) -> JourneyFront:
    """Find the front of a journey.

    Parameters
    ----------
    sections : sequence of SectionRuns
        New ones: their runs are found here.
    supplement_s : (n,) float64
        Increasing supplements over the sum of the fastest runs, s.
    tolerance_s : float
        How well they are met, s: no point is later.
    dwell_s : float
        Standstill at each stop on the way, s.
    expired : callable, optional
        Whether the time is up: what runs are known then is split.
    """
    search = _Search(sections, supplement_s, tolerance_s / len(sections))
    shares = practices(sections, supplement_s)
    is_ended = True
    with contextlib.suppress(OutOfTime):
        samples = _sampled(search, list(shares.values()), expired)
        merged_s, is_off = samples.merged(supplement_s)
        search.attempt(merged_s, search.beside(merged_s, is_off))
        is_ended = False
    search.tried += shares.values()
    for _ in range(ROUNDS):
        common, (given_s, best) = search.split(), search.best()
        saves = search.saving_j(common, given_s, best) > SAVING * np.abs(best.energy_j)
        # The merge leaves parts of its steps: they are shared even where that promises nothing.
        saves |= common.supplement_s.sum(axis=1) - given_s.sum(axis=1) > tolerance_s
        if not saves.any():
            break
        if is_ended := is_ended or expired():
            break
        search.attempt(np.where(saves[:, None], common.supplement_s, given_s))
    taken_s, is_short = search.short()
    if is_short.any():
        search.attempt(search.beside(taken_s, is_short))
    _, best = search.best()
    front = ParetoFront.of(best.time_s, best.energy_j)
    until_next_s = dwell_s + np.column_stack([one.time_s[run] for one, run in zip(sections, best.run.T, strict=True)])
    kept = front.source
    last_s = search.fastest_s + float(supplement_s[-1])
    return JourneyFront(
        front=front,
        run=best.run[kept],
        departure_s=(np.cumsum(until_next_s, axis=1) - until_next_s)[kept],
        multiplier_j_per_s=np.repeat(common.multiplier_j_per_s[kept, None], len(sections), axis=1),
        practices={name: search.allocations(share_s[kept]) for name, share_s in shares.items()},
        complete=not is_ended and all(section.complete for section in sections),
        exhausted=all(section.exhausted for section in sections)
        and bool(front.time_s[-1] < last_s - _SHORT * tolerance_s),
        waiting_s=np.zeros(len(front)),
    )


class _Search:
    """Sections, the supplements that all of them together shall take, s, and the allocations tried so far."""

    def __init__(self, sections: Sequence[SectionRuns], supplement_s: _Floats, tolerance_s: float) -> None:
        self.sections = sections
        self.supplement_s = supplement_s
        self.tolerance_s = tolerance_s
        self.fastest_s = sum(section.fastest.duration_s for section in sections)
        self.tried: list[_Floats] = []

    def attempt(self, *allocations_s: _Floats) -> None:
        """Find the runs of allocations, (n, sections), s."""
        self.tried += allocations_s
        reach(self.sections, np.concatenate(allocations_s), self.tolerance_s)

    def saving_j(self, common: Split, given_s: _Floats, best: Allocations) -> _Floats:
        """What the common split promises to save over the best allocations, as they were given, s, J.

        A second costs a section its own run's multiplier here and the common one there, in between about their mean.
        Who leaves its fastest run saves without bound until that is solved: by a chord to the next run, whose place
        depends on the longest supplement asked for, a little time there would save next to nothing.
        """
        own = np.column_stack([one.multiplier_j_per_s[run] for one, run in zip(self.sections, best.run.T, strict=True)])
        more_s = common.supplement_s - given_s
        moves = np.isfinite(own) | (more_s > self.tolerance_s)
        above = np.subtract(own, common.multiplier_j_per_s[:, None], out=np.zeros_like(own), where=moves)
        return np.asarray(0.5 * np.sum(above * more_s, axis=1))

    def split(self) -> Split:
        """Split by one multiplier, as well as it is known."""
        return split([demand_of(section) for section in self.sections], self.supplement_s)

    def beside(self, taken_s: _Floats, stays: NDArray[np.bool_]) -> _Floats:
        """Let some sections stay with what they take, s, while the others share the rest at one multiplier."""
        shared_s = taken_s.copy()
        for staying in np.unique(stays, axis=0):
            if staying.all() or not staying.any():
                continue
            rows = np.flatnonzero((stays == staying).all(axis=1))
            free = [demand_of(section) for section, stay in zip(self.sections, staying, strict=True) if not stay]
            rest_s = self.supplement_s[rows] - taken_s[np.ix_(rows, staying)].sum(axis=1)
            shared_s[np.ix_(rows, ~staying)] = split(free, rest_s).supplement_s
        return shared_s

    def allocations(self, supplement_s: _Floats) -> Allocations:
        """What known runs within given supplements, (n, sections), s, take together."""
        run = np.column_stack(
            [one.cheapest_within(own_s) for one, own_s in zip(self.sections, supplement_s.T, strict=True)]
        )
        chosen = list(zip(self.sections, run.T, strict=True))
        time_s = np.sum([one.time_s[own] for one, own in chosen], axis=0)
        energy_j = np.sum([one.energy_j[own] for one, own in chosen], axis=0)
        return Allocations(time_s, energy_j, run)

    def best(self) -> tuple[_Floats, Allocations]:
        """The least energy of all that was tried: supplements as given, (n, sections), s, and what comes of them."""
        given_s = np.stack(self.tried[::-1])
        time_s, energy_j, run = map(np.stack, zip(*map(self.allocations, given_s), strict=True))
        best = np.argmin(energy_j, axis=0), np.arange(len(self.supplement_s))
        return given_s[best], Allocations(time_s[best], energy_j[best], run[best])

    def short(self) -> tuple[_Floats, NDArray[np.bool_]]:
        """What the sections of the best allocations take, s, and which of them take less than they were given.

        Running times jump over what these were given.
        """
        given_s, best = self.best()
        taken_s = np.column_stack(
            [one.time_s[run] - one.fastest.duration_s for one, run in zip(self.sections, best.run.T, strict=True)]
        )
        return taken_s, given_s - taken_s > _SHORT * self.tolerance_s


def reach(sections: Sequence[SectionRuns], supplement_s: _Floats, tolerance_s: float) -> None:
    """Find the runs of all sections at their columns of supplements, s, side by side."""
    side_by_side(lambda section, own_s: section.reach(own_s, tolerance_s), sections, supplement_s.T)


class _Samples(NamedTuple):
    """Fronts of the sections on common steps of time, s, merged exactly."""

    step_s: float
    energy_j: list[_Floats]
    sums: Sums

    def merged(self, supplement_s: _Floats) -> tuple[_Floats, NDArray[np.bool_]]:
        """What each section takes of supplements, s, and where it stands off its hull: no multiplier leads there."""
        most = len(self.sums.energy_j) - 1
        total = np.minimum(np.floor(supplement_s / self.step_s * (1.0 + _SAME)), most).astype(np.int64)
        steps = self.sums.steps[total]
        is_off = np.column_stack([_off_hull(own_j)[own] for own_j, own in zip(self.energy_j, steps.T, strict=True)])
        return np.asarray(self.step_s * steps), is_off


def _off_hull(energy_j: _Floats) -> NDArray[np.bool_]:
    """Which samples stand above the hull of all of them."""
    steps = np.arange(len(energy_j), dtype=np.float64)
    hull = on_hull(steps, energy_j)
    above_j = energy_j - np.interp(steps, steps[hull], energy_j[hull])
    return np.asarray(above_j > _ON_HULL * np.abs(energy_j))


def _sampled(search: _Search, others_s: Sequence[_Floats], expired: Callable[[], bool]) -> _Samples:
    """Sample the sections' fronts as far as the merge uses them up to the longest supplement.

    Runs of other allocations, (n, sections), s, are found with the first samples.
    """
    sections, tolerance_s, last_s = search.sections, search.tolerance_s, float(search.supplement_s[-1])
    total = _STEPS * len(sections) if last_s > tolerance_s else 0
    step_s = last_s / total if total else tolerance_s
    counts = [min(_FIRST_STEPS, total)] * len(sections)
    first_s = step_s * np.arange(counts[0] + 1)
    reach(sections, np.concatenate([np.tile(first_s[:, None], len(sections)), *others_s]), tolerance_s)
    while True:
        energy_j = [
            one.energy_j[one.cheapest_within(np.asarray(step_s * np.arange(count + 1)))]
            for one, count in zip(sections, counts, strict=True)
        ]
        sums = least_sums(energy_j, expired)
        most = sums.steps[: total + 1].max(axis=0)
        short = [
            at
            for at, (one, used, count) in enumerate(zip(sections, most, counts, strict=True))
            if not one.exhausted and used == count < total
        ]
        if not short:
            return _Samples(step_s, energy_j, sums)
        further = np.arange(min(counts[at] for at in short) + 1, min(2 * max(counts[at] for at in short), total) + 1)
        for at in short:
            counts[at] = min(2 * counts[at], total)
        sampled = [np.clip(further, None, counts[at]) for at in short]
        reach([sections[at] for at in short], np.asarray(step_s * np.column_stack(sampled)), tolerance_s)
