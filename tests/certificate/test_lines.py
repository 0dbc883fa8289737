"""Which lines a certificate is made of: refinement only raises it, and finds the multipliers of its points."""

import math

import numpy as np
import pytest

import tgvdp
from tests.helpers.metro_case import TRAIN as METRO
from tgvdp import Track
from tgvdp.certificate import lines
from tgvdp.certificate.line import BoundingProblem
from tgvdp.certificate.lines import Line, _best_multiplier, _multipliers_at
from tgvdp.methods.costate.mesh import Mesh

HILLS = Track(
    length_m=2400.0,
    speed_limits=((0.0, 22.0), (700.0, 18.0), (1200.0, 23.0), (2200.0, 17.0)),
    gradients=((0.0, 3.0), (400.0, -24.0), (900.0, -3.0), (1300.0, 24.0), (1700.0, 10.0), (2100.0, 0.0)),
)


@pytest.fixture(scope="module")
def hills():
    return tgvdp.search(METRO, HILLS, points=80)


@pytest.mark.parametrize("energy", ["wheel", "pantograph"])
def test_no_run_of_a_finer_mesh_lies_below_and_some_lie_next_to_the_bound(energy):
    result = tgvdp.search(METRO, HILLS, points=20, energy=energy)
    certificate = result.certify()
    auxiliary_w = METRO.auxiliary_power_w if energy == "pantograph" else 0.0
    mesh, counters = Mesh.of(result.trip, result.fastest.profile, 12.0), {"extremals": 0, "runs": 0, "costates": 0}
    above = []
    for multiplier_j_per_s in result.price_kwh_per_min[2:] * 3.6e6 / 60.0:
        extremal = mesh.extremal(multiplier_j_per_s + auxiliary_w, counters)
        energy_j = extremal.energy_j + auxiliary_w * extremal.time_s
        above.append(energy_j / certificate.at(extremal.time_s) - 1.0)
    assert min(above) > -1e-5
    assert np.median(above) < 1e-3


def test_refinement_only_raises(hills, monkeypatch):
    monkeypatch.setattr(lines, "_MOST_ASCENTS", 0)
    refined = hills.certify()
    monkeypatch.setattr(lines, "_MOST_CELLS", 0)
    plain = hills.certify()
    assert len(refined.line_j) > len(plain.line_j)
    assert (refined.lower_bound_j >= plain.lower_bound_j).all()
    np.testing.assert_array_equal(refined.line_j[: len(plain.line_j)], plain.line_j)
    assert (plain.gap_pct - refined.gap_pct).max() > 0.02
    assert refined.gap_pct.min() > -0.01


def test_time_that_ends_during_refinement_takes_no_bound_away(hills, monkeypatch):
    monkeypatch.setattr(lines, "_MOST_CELLS", 0)
    plain = hills.certify()
    monkeypatch.undo()
    looks = iter([False] * (len(plain.line_j) + 1) + [True] * 1000)
    monkeypatch.setattr(tgvdp.methods.budget.Clock, "expired", property(lambda clock: next(looks)))
    part = hills.certify()
    assert not part.complete
    assert np.isfinite(part.gap_pct).all()


@pytest.mark.parametrize("auxiliary_w", [0.0, 400e3])
def test_gaps_at_the_pantograph(auxiliary_w):
    """The power of auxiliaries is part of the multiplier of every extremal."""
    train = tgvdp.Train(**{**_fields(METRO), "auxiliary_power_w": auxiliary_w})
    track = Track(length_m=6000.0, speed_limits=((0.0, 25.0), (2500.0, 20.0)))
    certificate = tgvdp.search(train, track, points=12, energy="pantograph").certify()
    assert certificate.gap_pct.min() > -0.01
    assert np.median(certificate.gap_pct) < 0.05
    assert certificate.gap_pct.max() < 0.3


def _fields(train):
    return {name: getattr(train, name) for name in train.__dataclass_fields__}


def test_costates_of_optimal_runs_jump_downwards_only(hills):
    problem = BoundingProblem(hills.trip)
    for index in range(1, 40, 3):
        profile = hills.profile(index)
        multiplier_j_per_s = float(hills.price_kwh_per_min[index]) * 3.6e6 / 60.0
        ledger = problem.ledger(profile.position_m, profile.speed_mps**2, multiplier_j_per_s)
        assert (ledger.left[2:-1] - ledger.right[1:-2]).max() < 1e-9


@pytest.mark.nojit
def test_multipliers_between_lines():
    multiplier = np.array([1.0, 4.0, 2.0, 8.0])
    line_s = np.array([60.0, 40.0, 50.0, 30.0])
    found = _multipliers_at(np.array([25.0, 30.0, 45.0, 60.0, 70.0]), multiplier, line_s)
    np.testing.assert_allclose(found, [8.0, 8.0, math.sqrt(8.0), 1.0, 1.0])
    # Where the running time jumps: the multiplier that belongs to both its sides.
    found = _multipliers_at(np.array([50.0]), np.array([2.0, 1.99]), np.array([40.0, 60.0]))
    assert 1.99 < found[0] < 2.0


@pytest.mark.nojit
def test_best_multiplier_of_the_fastest_run():
    # Lines of multiplier λ that are 90/λ + λ/10 + 1 too low: best at λ = 30.
    def line(multiplier):
        return Line(
            multiplier,
            500.0 + 7.0 * multiplier - 90.0 / multiplier - multiplier / 10.0 - 1.0,
            7.0,
            500.0 + 7.0 * multiplier,
        )

    assert _best_multiplier([line(multiplier) for multiplier in (2.5, 10.0, 40.0, 160.0)]) == pytest.approx(30.0)
    assert _best_multiplier([line(10.0), line(40.0)]) == 40.0
    rising = [
        Line(multiplier, 500.0 + 6.0 * multiplier, 7.0, 500.0 + 7.0 * multiplier) for multiplier in (1.0, 4.0, 16.0)
    ]
    assert _best_multiplier(rising) == 1.0
