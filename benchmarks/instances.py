"""What is measured on: the reference instances, where their data lie beside the project, and synthetic lines."""

import csv
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tgvdp.formats import load_track, load_train
from tgvdp.model.effort import EffortCurve
from tgvdp.model.track import Gradient, SpeedLimit, Track
from tgvdp.model.train import Train
from tgvdp.units import JOULE_PER_KWH, kmh_to_mps

#: Folder of reference data by others; absent on most machines.
SHARED = Path(__file__).resolve().parents[2] / "shared"
SEED = 2026


@dataclass(frozen=True)
class Reference:
    """Least energy at a running time, by others."""

    margin_pct: float
    time_s: float
    energy_j: float


@dataclass(frozen=True)
class Instance:
    """A trip to search, with what others found for it.

    Attributes
    ----------
    name : str
    train : Train
    track : Track
    origin_m, destination_m : float
    fastest_s : float
        Fastest running time by others; NaN where there is none.
    references : tuple of Reference
    """

    name: str
    train: Train
    track: Track
    origin_m: float
    destination_m: float
    fastest_s: float = float("nan")
    references: tuple[Reference, ...] = field(default=())

    @property
    def distance_m(self) -> float:
        """Length of the trip, m."""
        return self.destination_m - self.origin_m

    @property
    def kind(self) -> str:
        """Metro sections and main lines have bars of their own; a trip over a whole metro line counts as main line."""
        return "metro" if self.distance_m < 5e3 else "main line"

    @property
    def arguments(self) -> dict[str, object]:
        """Arguments of `tgvdp.search`."""
        return {
            "train": self.train, "track": self.track, "origin_m": self.origin_m, "destination_m": self.destination_m,
        }  # fmt: skip


def reference_instances(shared: Path = SHARED) -> list[Instance]:
    """All instances of variant A (energy at the wheel) of the reference table; none where it is absent."""
    table = shared / "reference" / "optimum.csv"
    if not table.is_file():
        return []
    with table.open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["variant"] == "A"]
    return list(_grouped(rows, shared / "ttobench"))


def _grouped(rows: list[dict[str, str]], folder: Path) -> Iterator[Instance]:
    keys = ("track", "train", "from_stop_m", "to_stop_m")
    groups = dict.fromkeys(tuple(row[key] for key in keys) for row in rows)
    for group in groups:
        members = [row for row in rows if tuple(row[key] for key in keys) == group]
        track = load_track(folder / "tracks" / f"{group[0]}.json")
        origin_m, destination_m = float(group[2]), float(group[3])
        whole = (origin_m, destination_m) == (0.0, track.length_m)
        yield Instance(
            name=group[0] if whole else f"{group[0]} {origin_m:g}–{destination_m:g} m",
            train=load_train(folder / "trains" / f"{group[1]}.json"),
            track=track,
            origin_m=origin_m,
            destination_m=destination_m,
            fastest_s=float(members[0]["T_min_s"]),
            references=tuple(
                Reference(float(row["margin_pct"]), float(row["T_s"]), float(row["E_ref_kWh"]) * JOULE_PER_KWH)
                for row in members
            ),
        )


def synthetic_train() -> Train:
    """A four-car electric multiple unit of round figures."""
    return Train(
        mass_kg=250e3,
        traction=EffortCurve.from_caps(250e3, 3.5e6),
        braking=EffortCurve.from_caps(200e3, 3.5e6),
        friction_brake_n=50e3,
        rotating_mass_factor=1.06,
        davis_a_n=3000.0,
        davis_b_n_per_mps=30.0,
        davis_c_n_per_mps2=7.0,
        max_acceleration_mps2=1.0,
        max_deceleration_mps2=0.9,
        max_speed_mps=kmh_to_mps(160.0),
        name="synthetic EMU",
    )


def synthetic_track(length_m: float, seed: int = SEED) -> Track:
    """A rolling line: limits of 80 to 160 km/h every 2 to 8 km, gradients within ±12 ‰ every 0.4 to 2 km."""
    random = np.random.default_rng(seed)

    def breaks_m(shortest_m: float, longest_m: float) -> np.ndarray:
        count = int(length_m / shortest_m) + 1
        position_m = np.concatenate(([0.0], np.cumsum(np.round(random.uniform(shortest_m, longest_m, count), -1))))
        return position_m[position_m < length_m - shortest_m]

    limit_m, gradient_m = breaks_m(2e3, 8e3), breaks_m(400.0, 2e3)
    limit_kmh = 10.0 * random.integers(8, 17, len(limit_m))
    permil = np.round(random.uniform(-12.0, 12.0, len(gradient_m)), 1)
    limits = [SpeedLimit(float(x_m), kmh_to_mps(float(kmh))) for x_m, kmh in zip(limit_m, limit_kmh, strict=True)]
    gradients = [Gradient(float(x_m), float(value)) for x_m, value in zip(gradient_m, permil, strict=True)]
    return Track(
        length_m=length_m,
        speed_limits=tuple(limits),
        gradients=tuple(gradients),
        name=f"synthetic {length_m / 1e3:g} km, seed {seed}",
    )


def synthetic_instance(length_m: float) -> Instance:
    """The synthetic train on a synthetic line."""
    return Instance(f"synthetic {length_m / 1e3:g} km", synthetic_train(), synthetic_track(length_m), 0.0, length_m)
