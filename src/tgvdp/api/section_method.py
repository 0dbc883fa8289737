"""Least energies of a section of a journey by the front method, within what is left of time and memory."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tgvdp.api.methods import continuous_front
from tgvdp.api.sense import sensible_numbers
from tgvdp.methods.budget import Clock, SearchBudget
from tgvdp.methods.costate.front import OptimalRuns
from tgvdp.methods.refine.extremals import Extremals
from tgvdp.model.trip import Trip
from tgvdp.runs.profile import Profile


@dataclass(frozen=True, eq=False)
class SectionMethod:
    """Method of a `tgvdp.journeys.section.SectionRuns`.

    Attributes
    ----------
    trip : Trip
        The section, whose extremals are kept from one call to the next; not those of trips that differ from it.
    clock : Clock
        Of whoever wants runs now: after it has run out none are found.
    max_memory_b : float or None
    rough : bool
        Well enough to choose speeds by, in less time.
    """

    trip: Trip
    clock: Clock
    max_memory_b: float | None
    rough: bool = False
    _known: list[Extremals] = field(default_factory=list)

    def __call__(self, asked: Trip, fastest: Profile, target_s: NDArray[np.float64], tolerance_s: float) -> OptimalRuns:
        """Find the runs of the section, or of one that differs in what it charges, at running times, s."""
        known, left = self._known if asked is self.trip else None, SearchBudget().after(self.clock)
        with sensible_numbers(asked, self.max_memory_b):
            return continuous_front(asked, fastest, target_s, left, tolerance_s, rough=self.rough, known=known)
