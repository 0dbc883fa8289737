"""Running times and energies are those of a run that is driven: rows are short enough for 5e-6."""

import pytest

from tests.helpers.fronts import front_to
from tests.helpers.trips import EFFICIENT_HILLS, HILLS, trip_on
from tests.helpers.twins.trips import level_trip
from tgvdp.model.effort import EffortCurve
from tgvdp.model.train import Train
from tgvdp.referee.replay import replay
from tgvdp.runs.profile import profile_of

#: Long cells at partial effort on climbs that coasting begins with a reserve for.
WAVES = trip_on([(0, 42)], [(1500.0 * i, 9.0 if i % 2 else -9.0) for i in range(20)], length_m=30e3)
METRO = level_trip(
    Train(
        mass_kg=2e5,
        traction=EffortCurve.from_caps(2e5, 3e6),
        friction_brake_n=2e5,
        davis_a_n=3e3,
        davis_c_n_per_mps2=6.0,
    ),
    1500.0,
    22.0,
)


@pytest.mark.parametrize(
    "trip", [HILLS, EFFICIENT_HILLS, WAVES, METRO], ids=["hills", "regeneration", "waves", "metro"]
)
def test_times_and_energies_are_those_of_the_replay(trip):
    _, found = front_to(trip, 0.25, 6)
    verdicts = [replay(trip, profile_of(trip, *found.rows(index))) for index in range(len(found.duration_s))]
    assert max(abs(verdict.time_error_pct) for verdict in verdicts) < 5e-4
    assert max(abs(verdict.energy_error_pct) for verdict in verdicts) < 5e-4
    assert max(verdict.effort_excess_pct for verdict in verdicts) < 1e-2
