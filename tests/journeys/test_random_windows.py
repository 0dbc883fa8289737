"""Random windows between stops on random lines: against all paths of a grid, and against a bound that knows them."""

from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tests.helpers.grid_windows import least_energy_j
from tests.helpers.trips import commuter
from tgvdp.errors import InfeasibleError
from tgvdp.methods.grid.grid import build_grid
from tgvdp.model.journey import Journey, TimingPoint
from tgvdp.model.trip import Trip
from tgvdp.verification.trips import random_track

#: On the sixth the fastest run of a part is its thriftiest.
FEW, MORE = (0, 1, 6), range(2, 30)
#: What a timetable is met to, s.
MET_S = 0.1
#: Half of the points are nearer to their bound than this, %: where no run is slower on purpose, multipliers tell all.
NEAR_PCT = 0.1


class Case:
    """A train over a random line with one or two windows at stations of a grid, around where another run would be."""

    def __init__(self, seed):
        random = np.random.default_rng([seed, 15])
        line = random_track(seed, 38.0, (2.5e3, 9e3))
        self.train = commuter()
        self.line = replace(line, stops_m=(0.0, line.length_m))
        trip = Trip(train=self.train, track=self.line, origin_m=0.0, destination_m=self.line.length_m)
        self.grid = build_grid(trip, self.line.length_m / 16.0, 18)
        count = int(random.integers(1, 3))
        inside = np.flatnonzero(np.abs(self.grid.station_m / self.line.length_m - 0.5) < 0.35)
        self.stations = np.sort(random.choice(inside, count, replace=False)).tolist()
        free = tgvdp.journey(self.train, self.line, at_margin=(random.uniform(0.08, 0.3),))
        profile = free.profile(0)
        slower = random.uniform(0.95, 1.05)
        points = []
        for station in self.stations:
            at_m = float(self.grid.station_m[station])
            passed_s = float(np.interp(at_m, profile.position_m, profile.time_s))
            earliest_s = passed_s * slower + random.uniform(-4.0, 0.0)
            points.append(TimingPoint(at_m, earliest_s, earliest_s + random.choice([2.0, 5.0, 10.0])))
        self.points = points
        first, last = (
            TimingPoint(at_m, earliest_s, 1e9, 0.0, 0.0)
            for at_m, earliest_s in zip(self.line.stops_m, (0.0, -np.inf), strict=True)
        )
        self.timetable = Journey(points=(first._replace(latest_s=0.0), *points, last), track=self.line.name)

    def run(self):
        return tgvdp.journey(self.train, self.line, self.timetable, points=5, max_margin=0.35)


def check(seed):
    """Gaps of the points of a random journey, %, that keeps its windows and is no dearer than any path of the grid."""
    case = Case(seed)
    try:
        journey = case.run()
    except InfeasibleError as error:
        assert "it is missed by" in str(error)
        return np.empty(0)
    for index in range(len(journey.front)):
        profile = journey.profile(index)
        for point in case.points:
            passed_s = np.interp(point.position_m, profile.position_m, profile.time_s)
            assert point.earliest_s - MET_S <= passed_s <= point.latest_s + MET_S
    assert all(verdict.ok for point in journey.verify() for verdict in point)
    bound = journey.certify()
    assert (journey.front.energy_j >= bound.lower_bound_j).all()
    windows = {station: point[1:3] for station, point in zip(case.stations, case.points, strict=True)}
    least_j = least_energy_j(case.grid, windows, journey.front.time_s)
    assert (journey.front.energy_j <= least_j * (1.0 + 1e-3))[1:].all()
    assert (least_j >= bound.lower_bound_j)[1:].all()
    return bound.gap_pct(journey.front.energy_j)[1:]


def check_all(seeds):
    gap_pct = np.concatenate([check(seed) for seed in seeds])
    assert len(gap_pct) > len(seeds)
    assert np.median(gap_pct) < NEAR_PCT


def test_random_windows():
    check_all(FEW)


@pytest.mark.slow
def test_more_random_windows():
    check_all(MORE)
