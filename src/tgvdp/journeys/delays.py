"""What an allocation costs and is late when departures are delayed and runs are disturbed: by simulation.

A supplement is there for delays. Who departs late runs faster, as far as the section's front reaches, until the train
is in its timetable again; that takes more energy. All allocations meet the same delays (common random numbers), so that
their differences are not those of chance.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InputError
from tgvdp.journeys.section import SectionRuns
from tgvdp.model.checks import require_number
from tgvdp.pareto import ParetoFront

_Floats = NDArray[np.float64]


class Delays(NamedTuple):
    """What happens to a train, s, (scenarios, sections): each departure is late by, each run is held up by."""

    departure_s: _Floats
    running_s: _Floats


def standard_delays(
    fastest_s: Sequence[float], mean_s: float, disturbance: float = 0.02, scenarios: int = 2000, seed: int = 1
) -> Delays:
    """Exponential delays, the usual model of small ones (Schwanhäußer, 1974).

    Parameters
    ----------
    fastest_s : sequence of float
        Fastest running times of the sections, s.
    mean_s : float
        Mean delay of each departure, s.
    disturbance : float
        Mean time by which runs are held up, as a share of their fastest running times.
    scenarios, seed : int
        How many, and what they are drawn from.

    Raises
    ------
    InputError
        When a mean is negative, or there are no scenarios.
    """
    require_number("delays", "mean_s", mean_s, "s", at_least=0.0)
    require_number("delays", "disturbance", disturbance, "as a share", at_least=0.0)
    if scenarios < 1:
        raise InputError(f"delays: scenarios must be at least 1, got {scenarios}")
    random = np.random.default_rng(seed)
    departure_s, running_s = random.exponential(size=(2, scenarios, len(fastest_s)))
    return Delays(mean_s * departure_s, disturbance * np.asarray(fastest_s) * running_s)


@dataclass(frozen=True, eq=False)
class Robustness:
    """Allocations of one journey time under the same delays.

    Attributes
    ----------
    names : tuple of str
        The optimum, today's practices, and mixtures of both by their shares.
    planned_j, energy_j : (n,) float64
        Energy as planned, and expected, J.
    delay_s : (n,) float64
        Expected delay over all arrivals at stops, s.
    punctual : (n,) float64
        Share of the journeys that end within a minute of their timetable.
    front : ParetoFront
        The second front: of these, none is both less late and cheaper; its ``time_s`` are delays.
    """

    names: tuple[str, ...]
    planned_j: _Floats
    energy_j: _Floats
    delay_s: _Floats
    punctual: _Floats
    front: ParetoFront

    @property
    def on_both(self) -> int:
        """Number of the allocation that was planned cheapest of those on the second front."""
        return int(self.front.source[np.argmin(self.planned_j[self.front.source])])


#: Shares of a practice in a mixture with the optimum.
_SHARES = np.arange(1, 10) / 10.0
#: Who ends within this time of the timetable is punctual, s.
_PUNCTUAL_S = 60.0


def robustness(
    sections: Sequence[SectionRuns], allocations_s: dict[str, _Floats], dwell_s: float, delays: Delays
) -> Robustness:
    """Simulate allocations and their mixtures.

    Parameters
    ----------
    sections : sequence of SectionRuns
        With the runs found so far, between which energies are interpolated.
    allocations_s : dict of str to (sections,) float64
        Running times of the sections, s, by name; the first is mixed with each other one.
    dwell_s : float
        Least standstill at each stop, s.
    delays : Delays
    """
    (_, best_s), *others = allocations_s.items()
    named = dict(allocations_s)
    for name, own_s in others:
        named |= {f"{100.0 * share:.0f} % {name}": best_s + share * (own_s - best_s) for share in _SHARES}
    figures = [_simulated(sections, own_s, dwell_s, delays) for own_s in named.values()]
    planned_j, energy_j, delay_s, punctual = np.array(figures).T
    return Robustness(tuple(named), planned_j, energy_j, delay_s, punctual, ParetoFront.of(delay_s, energy_j))


def _simulated(
    sections: Sequence[SectionRuns], planned_s: _Floats, dwell_s: float, delays: Delays
) -> tuple[float, float, float, float]:
    """Planned and expected energy, J, expected delay, s, and the share of punctual journeys."""
    scenarios = len(delays.departure_s)
    arrival_s, timetable_s = np.full(scenarios, -dwell_s), -dwell_s
    energy_j, late_s = np.zeros(scenarios), np.zeros(scenarios)
    planned_j = 0.0
    for number, (section, own_s) in enumerate(zip(sections, planned_s.tolist(), strict=True)):
        departure_s = np.maximum(timetable_s, arrival_s) + dwell_s + delays.departure_s[:, number]
        timetable_s += dwell_s + own_s
        held_s = delays.running_s[:, number]
        running_s = np.clip(timetable_s - departure_s - held_s, section.fastest.duration_s, own_s)
        arrival_s = departure_s + running_s + held_s
        energy_j += np.interp(running_s, section.front.time_s, section.front.energy_j)
        planned_j += float(np.interp(own_s, section.front.time_s, section.front.energy_j))
        late_s += np.maximum(arrival_s - timetable_s, 0.0)
    punctual = float(np.mean(arrival_s - timetable_s <= _PUNCTUAL_S))
    return planned_j, float(energy_j.mean()), float(late_s.mean()) / len(sections), punctual
