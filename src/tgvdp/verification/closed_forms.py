"""Runs that have a formula: constant forces, drag that grows with v², and the optimum between two stops.

The optimum on a level line is that of Howlett & Pudney (Energy-Efficient Train Control, 1995, ch. 3): full effort to
the speed V with V²·R'(V) = λ, holding, coasting to U = λ/(R(V) + λ/V), full braking; with R = c·v² and constant efforts
all its integrals are elementary.
"""

import math
from collections.abc import Callable, Iterator

import numpy as np

from tgvdp.api.run import search
from tgvdp.api.trip import energy_model
from tgvdp.model.effort import EffortCurve
from tgvdp.model.track import Gradient, SpeedLimit, Track
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip
from tgvdp.runs.fastest import fastest_run
from tgvdp.verification.case import Case, equal

PART = "closed forms"
#: A train of 400 t with 200 kN both ways, and a drag of 12 N/(m/s)².
_MASS_KG, _PULL_N, _BRAKE_N, _DRAG = 4e5, 2e5, 2e5, 12.0
_BISECTIONS = 200
_NO_LIMIT_MPS = 1e3


def cases() -> Iterator[Case]:
    """All of them."""
    yield from _constant_forces()
    yield from _pantograph()
    yield from _steady_slope()
    yield from _drag()
    yield from _least_energy_without_resistance()
    yield from _least_energy_with_drag()


def _line(length_m: float, limit_mps: float = _NO_LIMIT_MPS, gradient_permil: float = 0.0) -> Track:
    """A uniform line."""
    return Track(
        length_m=length_m, speed_limits=(SpeedLimit(0.0, limit_mps),), gradients=(Gradient(0.0, gradient_permil),)
    )


def _trip(train: Train, track: Track, energy: str = "wheel") -> Trip:
    return Trip(train=train, track=track, origin_m=0.0, destination_m=track.length_m, energy=energy_model(energy))


def _constant_forces() -> Iterator[Case]:
    """1 m/s² up to 6 m/s, held, 2 m/s² down; on 12 m the limit is not reached: v² = 2·L·ab/(a + b)."""
    train = Train(mass_kg=1.0, traction=EffortCurve.from_caps(1.0), friction_brake_n=2.0)
    run = fastest_run(_trip(train, _line(100.0, 6.0)))
    yield equal(PART, "constant forces, with a limit: fastest time, s", run.duration_s, 9.0 + 73.0 / 6.0, 11.0)
    yield equal(PART, "constant forces, with a limit: energy, J", run.total_energy_j, 18.0, 11.0)
    run = fastest_run(_trip(train, _line(12.0)))
    yield equal(PART, "constant forces, no limit: fastest time, s", run.duration_s, 6.0, 11.0)
    yield equal(PART, "constant forces, no limit: energy, J", run.total_energy_j, 8.0, 11.0)


def _pantograph() -> Iterator[Case]:
    """½mv²/η drawn, r·½mv² returned by the dynamic brake, auxiliaries all the time."""
    train = Train(
        mass_kg=1.0, traction=EffortCurve.from_caps(1.0), braking=EffortCurve.from_caps(2.0), traction_efficiency=0.8,
        regeneration_efficiency=0.5, auxiliary_power_w=0.25,
    )  # fmt: skip
    run = fastest_run(_trip(train, _line(100.0, 6.0), "pantograph"))
    drawn_j = 18.0 / 0.8 - 0.5 * 18.0 + 0.25 * (9.0 + 73.0 / 6.0)
    yield equal(PART, "constant forces, at the pantograph: energy, J", run.total_energy_j, drawn_j, 11.0)


def _steady_slope() -> Iterator[Case]:
    """A climb takes m·g·i off both forces: a = F/m − g·i, b = B/m + g·i."""
    train = Train(mass_kg=_MASS_KG, traction=EffortCurve.from_caps(_PULL_N), friction_brake_n=_BRAKE_N)
    trip = _trip(train, _line(5e3, gradient_permil=20.0))
    fall = trip.convention.gravity_mps2 * 0.02
    up, down = _PULL_N / _MASS_KG - fall, _BRAKE_N / _MASS_KG + fall
    top = math.sqrt(2.0 * 5e3 * up * down / (up + down))
    run = fastest_run(trip)
    yield equal(PART, "steady climb: fastest time, s", run.duration_s, top / up + top / down, 11.0)
    yield equal(PART, "steady climb: energy, J", run.total_energy_j, _PULL_N * top**2 / (2.0 * up), 11.0)


