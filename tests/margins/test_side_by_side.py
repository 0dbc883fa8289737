"""Margins side by side: times to 0.1 s, energies that fall, distances from the linear time, ranges, what is refused."""

import itertools
import math
import time
from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tests.helpers.journey_case import LINE, METRO
from tests.helpers.margin_case import HILLS, TRAIN
from tgvdp import EffortCurve
from tgvdp.errors import BudgetExceededError, InfeasibleError, InputError
from tgvdp.margins.side_by_side import passing_s
from tgvdp.model.journey import Journey, TimingPoint
from tgvdp.model.margin import MarginRange, Supplement
from tgvdp.units import counted

WITHIN = 0.02


@pytest.fixture(scope="module", params=["metro", "hills", "metro at the pantograph"])
def slowed(request):
    """Margins of 2 to 40 % of one journey."""
    line = (TRAIN, HILLS) if request.param == "hills" else (replace(METRO, auxiliary_power_w=40e3), LINE)
    energy = "pantograph" if "pantograph" in request.param else "wheel"
    journey = tgvdp.journey(*line, points=2, energy=energy)
    return journey, [journey.margins(f"{percent}%", WITHIN) for percent in (2, 5, 10, 20, 40)]


def test_running_times_are_met_and_energies_fall(slowed):
    journey, margins = slowed
    for share, one in zip((0.02, 0.05, 0.1, 0.2, 0.4), margins, strict=True):
        assert list(one.runs) == ["linear", "economy", "uniform", "optimum"]
        assert list(one.time_s.values()) == pytest.approx([(1.0 + share) * journey.fastest_time_s] * 4, abs=0.1)
    for before, after in itertools.pairwise(margins):
        assert all(after.energy_j[name] < before.energy_j[name] for name in after.runs)


def test_what_a_prompt_shows_is_one_line_of_figures(slowed):
    journey, margins = slowed
    run, kwh = margins[2].profile("linear"), {name: one / 3.6e6 for name, one in margins[2].energy_j.items()}
    ran = f"0 to {run.position_m[-1] / 1e3:g} km in {run.duration_s:.1f} s"
    assert repr(run) == f"<Profile: {ran}, {kwh['linear']:.2f} kWh, {len(run.position_m)} rows>"
    assert repr(margins[2]) == (
        f"<Margins: {counted(len(journey.sections), 'section')}, from {journey.fastest_time_s:.1f} to "
        f"{1.1 * journey.fastest_time_s:.1f} s: linear {kwh['linear']:.2f} kWh, economy {kwh['economy']:.2f} kWh, "
        f"uniform {kwh['uniform']:.2f} kWh, optimum {kwh['optimum']:.2f} kWh>"
    )


def test_the_optimum_is_cheapest_and_the_uniform_margin_cheaper_than_the_linear_one(slowed):
    for one in slowed[1]:
        assert one.energy_j["optimum"] <= one.energy_j["economy"] * (1.0 + 2e-4)
        assert one.energy_j["economy"] < one.energy_j["uniform"] < one.energy_j["linear"]


def test_the_optimum_has_a_time_limit_of_its_own():
    """Asked for after that of the journey had passed it was the fastest journey."""
    journey = tgvdp.journey(METRO, LINE, points=2, time_limit_s=2.0)
    asked_at_once = journey.margins("5%", time_limit_s=60.0)
    time.sleep(2.0)
    asked_later = journey.margins("5%", time_limit_s=60.0)
    assert asked_later.energy_j == asked_at_once.energy_j
    assert asked_later.time_s["optimum"] == pytest.approx(1.05 * journey.fastest_time_s, abs=0.1)
    with pytest.raises(BudgetExceededError, match="the time limit"):
        journey.margins("5%", time_limit_s=1e-6)


def test_all_of_them_replay(slowed):
    for one in slowed[1]:
        assert all(verdict.ok for own in one.verify().values() for verdict in own)


def test_the_uniform_margin_is_within_its_share_between_any_two_points(slowed):
    for one in slowed[1]:
        for run, linear in zip(one.runs["uniform"], one.runs["linear"], strict=True):
            position_m = np.union1d(run.position_m, linear.position_m)
            ratio = np.diff(passing_s(run, position_m)) / np.diff(passing_s(linear, position_m))
            assert np.abs(ratio - 1.0).max() <= WITHIN + 1e-9  # so between any two of them


def test_deviations_are_those_of_the_profiles(slowed):
    journey, margins = slowed
    dwell_s = journey.options["dwell_s"]
    for name in margins[2].runs:
        run, linear = margins[2].profile(name), margins[2].profile("linear")
        assert run.duration_s == pytest.approx(linear.duration_s, abs=0.1)
        at_m = np.linspace(journey.trip.origin_m, journey.trip.destination_m, 997)[1:-1]
        late_s = np.abs(np.interp(at_m, run.position_m, run.time_s) - np.interp(at_m, linear.position_m, linear.time_s))
        late_s = late_s[late_s < dwell_s / 2.0]
        assert late_s.max(initial=0.0) == pytest.approx(margins[2].deviation_s[name], abs=0.3)
    assert margins[2].deviation_s["linear"] == 0.0
    assert 0.0 < margins[2].deviation_s["uniform"] < margins[2].deviation_s["economy"]


RANGES = "0:2200:5%,2200:4300:4.5min/100km,4300::20s"


