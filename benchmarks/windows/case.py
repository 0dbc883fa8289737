"""A train over a random line with one or two windows at stations of a grid, around where another run would be."""

from dataclasses import replace
from typing import Any

import numpy as np

import tgvdp
from tgvdp.methods.grid.grid import build_grid
from tgvdp.model.effort import EffortCurve
from tgvdp.model.energy import EnergyModel
from tgvdp.model.journey import Journey, TimingPoint
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip
from tgvdp.verification.trips import random_track

#: Highest limit of the lines, m/s, and their length, m.
_TOP_MPS, _LENGTH_M = 38.0, (2e3, 5e3)
#: Stretches and speeds of the grid.
_STRETCHES, _SPEEDS = 16, 14
#: Windows lie within this share of the line around its middle, and are so wide, s.
_INSIDE, _WIDTHS_S = 0.35, (2.0, 5.0, 10.0)
#: They lie around the times of a run with so much supplement, which are scaled and shifted by so much, s.
_MARGIN, _SCALE, _SHIFT_S = (0.08, 0.3), (0.95, 1.05), (-4.0, 0.0)
#: ... or scaled by so much: later than runs that save energy pass.
_LATE = (1.15, 1.8)


class Case:
    """One case, named by its seed.

    Parameters
    ----------
    seed : int
    late : bool
        Whether windows open late.

    Attributes
    ----------
    energy : str
        At the wheel, or at the pantograph with auxiliaries.
    train : Train
    line : Track
        Its stops are its ends.
    grid : Grid
        Of the explicit search, finer than it is by default.
    windows : dict of int to TimingPoint
        By the stations of the grid.
    timetable : Journey
    """

    def __init__(self, seed: int, late: bool = False) -> None:
        random = np.random.default_rng([seed, 15])
        line = random_track(seed, _TOP_MPS, _LENGTH_M)
        self.line = replace(line, stops_m=(0.0, line.length_m))
        self.energy = ("wheel", "pantograph")[seed % 2]
        self.train = _train(float(random.uniform(1.5e5, 4.5e5)))
        trip = Trip(
            train=self.train,
            track=self.line,
            origin_m=0.0,
            destination_m=self.line.length_m,
            energy=EnergyModel(self.energy),
        )
        self.grid = build_grid(trip, self.line.length_m / _STRETCHES, _SPEEDS)
        inside = np.flatnonzero(np.abs(self.grid.station_m / self.line.length_m - 0.5) < _INSIDE)
        stations = np.sort(random.choice(inside, int(random.integers(1, 3)), replace=False)).tolist()
        free = self._journey(None, at_margin=(random.uniform(*_MARGIN),)).profile(0)
        scale = random.uniform(*(_LATE if late else _SCALE))
        self.windows: dict[int, TimingPoint] = {}
        for station in stations:
            at_m = float(self.grid.station_m[station])
            passed_s = float(np.interp(at_m, free.position_m, free.time_s))
            earliest_s = passed_s * scale + float(random.uniform(*_SHIFT_S))
            self.windows[station] = TimingPoint(at_m, earliest_s, earliest_s + float(random.choice(_WIDTHS_S)))
        first, last = (TimingPoint(at_m, lowest_mps=0.0, highest_mps=0.0) for at_m in self.line.stops_m)
        points = (first._replace(earliest_s=0.0, latest_s=0.0), *self.windows.values(), last)
        self.timetable = Journey(points=points, track=self.line.name)

    def journey(self) -> tgvdp.JourneyResult:
        """What is judged."""
        return self._journey(self.timetable, points=4, max_margin=0.3)

    def _journey(self, timetable: Journey | None, **options: Any) -> tgvdp.JourneyResult:
        return tgvdp.journey(self.train, self.line, timetable, energy=self.energy, **options)


def _train(mass_kg: float) -> Train:
    return Train(
        name="commuter",
        mass_kg=mass_kg,
        rotating_mass_factor=1.06,
        traction=EffortCurve.from_caps(2.5e5, 3.5e6),
        braking=EffortCurve.from_caps(1.5e5, 3e6),
        friction_brake_n=1e5,
        davis_a_n=3e3,
        davis_b_n_per_mps=30.0,
        davis_c_n_per_mps2=6.0,
        max_speed_mps=44.0,
        traction_efficiency=0.87,
        regeneration_efficiency=0.8,
        auxiliary_power_w=5e4,
    )
