"""The outer bound of the fastest run: above every run, and above the fastest one by next to nothing."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from tgvdp import EffortCurve, Track, Train, Trip
from tgvdp.certificate.efforts import Load
from tgvdp.certificate.line import BoundingProblem
from tgvdp.certificate.speed_bound import Caps, _mean_gain, lower_caps
from tgvdp.physics.cell import Rows
from tgvdp.runs.fastest import fastest_run

GEARS = EffortCurve.from_points([(0, 90e3), (8, 40e3), (14, 32e3), (14, 26e3), (20, 23e3), (20.3, 19e3), (40, 10e3)])
TRAINS = {
    "power": Train(
        mass_kg=200e3, traction=EffortCurve.from_caps(300e3, 2.5e6), friction_brake_n=200e3, davis_a_n=4000.0,
        davis_b_n_per_mps=60.0, davis_c_n_per_mps2=9.0,
    ),
    "gears": Train(
        mass_kg=70e3, rotating_mass_factor=1.08, traction=GEARS, friction_brake_n=60e3, davis_a_n=1900.0,
        davis_c_n_per_mps2=4.0, max_acceleration_mps2=0.9,
    ),
}  # fmt: skip
HILLS = Track(
    length_m=6000.0,
    speed_limits=((0.0, 36.0),),
    gradients=((0.0, 3.0), (700.0, -12.0), (1500.0, 0.0), (2900.0, 25.0), (4500.0, -4.0)),
)


def _trip(train, **speeds):
    return Trip(train=train, track=HILLS, origin_m=0.0, destination_m=HILLS.length_m, **speeds)


def _driven_w(trip, cells, start_w):
    """Squared speed at the ends of the cells at full effort: the equation of motion, by an adaptive method."""
    train, w, found = trip.train, start_w, [start_w]
    for length_m, grade_n in zip(cells.length_m, cells.grade_n, strict=True):

        def slope(_, y, grade_n=grade_n):
            v = math.sqrt(max(y[0], 0.0))
            load = train.davis_a_n + grade_n + v * (train.davis_b_n_per_mps + v * train.davis_c_n_per_mps2)
            rise = (train.traction.effort_n(v) - load) / train.inertia_kg
            return [2.0 * min(rise, train.max_acceleration_mps2)]

        w = min(float(solve_ivp(slope, (0.0, length_m), [w], rtol=1e-9, max_step=0.5).y[0, -1]), 36.0**2)
        found.append(w)
    return np.array(found)


@pytest.mark.parametrize("name", TRAINS)
def test_speed_bound_is_above_the_fastest_run_and_next_to_it(name):
    trip = _trip(TRAINS[name], start_speed_mps=2.0)
    problem = BoundingProblem(trip)
    xs, ws = problem._speed_bounds[0]
    driven = _driven_w(trip, problem.cells, 4.0)
    above = np.interp(problem.cells.station_m, xs, ws) / driven - 1.0
    assert (above > -1e-9).all()
    assert above[:4].max() < 2e-6  # up to where a climb slows the train down
    assert above.max() < 5e-4


@pytest.mark.parametrize("name", TRAINS)
def test_no_row_of_the_fastest_run_is_above_the_speed_bounds(name):
    trip = _trip(TRAINS[name])
    profile = fastest_run(trip)
    for (xs, ws), x_m in zip(
        BoundingProblem(trip)._speed_bounds, (profile.position_m, 6000.0 - profile.position_m), strict=True
    ):
        assert (profile.speed_mps**2 <= np.interp(x_m, xs, ws) * (1.0 + 2e-5)).all()


@pytest.mark.nojit
@pytest.mark.parametrize("forward", [True, False])
def test_mean_gain_against_quadrature(forward):
    piece = np.array([[2.0, 30.0, -1.0, 0.2, -0.03, 0.001]])
    for u, v in ((2.0, 2.5), (3.0, 9.0), (10.0, 10.01)):

        def gain(w):
            x = math.sqrt(w)
            effort = 30.0 / x - 1.0 + 0.2 * x - 0.03 * x**2 + 0.001 * x**3
            load = 0.1 + 0.02 * x + 0.003 * x**2
            return effort - load if forward else effort + load

        expected = quad(gain, u * u, v * v, epsrel=1e-12)[0] / (v * v - u * u)
        assert _mean_gain(piece, 0, forward, Load(0.1, 0.02, 0.003), u, v) == pytest.approx(expected, rel=1e-10)


@pytest.mark.nojit
@pytest.mark.parametrize("seed", range(10))
def test_caps_of_cells_are_above_the_speed_bounds_everywhere(seed):
    rng = np.random.default_rng(seed)
    bounds = []
    for _ in range(2):
        xs = np.concatenate(([0.0], np.sort(rng.uniform(0.0, 10.0, 25)), [10.0]))
        bounds.append(Rows(xs, np.cumsum(rng.uniform(-0.3, 1.0, len(xs))).clip(0.0)))
    node = np.concatenate(([0.0], np.sort(rng.uniform(0.0, 10.0, 8)), [10.0]))
    cap, node_cap, rise = caps = Caps(np.full(9, 6.0), np.full(10, 6.0), np.empty((9, 2)))
    lower_caps(10.0, node, *bounds, caps)
    for k in range(9):
        x = np.linspace(node[k], node[k + 1], 200)
        ahead, back = np.interp(x, *bounds[0]), np.interp(10.0 - x, *bounds[1])
        below = np.minimum(np.minimum(ahead, back), 6.0)
        assert (below <= cap[k] + 1e-12).all()
        assert below[0] <= node_cap[k] + 1e-12 and below[-1] <= node_cap[k + 1] + 1e-12
        line = np.interp(x, node[k : k + 2], rise[k]) + 1e-12
        assert (ahead <= line).all() or (back <= line).all()