def test_ranges_of_the_line_have_margins_of_their_own():
    """Two borders: one on the way, where the train does not stop, and one at a stop."""
    journey = tgvdp.journey(METRO, LINE, points=2)
    margins = journey.margins(RANGES)

    def time_within(runs, from_m, to_m):
        ends_m = [np.clip((from_m, to_m), run.position_m[0], run.position_m[-1]) for run in runs]
        return sum(float(np.diff(passing_s(run, own_m))[0]) for run, own_m in zip(runs, ends_m, strict=True))

    fastest = [section.fastest for section in journey.sections]
    first_s, second_s, third_s = (time_within(fastest, *ends) for ends in ((0, 2200), (2200, 4300), (4300, 6000)))
    wanted_s = [1.05 * first_s, second_s + 2100.0 * 270.0 / 1e5, third_s + 20.0]
    for name in ("linear", "economy", "uniform"):
        taken_s = [time_within(margins.runs[name], *ends) for ends in ((0, 2200), (2200, 4300), (4300, 6000))]
        assert taken_s == pytest.approx(wanted_s, abs=0.1)
    assert margins.time_s["optimum"] == pytest.approx(sum(wanted_s), abs=0.1)
    assert all(verdict.ok for own in margins.verify().values() for verdict in own)
    assert all(verdict.ok is None for own in margins.verify(1e-9).values() for verdict in own)


@pytest.mark.parametrize("ranges", ["0:3.1km:20%,3.1km:12.9km:20%", "0:9.2km:10%,9.2km:17.2km:10%"])
def test_times_are_met_between_faster_neighbours(ranges):
    """A part that speeds up to its neighbour at its end is slower elsewhere, at its begin as well."""
    margins = tgvdp.journey(TRAIN, HILLS, points=2).margins(ranges)
    assert list(margins.time_s.values()) == pytest.approx([margins.time_s["linear"]] * 4, abs=0.02)
    assert all(verdict.ok for own in margins.verify().values() for verdict in own)


def test_a_border_next_to_the_balancing_speed_can_be_reached():
    """Driven from the cap up to it a train comes near that speed and no nearer: once that refused the margin."""
    weak = replace(TRAIN, traction=EffortCurve.from_caps(9e4, 2.2e6))
    line = replace(HILLS, gradients=((0.0, 0.0), (9000.0, 18.0), (10_000.0, 2.0)))
    margins = tgvdp.journey(weak, line, points=2).margins("0:3.7km:10%,3.7km:8.4km:5%")
    assert margins.time_s["economy"] == pytest.approx(margins.time_s["linear"], abs=0.02)


def test_a_range_without_supplement_is_run_as_fast_as_can_be():
    journey = tgvdp.journey(TRAIN, HILLS, points=2)
    margins = journey.margins([MarginRange(0.0, 9500.0, Supplement()), MarginRange(9500.0, math.inf, Supplement(0.1))])
    for name in ("linear", "economy", "uniform"):
        run, fastest = margins.runs[name][0], journey.sections[0].fastest
        at_m = np.linspace(0.0, 9500.0, 50)
        assert passing_s(run, at_m) == pytest.approx(passing_s(fastest, at_m), abs=1e-3)
        assert run.duration_s > fastest.duration_s + 10.0


def test_the_linear_margin_of_the_whole_line_is_as_defined():
    """Every stretch takes the same ratio of its fastest time, to 1e-9."""
    journey = tgvdp.journey(METRO, LINE, points=2)
    for run, section in zip(journey.margins("7%").runs["linear"], journey.sections, strict=True):
        assert run.time_s == pytest.approx(1.07 * section.fastest.time_s, rel=1e-9, abs=1e-9)
        assert run.speed_mps == pytest.approx(section.fastest.speed_mps / 1.07, rel=1e-9)


def test_the_wider_the_corridor_the_less_energy():
    journey = tgvdp.journey(METRO, replace(LINE, stops_m=(0.0, 1200.0)), points=2)
    widths = [journey.margins("10%", within) for within in (1e-6, 0.01, 0.02, 0.05, 0.1)]
    energies_j = [one.energy_j["uniform"] for one in widths]
    assert (np.diff(energies_j) < 0.0).all()
    assert energies_j[0] == pytest.approx(widths[0].energy_j["linear"], rel=1e-9)
    assert energies_j[-1] > widths[0].energy_j["optimum"]


def test_what_is_refused():
    journey = tgvdp.journey(METRO, LINE, points=2)
    with pytest.raises(InputError, match="two ranges hold 400 m"):
        journey.margins("0:500:5%,400::5%")
    with pytest.raises(InputError, match="a range from 500 m to 400 m is empty"):
        journey.margins("500:400:5%")
    with pytest.raises(InputError, match=r"margins: to must lie within the line's 6000 m, got 50000 m"):
        journey.margins("0:50km:5%")
    with pytest.raises(InputError, match=r"margins: from must lie within the line's 6000 m, got 6000 m"):
        journey.margins("6km::5%")
    with pytest.raises(InputError, match="within must be below 1 as a share"):
        journey.margins("5%", within=1.5)
    with pytest.raises(InputError, match="share must be at least 0"):
        journey.margins([MarginRange(0.0, math.inf, Supplement(-0.1))])
    with pytest.raises(InfeasibleError, match=r"margins: one of them has no run that takes .* s from 1100 m to 1110 m"):
        journey.margins("1100:1110:900s")
    stops = [TimingPoint(at_m, 0.0, 900.0, 0.0, 0.0) for at_m in (0.0, 6000.0)]
    timed = tgvdp.journey(METRO, replace(LINE, stops_m=(0.0, 6000.0)), Journey(points=tuple(stops)), points=2)
    with pytest.raises(InputError, match="margins are taken without windows only"):
        timed.margins("5%")
