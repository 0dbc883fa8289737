"""Any train on any line: strips, tails, curves, tunnels, neutral sections and braking rates, searched and replayed."""

import math
from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tests.helpers.line_case import TRACK, TRAIN
from tests.helpers.twins.brute_force import least_costs
from tests.helpers.twins.trips import random_switches, random_trip, with_jumping_rates, with_line, with_rates
from tgvdp.errors import InfeasibleError, TgvdpError
from tgvdp.model.convention import CONVENTIONS, Convention
from tgvdp.model.energy import PANTOGRAPH, WHEEL
from tgvdp.model.track import Track
from tgvdp.model.trip import Trip
from tgvdp.referee.replay import replay
from tgvdp.runs.fastest import fastest_run


def line_trip(seed):
    """A random trip under random switches, in two of five cases with braking rates; None if no run is possible."""
    trip = random_trip(seed)
    if trip is None:
        return None
    trip = with_rates(with_line(trip, seed, **random_switches(seed)), seed)
    try:
        fastest_run(trip)
    except InfeasibleError:
        return None
    return trip


@pytest.mark.parametrize("first", range(0, 240, 40))
def test_every_fastest_run_replays(first):
    failed, count = [], 0
    for seed in range(first, first + 40):
        trip = line_trip(seed)
        if trip is not None:
            count += 1
            verdict = replay(trip, fastest_run(trip))
            failed += [] if verdict.ok else [(seed, verdict)]
    assert not failed
    assert count > 20


@pytest.mark.parametrize(
    "seed",
    [
        2768,  # the comfort limit gives way to the power limit within a step
        3109,  # a single row at the comfort limit
        3322,  # a train that a drop of the effort curve holds
        5500,  # a limit of deceleration for one row
    ],
)
def test_fastest_runs_that_were_refused(seed):
    trip = line_trip(seed)
    assert replay(trip, fastest_run(trip)).ok


@pytest.mark.slow
@pytest.mark.parametrize("first", range(1000, 6000, 500))
def test_very_many_fastest_runs_replay(first):
    """None is refused, however contrived its line, and what the referee finds is far below what it allows."""
    for seed in range(first, first + 500):
        trip = line_trip(seed)
        if trip is not None:
            verdict = replay(trip, fastest_run(trip))
            assert verdict.ok, seed
            assert abs(verdict.time_error_pct) < 0.02, seed
            assert abs(verdict.energy_error_pct) < 0.005, seed
            assert verdict.effort_excess_pct < 0.04, seed


def front_of(trip, **options):
    """Search a trip through the public façade."""
    switches = {name: getattr(trip.convention, name) for name in ("mass_model", "limits", "curves", "tunnels")}
    assert trip.convention.gravity_mps2 == CONVENTIONS["ttobench"].gravity_mps2
    speeds = {"start_speed_mps": trip.start_speed_mps, "end_speed_mps": trip.end_speed_mps}
    return tgvdp.search(trip.train, trip.track, energy=trip.energy.kind, **switches, **speeds, **options)


def charged(trip):
    train = replace(
        trip.train,
        traction_efficiency=0.85,
        regeneration_efficiency=0.7,
        auxiliary_power_w=0.5 * trip.train.mass_kg,
    )
    return replace(trip, train=train, energy=PANTOGRAPH)


#: With and without neutral sections and rates; those with neutral sections go to the generic refinement.
SEEDS = [22, 42, 46, 65, 72, 77, 118]


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("energy", ["wheel", "pantograph"])
def test_every_front_replays(seed, energy):
    trip = line_trip(seed)
    result = front_of(charged(trip) if energy == "pantograph" else trip, points=5)
    assert result.complete
    assert all(verdict.ok for verdict in result.verify())
    kinetic_j = 0.5 * trip.train.inertia_kg * float(result.fastest.profile.speed_mps.max()) ** 2
    for index in range(len(result.front)):
        profile = result.profile(index)
        assert profile.duration_s == pytest.approx(result.front.time_s[index], rel=1e-4)
        assert profile.total_energy_j == pytest.approx(result.front.energy_j[index], abs=1e-3 * kinetic_j)


def jumping_trip(seed):
    """A random trip whose braking rates jump severalfold; None if no run is possible."""
    trip = random_trip(seed)
    if trip is None:
        return None
    trip = with_jumping_rates(with_line(trip, seed, **random_switches(seed)), seed)
    try:
        fastest_run(trip)
    except InfeasibleError:
        return None
    return trip


@pytest.mark.parametrize(
    ("make", "seed"),
    [
        (line_trip, 193),  # uphill under traction, slower and slower across its drop
        (line_trip, 349),  # coasting to the stop
        (line_trip, 570),  # 26 cm between two coastings at which nothing changes
        (line_trip, 837),  # brakes of a few newtons where there is no current
        (jumping_trip, 34),  # a rate above the comfort limit
        (jumping_trip, 220),  # coasting without current
        (jumping_trip, 279),  # from one limit to another in one row, across two rates
        (jumping_trip, 322),  # pruned across a change of a limit that the train does not reach
        (jumping_trip, 356),  # the same on a coasting to the stop
    ],
)
def test_fronts_that_were_refused(make, seed):
    assert all(verdict.ok for verdict in front_of(make(seed), points=5).verify())


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 400, 50))
def test_fronts_across_jumping_rates_replay(first):
    count = 0
    for seed in range(first, first + 50):
        trip = jumping_trip(seed)
        if trip is None:
            continue
        try:
            result = front_of(charged(trip) if seed % 2 else trip, points=5, time_limit_s=10.0)
        except TgvdpError as error:  # a mesh of the refinement on which no run is fast enough
            assert "with one acceleration per cell" in str(error)
            continue
        count += 1
        assert all(verdict.ok for verdict in result.verify()), seed
    assert count > 25


