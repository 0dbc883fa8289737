"""A small result made by hand, of the real classes, for the tests of the report."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.api import Fastest, SearchResult
from tgvdp.model.effort import EffortCurve
from tgvdp.model.track import Track
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip
from tgvdp.pareto import ParetoFront
from tgvdp.referee.replay import Verdict
from tgvdp.runs.profile import profile_of

VERDICT = Verdict(
    time_error_pct=0.001,
    energy_error_pct=-0.002,
    overspeed_mps=0.0,
    effort_excess_pct=0.03,
    speed_error_mps=0.0,
    ok=True,
)
INPUTS = {
    "train": {"file": "stock.xml", "sha256": "5a" * 32, "notes": ["a note"]},
    "track": {"name": "hilly", "sha256": "c3" * 32},
}
PROVENANCE = {"tgvdp": "0.1.0", "options": {"points": 3, "time_limit_s": 60.0}, "inputs": INPUTS, "elapsed_s": 0.25}


class Found(NamedTuple):
    """What a method hands to the façade."""

    duration_s: NDArray[np.float64]
    energy_j: NDArray[np.float64]
    rows: Callable[[int], tuple[NDArray[np.float64], NDArray[np.float64]]]


def railway_trip():
    """From 1 km to 5 km of a line with three limits, a climb and a descent."""
    return Trip(
        train=Train(
            mass_kg=4e5,
            traction=EffortCurve.from_caps(3e5, 8e6),
            friction_brake_n=3e5,
            davis_a_n=3e3,
            max_speed_mps=40.0,
            name="Test train",
        ),
        track=Track(
            length_m=6e3,
            speed_limits=((0.0, 30.0), (2000.0, 50.0), (4500.0, 25.0), (5500.0, 10.0)),
            gradients=((0.0, 0.0), (2000.0, 10.0), (3000.0, -5.0)),
            altitude_m=500.0,
            name="Test line",
        ),
        origin_m=1e3,
        destination_m=5e3,
    )


def toy_trip():
    """A unit mass on two level metres."""
    return Trip(
        train=Train(mass_kg=1.0, traction=EffortCurve.from_caps(1.0), friction_brake_n=1.0, name="unit mass"),
        track=Track(length_m=2.0, speed_limits=((0.0, 10.0),), name="two metres"),
        origin_m=0.0,
        destination_m=2.0,
    )


def make_result(trip, cruise_mps, *, complete=True):
    """Runs that speed up within a fifth of the trip, cruise and brake within a fifth, the first one the fastest."""

    def rows(index):
        x = np.union1d(np.linspace(0.0, trip.distance_m, 41), [0.5 * trip.distance_m])
        u = x / trip.distance_m
        return x, cruise_mps[index] ** 2 * np.minimum(1.0, 5.0 * np.minimum(u, 1.0 - u))

    profiles = [profile_of(trip, *rows(index)) for index in range(len(cruise_mps))]
    front = ParetoFront.of([p.duration_s for p in profiles], [p.total_energy_j for p in profiles])
    assert len(front) == len(cruise_mps)
    return SearchResult(
        trip=trip,
        method="front",
        fastest=Fastest(profiles[0].duration_s, profiles[0].total_energy_j, profiles[0]),
        front=front,
        counters={"expanded": 12, "generated": 34},
        complete=complete,
        options={"points": len(cruise_mps), "time_limit_s": 60.0, "max_memory_b": None},
        elapsed_s=0.25,
        _found=Found(front.time_s, front.energy_j, rows),
    )
