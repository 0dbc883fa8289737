"""Random trips of the catalog's trains: what the referee says of their runs, and how far the certificate lets them be.

A survey of ten times as many trips, and trains of all kinds, with a polish of its own, is `make proof`.
"""

from collections.abc import Iterator

import numpy as np

from tgvdp.api.run import search
from tgvdp.formats import load_train
from tgvdp.model import catalog
from tgvdp.verification.balance import balance_error
from tgvdp.verification.case import Case, equal
from tgvdp.verification.trips import random_track

PART = "survey of random trips"
_TRIPS, _POINTS, _LENGTH_M = 24, 12, (1.5e3, 80e3)


def cases() -> Iterator[Case]:
    """One case per question, over all trips."""
    trains = [load_train(name) for name in catalog.names("train")]
    refused, points, gaps_pct, balance, times_pct, energies_pct = 0, 0, [], [], [], []
    for seed in range(_TRIPS):
        train = trains[seed % len(trains)]
        result = search(train, random_track(seed, train.max_speed_mps, _LENGTH_M), points=_POINTS)
        verdicts = result.verify()
        refused += sum(not verdict.ok for verdict in verdicts)
        points += len(verdicts)
        times_pct += [abs(verdict.time_error_pct) for verdict in verdicts]
        energies_pct += [abs(verdict.energy_error_pct) for verdict in verdicts]
        gaps_pct.append(float(np.max(result.certify().gap_pct[2:], initial=0.0)))
        balance += [balance_error(result.trip, result.profile(index)) for index in range(len(result.front))]
    all_points = f"all points of {_TRIPS} trips"
    yield equal(PART, f"{all_points}: refused by the referee", refused, 0.0, 15.0, points)
    yield equal(PART, f"{all_points}: running time by the referee, largest error, %", max(times_pct), 0.0, 4.0, 100.0)
    yield equal(PART, f"{all_points}: energy by the referee, largest error, %", max(energies_pct), 0.0, 3.5, 100.0)
    yield equal(PART, f"{all_points}: energy balance, largest share missing", max(balance), 0.0, 9.0, 1.0)
    yield equal(PART, f"{_TRIPS} trips: certified gap, median, %", float(np.median(gaps_pct)), 0.0, 3.0, 100.0)
    yield equal(PART, f"{_TRIPS} trips: certified gap, largest, %", max(gaps_pct), 0.0, 1.5, 100.0)
