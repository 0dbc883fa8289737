"""Trips that many tests drive: a commuter train, short lines, and the published references."""

import csv

import numpy as np

from tgvdp.formats import load_track, load_train
from tgvdp.model.effort import EffortCurve
from tgvdp.model.track import Track
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip


def commuter(**changes):
    values = {
        "mass_kg": 3e5,
        "traction": EffortCurve.from_caps(2.5e5, 3.5e6),
        "braking": EffortCurve.from_caps(1.5e5, 3e6),
        "friction_brake_n": 1e5,
        "rotating_mass_factor": 1.06,
        "davis_a_n": 3e3,
        "davis_b_n_per_mps": 30.0,
        "davis_c_n_per_mps2": 6.0,
        "max_speed_mps": 44.0,
        "name": "commuter",
    }
    return Train(**(values | changes))


def trip_on(limits, gradients=(), length_m=10e3, train=None, **speeds):
    track = Track(length_m=length_m, speed_limits=tuple(limits), gradients=tuple(gradients))
    values = {"origin_m": 0.0, "destination_m": length_m} | speeds
    return Trip(train=train or commuter(), track=track, **values)


def reference_cases(shared):
    """Rows of the reference for wheel energy, one per trip."""
    with open(shared / "reference" / "optimum.csv", encoding="utf-8") as file:
        rows = {
            (row["track"], row["train"], row["from_stop_m"], row["to_stop_m"]): row
            for row in csv.DictReader(file)
            if row["variant"] == "A"
        }
    return list(rows.values())


def reference_trip(shared, row):
    folder = shared / "ttobench"
    track = load_track(folder / "tracks" / f"{row['track']}.json")
    train = load_train(folder / "trains" / f"{row['train']}.json")
    ends = {"origin_m": float(row["from_stop_m"]), "destination_m": float(row["to_stop_m"])}
    return Trip(train=train, track=track, **ends)


HILLS = trip_on([(0, 35), (6000, 22)], [(0, 0), (2000, 12), (4000, -9), (8000, 3)])


EFFICIENT = commuter(traction_efficiency=0.85, regeneration_efficiency=0.75)


EFFICIENT_HILLS = trip_on([(0, 35), (6000, 22)], [(0, 0), (2000, 12), (4000, -9), (8000, 3)], train=EFFICIENT)


def references(shared, variant):
    """Trips of the reference with running times and energies in J, by increasing time."""
    with open(shared / "reference" / "optimum.csv", encoding="utf-8") as file:
        rows = sorted(csv.DictReader(file), key=lambda row: float(row["T_s"]))
    trips = {}
    for row in rows:
        if row["variant"] == variant:
            key = tuple(row[name] for name in ("track", "train", "from_stop_m", "to_stop_m"))
            trips.setdefault(key, []).append(row)
    for mine in trips.values():
        seconds = np.array([float(row["T_s"]) for row in mine])
        joules = 3.6e6 * np.array([float(row["E_ref_kWh"]) for row in mine])
        yield reference_trip(shared, mine[0]), seconds, joules
