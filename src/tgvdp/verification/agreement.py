"""The methods against each other and against the certificate, at the pantograph, on the same trips.

Front method, clean runs and refinement aim at the same continuous optimum. A grid holds only some of all runs, so that
none of its paths may be cheaper than these. Nothing at all may lie below the certificate. The refinement takes its
energy from a map, here one that says what the train's efficiencies say.
"""

from collections.abc import Iterator

import numpy as np

from tgvdp.api.result import SearchResult
from tgvdp.api.run import search
from tgvdp.model.effort import EffortCurve
from tgvdp.model.energy import EnergyMap
from tgvdp.model.track import Track
from tgvdp.model.train import Train
from tgvdp.units import JOULE_PER_KWH, SECONDS_PER_MINUTE
from tgvdp.verification.balance import balance_error
from tgvdp.verification.case import Case, at_most, equal
from tgvdp.verification.trips import random_track

PART, BALANCE_PART = "agreement of methods", "energy balance"
_FORCE_N, _POWER_W, _TOP_MPS = 2e5, 3e6, 45.0
TRAIN = Train(
    mass_kg=2.5e5,
    traction=EffortCurve.from_caps(_FORCE_N, _POWER_W),
    braking=EffortCurve.from_caps(_FORCE_N, _POWER_W),
    friction_brake_n=5e4,
    rotating_mass_factor=1.06,
    davis_a_n=3e3,
    davis_b_n_per_mps=30.0,
    davis_c_n_per_mps2=7.0,
    max_speed_mps=_TOP_MPS,
    traction_efficiency=0.85,
    regeneration_efficiency=0.7,
    name="four-car unit",
)
_SEEDS, _TIMES = (1, 2), 4
_SEGMENT_M, _SPEEDS = 500.0, 24


def cases() -> Iterator[Case]:
    """All methods on each line; the energy balance of all their profiles."""
    for seed in _SEEDS:
        track = random_track(seed, _TOP_MPS, (3e3, 12e3))
        exact = _on_grid(track, "exact")
        chosen = np.linspace(0, len(exact.front) - 1, _TIMES).round().astype(int)
        at_s = exact.front.time_s[chosen].tolist()
        found = {
            "front": search(TRAIN, track, energy="pantograph", at_s=at_s),
            "clean": search(TRAIN, track, energy="pantograph", at_s=at_s, clean=True),
            "refine": search(TRAIN, track, energy=_map(), at_s=at_s),
        }
        for method, one in found.items():
            if method != "front":
                yield from _same_optimum(f"{track.name}, {method}", one, found["front"])
            yield from _cheaper_than_grid(f"{track.name}, {method}", one, exact, at_s)
        grids = {"exact": exact, "best-first": _on_grid(track, "best-first")}
        yield from _above_certificate(track.name, found | grids)


def _on_grid(track: Track, method: str) -> SearchResult:
    return search(TRAIN, track, method=method, energy="pantograph", segment_m=_SEGMENT_M, speeds=_SPEEDS)


def _map() -> EnergyMap:
    """Power drawn over speed and demand; bilinear between these nodes, as the corner of both efforts is one."""
    speeds = np.array([0.0, _POWER_W / _FORCE_N, _TOP_MPS])
    power_w = np.minimum(_FORCE_N * speeds, _POWER_W)
    rows = zip(
        -TRAIN.regeneration_efficiency * power_w, 0.0 * power_w, power_w / TRAIN.traction_efficiency, strict=True
    )
    return EnergyMap(
        speed_mps=tuple(speeds.tolist()), demand=(-1.0, 0.0, 1.0), power_w=tuple(tuple(map(float, row)) for row in rows)
    )


def _same_optimum(name: str, found: SearchResult, front: SearchResult) -> Iterator[Case]:
    """Energies of the slower points, brought to the same time by the price of time."""
    prices = front.price_kwh_per_min
    assert prices is not None
    slower = slice(1, min(len(found.front), len(front.front)))
    shift_s = found.front.time_s[slower] - front.front.time_s[slower]
    energy_j = found.front.energy_j[slower] + prices[slower] * JOULE_PER_KWH / SECONDS_PER_MINUTE * shift_s
    total_j, expected_j = float(energy_j.sum()), float(front.front.energy_j[slower].sum())
    yield equal(PART, f"{name}: energies as by front, J", total_j, expected_j, 2.5)


def _cheaper_than_grid(name: str, found: SearchResult, exact: SearchResult, at_s: list[float]) -> Iterator[Case]:
    """Sum of the energies at the running times of paths of a grid."""
    grid_j = sum(exact.front.energy_j[np.searchsorted(exact.front.time_s, time_s)] for time_s in at_s)
    mine_j = sum(found.front.energy_j[np.searchsorted(found.front.time_s, time_s, "right") - 1] for time_s in at_s)
    yield at_most(PART, f"{name}: energies, no more than of exact, J", float(mine_j), float(grid_j), 9.0)


def _above_certificate(name: str, results: dict[str, SearchResult]) -> Iterator[Case]:
    """How far any point lies below the bound at its time, and whether its energy is all there."""
    certificate = results["front"].certify()
    for method, found in results.items():
        points = zip(found.front.time_s.tolist(), found.front.energy_j.tolist(), strict=True)
        below_j = max(certificate.at(time_s) - energy_j for time_s, energy_j in points)
        scale_j = found.fastest.energy_j
        yield at_most(PART, f"{name}, {method}: below the certificate, J", max(below_j, 0.0), 0.0, 9.0, scale_j)
        profiles = [found.fastest.profile, *(found.profile(index) for index in range(len(found.front)))]
        worst = max(balance_error(found.trip, profile) for profile in profiles)
        yield equal(BALANCE_PART, f"{name}, {method}: share missing, all profiles", worst, 0.0, 9.0, 1.0)
