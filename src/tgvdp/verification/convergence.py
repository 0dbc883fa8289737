"""The order in which errors fall when rows are halved: of the arcs that runs are made of, and of the referee.

The train pulls with a constant effort against a drag c·v², not from standstill: w = F/c − (F/c − w₀)·exp(−2cx/m). Rows
have exact positions and speeds. What arcs say of time and work between them is of second order, as v² is taken as
linear. The referee's scheme is of fourth order in speed, so that the error of one row is of fifth; its time is of
second.
"""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tgvdp.model.effort import EffortCurve
from tgvdp.model.track import POWERED, SpeedLimit, Track
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip
from tgvdp.physics.energy import energy_tables
from tgvdp.physics.forces import kernel_train
from tgvdp.referee.drive import replay_rows
from tgvdp.referee.line import see_line
from tgvdp.runs.profile import profile_of
from tgvdp.verification.case import Case, equal

PART = "order of convergence"
_MASS_KG, _PULL_N, _DRAG = 1e5, 1e5, 20.0
_START_MPS, _LENGTH_M = 10.0, 1000.0
_ROWS = (16, 32)
#: More sub-steps than these rows have.
_ALL = 1_000_000


def cases() -> Iterator[Case]:
    """Orders of time and work by arcs, of speed and time by the referee."""
    coarse, fine = (_errors(count) for count in _ROWS)
    expected = {"arc: time": 2.0, "arc: work": 2.0, "referee: speed after a row": 5.0, "referee: time": 2.0}
    for name, order in expected.items():
        yield equal(PART, f"{name}, order", math.log2(coarse[name] / fine[name]), order, 1.0)


def _errors(count: int) -> dict[str, float]:
    """Errors of what arcs and the referee say of so many equal rows."""
    x_m = np.linspace(0.0, _LENGTH_M, count + 1)
    w = _exact_w(x_m)
    exact_s = np.array([_exact_s(float(v)) for v in np.sqrt(w)]) - _exact_s(_START_MPS)
    train = Train(
        mass_kg=_MASS_KG, traction=EffortCurve.from_caps(_PULL_N), friction_brake_n=_PULL_N, davis_c_n_per_mps2=_DRAG
    )
    track = Track(length_m=_LENGTH_M, speed_limits=(SpeedLimit(0.0, 1e3),))
    trip = Trip(
        train=train, track=track, origin_m=0.0, destination_m=_LENGTH_M, start_speed_mps=_START_MPS,
        end_speed_mps=math.sqrt(w[-1]),
    )  # fmt: skip
    arcs = profile_of(trip, x_m, w)
    time_s, energy_j = np.empty(count + 1), np.empty(count + 1)
    _, _, speed_error = replay_rows(
        kernel_train(train), energy_tables(train, trip.energy), see_line(trip), np.full(count, POWERED, np.int8),
        x_m, np.sqrt(w), np.full(count + 1, _PULL_N), time_s, energy_j, 0, _ALL,
    )  # fmt: skip
    return {
        "arc: time": abs(arcs.duration_s - exact_s[-1]),
        "arc: work": abs(arcs.total_energy_j - _PULL_N * _LENGTH_M),
        "referee: speed after a row": speed_error,
        "referee: time": abs(time_s[-1] - exact_s[-1]),
    }


def _exact_w(x_m: NDArray[np.float64]) -> NDArray[np.float64]:
    balance = _PULL_N / _DRAG
    return np.asarray(balance - (balance - _START_MPS**2) * np.exp(-2.0 * _DRAG * x_m / _MASS_KG))


def _exact_s(v: float) -> float:
    """Time from standstill to v."""
    return _MASS_KG / math.sqrt(_PULL_N * _DRAG) * math.atanh(v * math.sqrt(_DRAG / _PULL_N))