def _drag() -> Iterator[Case]:
    """m·v' = F − c·v²: w = F/c·(1 − exp(−2cx/m)), t = m/√(Fc)·artanh(v·√(c/F)); braking likewise with arctan."""
    train = Train(
        mass_kg=_MASS_KG, traction=EffortCurve.from_caps(_PULL_N), friction_brake_n=_BRAKE_N, davis_c_n_per_mps2=_DRAG
    )
    length_m = 2e4
    top = _bisected(lambda v: _pull(v)[0] + _brake(v)[0] - length_m, 0.0, math.sqrt(_PULL_N / _DRAG) * (1.0 - 1e-12))
    run = fastest_run(_trip(train, _line(length_m)))
    yield equal(PART, "quadratic drag: fastest time, s", run.duration_s, _pull(top)[1] + _brake(top)[1], 6.0)
    yield equal(PART, "quadratic drag: energy, J", run.total_energy_j, _PULL_N * _pull(top)[0], 6.0)


def _least_energy_without_resistance() -> Iterator[Case]:
    """v²/2 in and out with 1 m/s² both ways: T = 2v + (L − v²)/v, E = v²/2."""
    train = Train(mass_kg=1.0, traction=EffortCurve.from_caps(1.0), friction_brake_n=1.0)
    shares = (1.1, 1.5, 2.0)
    found = search(train, _line(1000.0), at_margin=[share - 1.0 for share in shares])
    for seconds, joules in zip(found.front.time_s[-3:], found.front.energy_j[-3:], strict=True):
        v = seconds / 2.0 - math.sqrt(seconds**2 / 4.0 - 1000.0)
        margin_pct = 100.0 * (seconds / found.fastest.time_s - 1.0)
        name = f"no resistance, {margin_pct:.0f} % later: least energy, J"
        yield equal(PART, name, joules, v * v / 2.0, 3.0)


def _least_energy_with_drag() -> Iterator[Case]:
    """Full effort, holding, coasting, full braking, at three multipliers; E + λT is what is least."""
    train = Train(
        mass_kg=_MASS_KG, traction=EffortCurve.from_caps(_PULL_N), friction_brake_n=_BRAKE_N, davis_c_n_per_mps2=_DRAG
    )
    length_m = 6e4
    trip_line = _line(length_m)
    for held_mps in (60.0, 50.0, 40.0):
        multiplier = 2.0 * _DRAG * held_mps**3  # V²·R'(V)
        low = multiplier / (_DRAG * held_mps**2 + multiplier / held_mps)
        coast_m, coast_s = _MASS_KG / _DRAG * math.log(held_mps / low), _MASS_KG / _DRAG * (1.0 / low - 1.0 / held_mps)
        hold_m = length_m - _pull(held_mps)[0] - coast_m - _brake(low)[0]
        seconds = _pull(held_mps)[1] + hold_m / held_mps + coast_s + _brake(low)[1]
        joules = _PULL_N * _pull(held_mps)[0] + _DRAG * held_mps**2 * hold_m
        found = search(train, trip_line, at_s=[seconds])
        at = int(np.argmin(np.abs(found.front.time_s - seconds)))
        cost_j = float(found.front.energy_j[at] + multiplier * (found.front.time_s[at] - seconds))
        yield equal(PART, f"quadratic drag, held at {held_mps:g} m/s: least energy, J", cost_j, joules, 4.0)


def _pull(v: float) -> tuple[float, float]:
    """Distance and time of full effort from standstill to v."""
    share = v * math.sqrt(_DRAG / _PULL_N)
    return (
        -_MASS_KG / (2.0 * _DRAG) * math.log1p(-share * share),
        _MASS_KG / math.sqrt(_PULL_N * _DRAG) * math.atanh(share),
    )


def _brake(v: float) -> tuple[float, float]:
    """Distance and time of full braking from v to standstill."""
    share = v * math.sqrt(_DRAG / _BRAKE_N)
    return (
        _MASS_KG / (2.0 * _DRAG) * math.log1p(share * share),
        _MASS_KG / math.sqrt(_BRAKE_N * _DRAG) * math.atan(share),
    )


def _bisected(function: Callable[[float], float], low: float, high: float) -> float:
    """Root of an increasing function."""
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if function(middle) < 0.0 else (low, middle)
    return 0.5 * (low + high)
