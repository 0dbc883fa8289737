"""A direct-transcription NLP of the same problem for CasADi and IPOPT: the peer of the front method.

On a mesh of K cells with constant effort in each, unknowns are the speeds v_0 .. v_K and, per cell, the mean traction
F and braking effort B:

    minimise    Σ F·d
    subject to  ½·m_eff·(v1² − v0²) = d·(F − B − R̄(v0, v1) − G)         R̄: exact mean Davis resistance
                Σ 2·d/(v0 + v1) ≤ T                                      binding at the optimum
                F·(v0 + v1)/2 ≤ P, B likewise on its dynamic part        mean of P/v over a cell: exact
                0 ≤ F ≤ F_max, B ≥ 0, v ≤ limit, comfort limits on (v1² − v0²)/(2d)

(Wang, De Schutter, van den Boom & Ning 2013 and Scheepmaker, Goverde & Kroon 2017 describe such transcriptions.) All
unknowns are scaled to about 1, derivatives are exact and sparse, and the first start is the fastest run, slowed: what
a careful user of IPOPT would do.
"""

import math
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tgvdp.line.cells import Cells, cells_of
from tgvdp.methods.costate.stations import graded_stations
from tgvdp.model.effort import EffortCurve
from tgvdp.model.trip import Trip
from tgvdp.runs.profile import Profile

#: Interior speeds are at least this share of the top speed.
_SLOWEST = 2e-3
#: Tuned on three instances: monotone from μ = 1e-3 takes the fewest iterations cold, adaptive with small pushes warm.
_COLD = {"tol": 1e-6, "mu_strategy": "monotone", "mu_init": 1e-3}
_WARM = {
    "tol": 1e-6,
    "mu_strategy": "adaptive",
    "warm_start_init_point": "yes",
    "warm_start_bound_push": 1e-7,
    "warm_start_bound_frac": 1e-7,
    "warm_start_slack_bound_push": 1e-7,
    "warm_start_slack_bound_frac": 1e-7,
    "warm_start_mult_bound_push": 1e-7,
}


@dataclass(frozen=True)
class Solution:
    """One solved point: wall time of the solver in s, running time in s, energy in J, speeds (K + 1,) in m/s."""

    solve_s: float
    iterations: int
    converged: bool
    time_s: float
    energy_j: float
    speed_mps: NDArray[np.float64]
    start: dict[str, Any]


def caps_of(curve: EffortCurve) -> tuple[float, float]:
    """Force cap in N and power cap in W of a curve min(F, P/v), the only kind that this peer knows."""
    pieces = curve.pieces
    plain = not any((*piece[3:], piece.power_w and piece.c0_n) != (0.0, 0.0, 0.0, 0.0) for piece in pieces)
    if not plain or len(pieces) > 2 or pieces[0].power_w or (len(pieces) == 2 and not pieces[1].power_w):
        raise ValueError("the IPOPT peer models efforts min(F, P/v) only")
    return pieces[0].c0_n, pieces[1].power_w if len(pieces) == 2 else math.inf


