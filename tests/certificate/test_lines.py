"""Which lines a certificate is made of: refinement only raises it, and finds the multipliers of its points."""

from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tests.helpers.brake_case import CUTS_OUT, LEVEL, metro
from tests.helpers.clocks import expire_after_lines
from tests.helpers.metro_case import TRAIN as METRO
from tgvdp import Track
from tgvdp.certificate import line_maker, lines
from tgvdp.certificate.hull import lower_hull
from tgvdp.certificate.line import BoundingProblem
from tgvdp.cores import on_one_core
from tgvdp.methods.budget import Clock
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
    refined = hills.certify()
    monkeypatch.setattr(lines.LinesUnder, "refine", lambda under, clock: None)
    plain = hills.certify()
    assert len(refined.line_j) > len(plain.line_j)
    assert (refined.lower_bound_j >= plain.lower_bound_j).all()
    assert (refined.line_j[: len(plain.line_j)] >= plain.line_j).all()
    assert (plain.gap_pct - refined.gap_pct).max() > 0.02
    assert refined.gap_pct.min() > -0.01


def test_time_that_ends_during_refinement_takes_no_bound_away(hills, monkeypatch):
    monkeypatch.setattr(lines, "_MOST_IN_VAIN", 0)  # no ascents, which are no lines of their own
    with monkeypatch.context() as patch:
        patch.setattr(lines.LinesUnder, "refine", lambda under, clock: None)
        first = len(hills.certify().line_j) - 1  # one is level
    expire_after_lines(monkeypatch, first)
    part = hills.certify()
    assert not part.complete
    assert np.isfinite(part.gap_pct).all()


def test_care_that_would_take_all_the_time_leaves_no_point_without_a_bound(hills, monkeypatch):
    """On 229 km with stepped rates, on a busy core, the first lines took the whole minute, and most points had none."""
    make, now_s = lines.LineMaker._line, [0.0]

    def slow(maker, multiplier, care, *others):
        now_s[0] += 1.0 if care else 0.0
        return make(maker, multiplier, care, *others)

    monkeypatch.setattr(lines.LineMaker, "_line", slow)
    monkeypatch.setattr(lines, "_MOST_SLACK", 0.0)  # all lines are made with care
    monkeypatch.setattr(Clock, "elapsed_s", property(lambda clock: now_s[0]))
    part = hills.certify(time_limit_s=2.0)
    assert now_s[0] >= 1.0
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


def test_the_thriftiest_run_alone_is_bounded():
    """Its multiplier is 0, for which there is no line: those tried were far from it, and the gap 0.76 %."""
    train = replace(metro(CUTS_OUT), auxiliary_power_w=1e5)
    result = tgvdp.search(train, LEVEL, at_margin=(1.0,), energy="pantograph")
    assert result.front.time_s[-1] < 1.5 * result.fastest.time_s
    assert 0.0 <= result.certify().gap_pct[-1] < 0.05


def test_costates_of_optimal_runs_jump_downwards_only(hills):
    problem = BoundingProblem(hills.trip)
    for index in range(1, 40, 3):
        profile = hills.profile(index)
        multiplier_j_per_s = float(hills.price_kwh_per_min[index]) * 3.6e6 / 60.0
        ledger = problem.ledger(profile.position_m, profile.speed_mps**2, multiplier_j_per_s)
        assert (ledger.left[2:-1] - ledger.right[1:-2]).max() < 1e-9


@pytest.mark.nojit
def test_hull_of_runs():
    runs = np.array([(10.0, 9.0), (12.0, 4.0), (11.0, 8.0), (14.0, 3.0), (16.0, 5.0), (13.0, 3.5)])
    np.testing.assert_allclose(lower_hull(runs, np.array([10.0, 11.0, 12.0, 13.0, 14.0, 20.0])), [9, 6.5, 4, 3.5, 3, 3])


def test_lines_made_side_by_side_are_those_of_one_core(hills, monkeypatch):
    with on_one_core():
        one = hills.certify()
    monkeypatch.setattr(line_maker, "_LEAST_CELLS", 1)
    beside = hills.certify()
    np.testing.assert_array_equal(beside.line_j, one.line_j)
    np.testing.assert_array_equal(beside.gap_pct, one.gap_pct)


def test_linear_programs_of_many_cells_have_to_be_worth_more():
    """They took ten seconds and more for a hundredth of a percent: 14 s on 16,569 cells."""
    assert [line_maker._more_short(cells) for cells in (100, 1000)] == [0.0, 0.0]
    assert line_maker._more_short(2000) == pytest.approx(2e-4)
    assert line_maker._more_short(100_000) == pytest.approx(3e-4)
