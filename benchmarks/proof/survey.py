"""One trip of the survey: what its front claims, what is proven, and what a polish still finds."""

import time
from typing import Any

import numpy as np

import tgvdp
from benchmarks.proof.polish import Polish
from benchmarks.proof.trips import ProofTrip
from tgvdp.referee.replay import replay
from tgvdp.runs.profile import Profile, profile_of
from tgvdp.units import JOULE_PER_KWH, SECONDS_PER_MINUTE

#: Points of each front, and every which one is polished, from one on that changes with the seed.
_POINTS, _EVERY = 12, 4
#: Energies are compared with themselves, or with this share of the kinetic energy at top speed if that is more.
_KINETIC_SHARE = 0.1
#: Seconds that a search may take, which is far more than any should.
_TIME_LIMIT_S = 60.0

#: What is measured, empty where there is no answer. Gaps: of the fastest run, and the largest from the third point on.
COLUMNS = (
    "seed", "kind", "feature", "km", "error", "points", "missed", "dearer_pct", "fastest_gap_pct", "gap_pct",
    "below_bound_pct", "phases", "short_phases", "replay_ms", "replay_energy_pct", "not_ok", "search_s", "certify_s",
)  # fmt: skip


def surveyed(trip: ProofTrip) -> dict[str, Any]:
    """Search, certify, replay and polish one trip; a row of `COLUMNS`."""
    row: dict[str, Any] = dict.fromkeys(COLUMNS)
    row |= {"seed": trip.seed, "kind": trip.kind, "feature": trip.feature, "km": trip.track.length_m / 1e3}
    started = time.perf_counter()
    try:
        result = tgvdp.search(trip.train, trip.track, points=_POINTS, time_limit_s=_TIME_LIMIT_S, **trip.options)
        searched = time.perf_counter()
        certificate = result.certify()
        certified = time.perf_counter()
        verdicts = result.verify()
    except Exception as error:  # whatever it is, the survey counts it and goes on
        return row | {"error": f"{type(error).__name__}: {error}"}
    gaps_pct = np.nan_to_num(certificate.gap_pct, nan=np.inf)
    profiles = [result.profile(index) for index in range(len(result.front))]
    phases_s = [_phases_s(profile) for profile in profiles[1:]]
    size_j = np.array([_size_j(result, profiles[0], profile) for profile in profiles])
    above_pct = 100.0 * np.nan_to_num(result.front.energy_j - certificate.lower_bound_j, nan=np.inf) / size_j
    gains_pct = {index: gain_pct(result, profiles, index) for index in range(1 + trip.seed % 3, len(profiles), _EVERY)}
    return row | {
        "points": len(profiles),
        "missed": sum("jump" in text for text in result.warnings),
        "dearer_pct": max(gains_pct.values(), default=0.0),
        "fastest_gap_pct": float(gaps_pct[0]),
        "gap_pct": float(np.max(gaps_pct[2:], initial=0.0)),
        "below_bound_pct": max([0.0, *(gain - above_pct[index] for index, gain in gains_pct.items())]),
        "phases": float(np.median([len(one) for one in phases_s] or [0])),
        "short_phases": float(np.mean([np.sum(one < 1.0) for one in phases_s] or [0])),
        "replay_ms": 10.0 * max(abs(v.time_error_pct) * p.duration_s for v, p in zip(verdicts, profiles, strict=True)),
        "replay_energy_pct": max(abs(verdict.energy_error_pct) for verdict in verdicts),
        "not_ok": sum(not verdict.ok for verdict in verdicts),
        "search_s": searched - started,
        "certify_s": certified - searched,
    }  # fmt: skip


def _phases_s(profile: Profile) -> np.ndarray:
    """Durations of the phases of one regime each, s."""
    ends = np.concatenate(([0], np.flatnonzero(np.diff(profile.regime[:-1])) + 1, [len(profile.regime) - 1]))
    return np.diff(profile.time_s[ends])


def gain_pct(result: tgvdp.SearchResult, profiles: list[Profile], index: int) -> float:
    """How much less energy a run near a point needs that the referee passes, percent; 0 if none is found."""
    profile = profiles[index]
    prices = result.price_kwh_per_min
    price = float(prices[index]) * JOULE_PER_KWH / SECONDS_PER_MINUTE if prices is not None else 0.0
    gain_j, x_m, w = Polish(result.trip, profile).polished(price)
    found = profile_of(result.trip, x_m, w)
    if gain_j == 0.0 or not replay(result.trip, found).ok:
        return 0.0
    saved_j = max(0.0, min(gain_j, profile.total_energy_j - found.total_energy_j))  # by either way of measuring
    return 100.0 * saved_j / _size_j(result, profiles[0], profile)


def _size_j(result: tgvdp.SearchResult, fastest: Profile, profile: Profile) -> float:
    """What percents of the energy of a run are percents of, J."""
    kinetic_j = 0.5 * result.trip.train.inertia_kg * float(np.max(fastest.speed_mps)) ** 2
    return max(abs(profile.total_energy_j), _KINETIC_SHARE * kinetic_j)