POINT = Convention(name="point")
FULL = Convention(name="full", mass_model="strip", limits="tail", curves="roeckl", tunnels=True)
NEUTRAL = replace(TRACK, neutral_sections=((1600.0, 120.0, False), (4300.0, 200.0, True)))
RATES = replace(TRAIN, braking_rates=((0.0, 0.55), (15.0, 0.5), (25.0, 0.4)))
CASES = {
    "line": (TRAIN, TRACK, FULL),
    "neutral": (TRAIN, NEUTRAL, POINT),
    "rates": (RATES, TRACK, POINT),
    "all": (RATES, NEUTRAL, FULL),
}


def case_trip(case, energy=WHEEL):
    train, track, convention = CASES[case]
    return Trip(train=train, track=track, origin_m=0.0, destination_m=6000.0, energy=energy, convention=convention)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("energy", ["wheel", "pantograph"])
def test_no_plain_grid_is_better(case, energy):
    """A dynamic program over speeds that knows the line from its definitions: each of its runs could be driven."""
    trip = case_trip(case, PANTOGRAPH if energy == "pantograph" else WHEEL)
    trip = replace(trip, train=replace(trip.train, auxiliary_power_w=0.0))  # which the plain grid does not count
    result = front_of(trip, points=40, max_margin=0.6)
    assert all(verdict.ok for verdict in result.verify())
    time_s, energy_j = result.front.time_s, result.front.energy_j
    prices = energy_j[0] / time_s[0] * np.exp([1.0, 0.0, -1.0])
    for price, (seconds, joules) in zip(prices, least_costs(trip, result.fastest.profile, prices), strict=True):
        assert seconds < time_s[-1]
        found_j = float((energy_j + price * time_s).min())
        assert found_j <= (joules + price * seconds) * 1.0005
        assert found_j >= (joules + price * seconds) * 0.9  # of the same problem


def test_a_neutral_section_has_its_closed_form():
    """Coasting against A alone: v² falls by 2·A/m_eff per metre, and lowered pantographs draw nothing for that time."""
    train = replace(TRAIN, davis_b_n_per_mps=0.0, davis_c_n_per_mps2=0.0)
    track = Track(length_m=9000.0, speed_limits=((0.0, 25.0),), neutral_sections=((5000.0, 400.0, True),))
    trip = Trip(train=train, track=track, origin_m=0.0, destination_m=9000.0, energy=PANTOGRAPH)
    profile = fastest_run(trip)
    inside = (profile.position_m >= 5000.0) & (profile.position_m <= 5400.0)
    w = profile.speed_mps[inside] ** 2
    assert w[0] == pytest.approx(25.0**2)
    assert w[-1] == pytest.approx(25.0**2 - 2.0 * 2e3 / train.inertia_kg * 400.0)
    assert profile.force_n[:-1][inside[:-1] & inside[1:]] == pytest.approx(0.0, abs=1e-3)
    dark_s = float(np.ptp(profile.time_s[inside]))
    assert dark_s == pytest.approx(2.0 * 400.0 / (math.sqrt(w[0]) + math.sqrt(w[-1])))
    assert profile.balance.auxiliary_j == pytest.approx(1e5 * (profile.duration_s - dark_s))


def test_constant_deceleration_has_its_closed_form():
    """−γ whatever the gradient: the braking distance from 25 m/s is v²/2γ, the time v/γ."""
    train = replace(TRAIN, braking_rates=((0.0, 0.5),), max_speed_mps=25.0)
    track = replace(TRACK, gradients=((0.0, 0.0), (5000.0, -20.0)), speed_limits=((0.0, 32.0),))
    profile = fastest_run(Trip(train=train, track=track, origin_m=0.0, destination_m=6000.0))
    braking_m = 25.0**2 / (2.0 * 0.5)
    at = int(np.searchsorted(profile.position_m, 6000.0 - braking_m - 1e-6))
    assert profile.position_m[at] == pytest.approx(6000.0 - braking_m)
    assert profile.duration_s - profile.time_s[at] == pytest.approx(25.0 / 0.5)


def running_s(train=TRAIN, track=TRACK, **switches):
    convention = Convention(name="test", **switches)
    trip = Trip(train=train, track=track, origin_m=0.0, destination_m=6000.0, convention=convention)
    return fastest_run(trip).duration_s


def test_each_switch_moves_the_running_time_in_its_direction():
    plain_s = running_s()
    assert running_s(limits="tail") > plain_s
    assert running_s(curves="800/R") > plain_s
    assert running_s(curves="roeckl") > plain_s
    early = replace(TRACK, tunnels=((200.0, 900.0, 30.0),))  # where no train brakes
    assert running_s(track=early, tunnels=True) > plain_s
    assert running_s(mass_model="strip") != plain_s
    climb = replace(TRACK, gradients=((0.0, 0.0), (3000.0, 12.0)))  # the tail of a strip is on it later
    assert running_s(track=climb, mass_model="strip") < running_s(track=climb)
    assert running_s(track=NEUTRAL) > plain_s
    assert running_s(train=RATES) > plain_s