class DirectTranscription:
    """The NLP of one trip on one mesh; build once, solve for many running times."""

    def __init__(self, trip: Trip, fastest: Profile, cell_m: float) -> None:
        self.trip = trip
        self.cells: Cells = cells_of(trip, graded_stations(trip, fastest, cell_m))
        x_m = fastest.position_m - fastest.position_m[0]
        self.fast_mps = np.sqrt(np.interp(self.cells.station_m, x_m, fastest.speed_mps**2))
        self.fastest_s = fastest.duration_s
        self._scale()
        started = time.perf_counter()
        self._build()
        self.build_s = time.perf_counter() - started

    def _scale(self) -> None:
        self.speed = float(self.fast_mps.max())
        self.force, self.power = caps_of(self.trip.train.traction)
        self.time = self.fastest_s
        self.energy = max(0.5 * self.trip.train.inertia_kg * self.speed**2, self.force * self.trip.distance_m * 0.01)

    def _build(self) -> None:
        import casadi as ca

        train, cells, count = self.trip.train, self.cells, len(self.cells.length_m)
        dynamic_n, brake_power = caps_of(train.braking)
        v, f, b = ca.SX.sym("v", count + 1), ca.SX.sym("f", count), ca.SX.sym("b", count)
        weights = ca.SX.sym("weights", 2)
        v0, v1 = self.speed * v[:-1], self.speed * v[1:]
        d = cells.length_m
        gain = 0.5 * (v1 * v1 - v0 * v0)
        resistance = (
            train.davis_a_n
            + train.davis_b_n_per_mps * (2.0 / 3.0) * (v0 * v0 + v0 * v1 + v1 * v1) / (v0 + v1)
            + 0.5 * cells.air * (v0 * v0 + v1 * v1)
            + cells.grade_n
        )
        balance = train.inertia_kg * gain / d - self.force * (f - b) + resistance
        total_s = ca.sum1(2.0 * d / (v0 + v1)) / self.time
        energy = ca.sum1(d * self.force * f) / self.energy
        rows: list[tuple[Any, float | NDArray[np.float64], float | NDArray[np.float64]]] = [
            (balance / self.force, 0.0, 0.0)
        ]
        if math.isfinite(self.power):
            rows.append((f * (v[:-1] + v[1:]), -math.inf, 2.0 * self.power / (self.force * self.speed)))
        if math.isfinite(brake_power):
            excess = (b * self.force - train.friction_brake_n) * (v0 + v1) / (self.force * self.speed)
            rows.append((excess, -math.inf, 2.0 * brake_power / (self.force * self.speed)))
        if math.isfinite(train.max_acceleration_mps2) or math.isfinite(train.max_deceleration_mps2):
            rows.append((gain / d, -train.max_deceleration_mps2, train.max_acceleration_mps2))
        rows.append((total_s, -math.inf, math.inf))
        self._lower_g = np.concatenate([np.broadcast_to(low, row.shape[0]) for row, low, _ in rows])
        self._upper_g = np.concatenate([np.broadcast_to(high, row.shape[0]) for row, _, high in rows])
        limit_w = np.minimum(np.append(cells.limit_w, math.inf), np.insert(cells.limit_w, 0, math.inf))
        upper_v, lower_v = np.sqrt(limit_w) / self.speed, np.full(count + 1, _SLOWEST)
        for end, speed_mps in ((0, self.trip.start_speed_mps), (-1, self.trip.end_speed_mps)):
            lower_v[end] = upper_v[end] = speed_mps / self.speed
        brake = (dynamic_n + train.friction_brake_n) / self.force
        self._lower_x = np.concatenate([lower_v, np.zeros(2 * count)])
        self._upper_x = np.concatenate([upper_v, np.ones(count), np.full(count, brake)])
        problem = {
            "x": ca.vertcat(v, f, b),
            "p": weights,
            "f": weights[0] * energy + weights[1] * total_s,
            "g": ca.vertcat(*(row for row, _, _ in rows)),
        }
        quiet = {"print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes", "record_time": True}
        self._solvers = {
            warm: ca.nlpsol("peer", "ipopt", problem, quiet | {f"ipopt.{key}": value for key, value in options.items()})
            for warm, options in ((False, _COLD), (True, _WARM))
        }

    def first_guess(self, target_s: float) -> dict[str, Any]:
        """The fastest run, slowed to the running time, with the efforts that it takes."""
        train, cells = self.trip.train, self.cells
        slow = np.clip(self.fast_mps * self.fastest_s / target_s, _SLOWEST * self.speed, None)
        slow[0], slow[-1] = self.trip.start_speed_mps, self.trip.end_speed_mps
        middle = 0.5 * (slow[:-1] + slow[1:])
        resistance = train.davis_a_n + middle * (train.davis_b_n_per_mps + middle * cells.air) + cells.grade_n
        effort = 0.5 * train.inertia_kg * np.diff(slow**2) / cells.length_m + resistance
        efforts = np.concatenate([np.maximum(effort, 0.0), np.maximum(-effort, 0.0)])
        return {"x0": np.concatenate([slow / self.speed, efforts / self.force])}

    def solve(self, target_s: float, start: dict[str, Any] | None = None) -> Solution:
        """Least energy at a running time in s; from the solution before, if its ``start`` is given."""
        return self._solve((1.0, 0.0), target_s / self.time, start, self.first_guess(target_s))

    def fastest(self) -> Solution:
        """Least running time on this mesh."""
        return self._solve((0.0, 1.0), math.inf, None, self.first_guess(self.fastest_s))

    def _solve(
        self, weights: tuple[float, float], most: float, start: dict[str, Any] | None, guess: dict[str, Any]
    ) -> Solution:
        upper_g = self._upper_g.copy()
        upper_g[-1] = most
        solver = self._solvers[start is not None]
        started = time.perf_counter()
        found = solver(
            lbx=self._lower_x, ubx=self._upper_x, lbg=self._lower_g, ubg=upper_g, p=weights, **(start or guess)
        )
        solve_s = time.perf_counter() - started
        stats = solver.stats()
        x = np.asarray(found["x"]).ravel()
        count = len(self.cells.length_m)
        speed_mps = self.speed * x[: count + 1]
        return Solution(
            solve_s=solve_s,
            iterations=int(stats["iter_count"]),
            converged=bool(stats["success"]),
            time_s=float(np.sum(2.0 * self.cells.length_m / (speed_mps[:-1] + speed_mps[1:]))),
            energy_j=float(self.force * np.dot(self.cells.length_m, x[count + 1 : 2 * count + 1])),
            speed_mps=speed_mps,
            start={"x0": found["x"], "lam_x0": found["lam_x"], "lam_g0": found["lam_g"]},
        )
