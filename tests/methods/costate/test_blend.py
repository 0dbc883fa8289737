"""Policies between two extremals, and what these foretell of the runs between them."""

import math

import numpy as np
import pytest

from tests.helpers.fronts import check_front, feasible_trip
from tests.helpers.trips import commuter, trip_on
from tgvdp.methods.costate.blend import Blend, fill_blend
from tgvdp.methods.costate.extremal import Extremal, between, foretells
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.runs.fastest import fastest_run


def counters():
    return {"extremals": 0, "runs": 0, "costates": 0}


def blend_of(known, second, top_w):
    """Blend of the policies of one of some extremals and the one before it."""
    policies = np.array([one.switch for one in known])
    blend = Blend(*np.empty((3, *policies[0].shape)))
    fill_blend(np.array([one.outcome for one in known]), policies, second, top_w, blend)
    return blend


@pytest.fixture(scope="module")
def mesh():
    trip = trip_on([(0, 22)], [(0, 0), (900, 4), (2500, -3)], length_m=6000.0, train=commuter())
    return Mesh.of(trip, fastest_run(trip), 4.0)


@pytest.mark.parametrize("level", [0.5, 1.0, 2.0])
def test_a_blend_of_four_extremals_is_far_nearer_to_the_one_between_than_a_straight_one(mesh, level):
    known = [mesh.extremal(level * ratio * mesh.usual_multiplier, counters()) for ratio in (1.5, 1.2, 0.96, 0.77)]
    first, second = known[1:3]
    middle = mesh.extremal(math.sqrt(first.multiplier * second.multiplier), counters())
    bent = blend_of(known, 2, mesh.fast)
    straight = Blend(first.switch, second.switch, np.zeros_like(first.switch))
    lost_j = []
    for blend in (bent, straight):
        _, time_s, energy_j = mesh.drive(blend.at(0.5), counters())
        lost_j.append(energy_j + middle.multiplier * time_s - middle.cost_j(middle.multiplier))
    assert abs(lost_j[0]) <= 3e-5 * middle.energy_j
    assert abs(lost_j[0]) <= 0.3 * lost_j[1]


def test_a_blend_stays_between_its_two_policies_but_beyond_the_envelope():
    top_w = np.array([100.0, 100.0])
    speeds = [(100.0, 100.0), (100.0, 96.0), (90.0, 70.0), (70.0, 69.0)]
    known = [
        Extremal(math.exp(-k), np.repeat(np.array(w)[:, None], 4, axis=1), float(k), 0.0) for k, w in enumerate(speeds)
    ]
    blend = blend_of(known, 2, top_w)
    assert blend.first[0, 0] == pytest.approx(110.0)  # 70, 90, and so on
    assert blend.first[1, 0] == 96.0
    for share in (0.1, 0.5, 0.9):
        assert 70.0 <= blend.at(share)[1, 0] <= 96.0
    assert (blend.at(1.0) == known[2].switch).all()


def test_what_is_off_the_envelope_by_rounding_is_on_it():
    """Neighbouring cells must not be blended in two ways: runs sawed from one to the other."""
    exact, rounded = 100.0, 100.0 - 1e-8
    known = [
        Extremal(math.exp(-k), np.repeat(np.array(w)[:, None], 4, axis=1), float(k), 0.0)
        for k, w in enumerate(
            [(exact, rounded, exact), (exact, exact, rounded), (70.0, 70.0, 70.0), (69.0, 69.0, 69.0)]
        )
    ]
    for share in (0.2, 0.5, 0.8):
        blended = blend_of(known, 2, np.full(3, exact)).at(share)
        assert blended == pytest.approx(np.full((3, 4), blended[0, 0]), abs=1e-6)


def test_next_to_the_fastest_run_energy_is_foretold_where_it_falls_with_the_root_of_time():
    def optimum(multiplier):
        late_s = (0.5 / multiplier) ** 2  # E = 10 − √(T − 100)
        return Extremal(multiplier, np.empty((0, 4)), 100.0 + late_s, 10.0 - math.sqrt(late_s))

    first, second = optimum(1.0), optimum(0.6)
    for share in (0.0, 0.3, 0.7, 1.0):
        here = optimum(0.6**share)
        foretold = between(first, second, here.time_s)
        assert foretold.energy_j == pytest.approx(here.energy_j, rel=1e-5)
        assert foretold.multiplier == pytest.approx(here.multiplier, rel=5e-3)
        assert foretold.share == pytest.approx(share, abs=1e-2)


def test_coasting_downhill_ends_at_the_envelope():
    """A blend aimed above a limit that coasting passes within a cell: by 0.06 m/s, then braked in one row."""
    check_front(feasible_trip(109739), 0.001, 2)


@pytest.mark.parametrize("ratio", [0.99, 0.6, 0.05])
@pytest.mark.parametrize(("bend", "rises"), [(0.0, True), (0.95, True), (-0.95, True), (1.05, False), (-1.05, False)])
def test_running_times_that_would_fall_on_the_way_are_told_from_the_energy(ratio, bend, rises):
    """Against the sum of λ over a time that is quadratic in ln λ, and falls somewhere if it bends by more than 1."""
    share = np.linspace(0.0, 1.0, 20_001)
    time_s = 600.0 + 40.0 * (share + bend * share * (1.0 - share))
    saved_j = np.trapezoid(1e6 * ratio**share, time_s)
    first = Extremal(1e6, np.empty(0), 600.0, 3e8)
    assert foretells(first, Extremal(ratio * 1e6, np.empty(0), 640.0, 3e8 - saved_j)) == rises
