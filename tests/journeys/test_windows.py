"""Windows at stops: against every split on fine steps, in closed form, and what is said where they cannot be met."""

import math
from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tests.helpers.journey_case import LINE, METRO, method, sections_of
from tgvdp.errors import InfeasibleError
from tgvdp.journeys.multiplier import Demand
from tgvdp.journeys.windows import Timetable, Windows, windows_of
from tgvdp.model.energy import EnergyModel
from tgvdp.model.journey import Journey, TimingPoint
from tgvdp.model.track import NeutralSection

THREE = replace(LINE, stops_m=LINE.stops_m[:4])
STOPS_M = THREE.stops_m
DWELL_S = 20.0
FASTEST_S = [section.fastest.duration_s for section in sections_of(THREE)]
FREE = (-math.inf, math.inf)
#: Of auxiliaries, W: waiting draws it at the pantograph.
AUXILIARY_W = 2e5


def timetable(arrivals=(FREE, FREE, FREE), departures=((0.0, 0.0), FREE, FREE)):
    points = []
    for number in range(3):
        points.append(TimingPoint(STOPS_M[number], *departures[number], 0.0, 0.0))
        points.append(TimingPoint(STOPS_M[number + 1], *arrivals[number], 0.0, 0.0))
    return Journey(points=tuple(points), track=THREE.name)


def run(windows, **options):
    return tgvdp.journey(replace(METRO, auxiliary_power_w=AUXILIARY_W), THREE, windows, dwell_s=DWELL_S, **options)


def clock_of(journey):
    """Departures and arrivals of each section at each point, s."""
    return journey.found.departure_s, journey.found.departure_s + journey.section_time_s


@pytest.fixture(scope="module", params=[0.0, AUXILIARY_W])
def case(request):
    """What a train draws in waiting, and energies of the three sections at supplements of whole seconds.

    At the pantograph beyond the thriftiest runs as well: who does not count auxiliaries sees none yet.
    """
    waiting_w, fronts = request.param, []
    for section in sections_of(THREE, replace(METRO, auxiliary_power_w=0.0)):
        trip = replace(section.trip, energy=EnergyModel("pantograph" if waiting_w else "wheel"))
        target_s = section.fastest.duration_s + np.arange(61.0)
        found = method(trip, section.fastest, target_s, 1e-3)
        own_j = found.energy_j[np.searchsorted(found.duration_s, target_s * (1 + 1e-9), side="right") - 1]
        fronts.append(own_j + waiting_w * target_s)
    return waiting_w, fronts


def every_split_j(waiting_w, fronts_j, windows, last_s):
    """Least energy of all splits by whole seconds that meet the windows and arrive by a time, waiting included."""
    first, second, third = np.meshgrid(*(np.arange(61.0),) * 3, indexing="ij")
    clock_s, met = np.zeros_like(first), np.ones_like(first, dtype=bool)
    waited_s = np.zeros_like(first)
    for number, taken_s in enumerate((first, second, third)):
        departure, arrival = windows.points[2 * number], windows.points[2 * number + 1]
        waited_s += np.maximum(departure.earliest_s - clock_s, 0.0)
        clock_s = np.maximum(clock_s, departure.earliest_s)
        met &= clock_s <= departure.latest_s
        clock_s = clock_s + FASTEST_S[number] + taken_s
        met &= (clock_s >= arrival.earliest_s) & (clock_s <= arrival.latest_s)
        clock_s = clock_s + DWELL_S
    met &= clock_s - DWELL_S <= last_s
    energy_j = fronts_j[0][:, None, None] + fronts_j[1][:, None] + fronts_j[2] + waiting_w * waited_s
    return float(np.where(met, energy_j, np.inf).min())


@pytest.mark.parametrize("seed", range(8))
def test_random_windows_are_met_and_no_split_is_cheaper(case, seed):
    waiting_w, fronts_j = case
    random = np.random.default_rng(seed)
    taken_s = random.uniform(3.0, 25.0, 3)
    clock_s, arrivals, departures = 0.0, [], [(0.0, 0.0)]
    for number in range(3):
        clock_s += FASTEST_S[number] + taken_s[number]
        arrivals.append((clock_s - random.uniform(3.0, 12.0), clock_s + random.uniform(1.0, 10.0)))
        clock_s += DWELL_S + random.uniform(0.0, 10.0)
        departures.append((clock_s - random.uniform(0.0, 10.0), clock_s + random.uniform(0.0, 10.0)))
    kept = random.random((2, 3)) < 0.7
    windows = timetable(
        [one if keep else FREE for one, keep in zip(arrivals, kept[0], strict=True)],
        [(0.0, 0.0), *(one if keep else FREE for one, keep in zip(departures[1:3], kept[1], strict=False))],
    )
    journey = run(windows, points=5, energy="pantograph" if waiting_w else "wheel")
    departure_s, arrival_s = clock_of(journey)
    for number in range(3):
        first, last = windows.points[2 * number : 2 * number + 2]
        assert (departure_s[:, number] >= first.earliest_s - 1e-6).all()
        assert (departure_s[:, number] <= first.latest_s + 1e-6).all()
        assert (arrival_s[:, number] >= last.earliest_s - 1e-6).all()
        assert (arrival_s[:, number] <= last.latest_s + 1e-6).all()
    assert (departure_s[:, 1:] - arrival_s[:, :-1] >= DWELL_S - 1e-6).all()
    for index in range(1, len(journey.front)):
        least_j = every_split_j(waiting_w, fronts_j, windows, arrival_s[index, -1] + 0.01)
        assert journey.front.energy_j[index] <= least_j * (1.0 + 1e-4)


def test_a_binding_window_parts_the_multipliers():
    free = run(timetable(arrivals=(FREE, FREE, (-math.inf, 400.0))), points=4)
    assert np.ptp(free.found.multiplier_j_per_s[-1]) < 0.02 * free.found.multiplier_j_per_s[-1, 0]
    tight = run(timetable(arrivals=((-math.inf, FASTEST_S[0] + 2.0), FREE, (-math.inf, 400.0))), points=4)
    assert clock_of(tight)[1][-1, 0] == pytest.approx(FASTEST_S[0] + 2.0, abs=0.01)
    first, second, third = tight.found.multiplier_j_per_s[-1]
    assert first > 2.0 * second
    assert second == pytest.approx(third, rel=0.02)


@pytest.mark.parametrize("energy", ["wheel", "pantograph"])
def test_without_windows_it_is_the_front_of_the_journey(energy):
    loose = run(timetable(arrivals=(FREE, FREE, (0.0, 1e4))), points=5, energy=energy)
    plain = run(None, points=5, energy=energy)
    assert loose.front.time_s == pytest.approx(plain.front.time_s, abs=0.02)
    assert loose.front.energy_j[1:] == pytest.approx(plain.front.energy_j[1:], rel=1e-3)


@pytest.mark.parametrize("energy", ["pantograph", "map"])
def test_a_slot_is_filled_rather_than_waited_in(energy):
    """The fastest run and its wait took 8 to 12 % more in all than a run that fills the slot."""
    slot_s = 1.5 * FASTEST_S[0]
    stop = {"lowest_mps": 0.0, "highest_mps": 0.0}
    ends = [TimingPoint(STOPS_M[1], slot_s, slot_s, **stop)]
    found = []
    for latest_s in (0.0, slot_s):  # to leave at once, or to wait as long as one likes
        points = (TimingPoint(STOPS_M[0], 0.0, latest_s, **stop), *ends)
        found.append(run(Journey(points=points, track=THREE.name), points=2, energy=energy, time_limit_s=600.0))
    filled, free = found
    assert filled.found.waiting_s == pytest.approx(0.0, abs=0.1)
    assert free.front.energy_j[0] == pytest.approx(filled.front.energy_j[0], rel=2e-3)
    if energy == "pantograph":
        assert free.found.waiting_s == pytest.approx(0.0, abs=0.1)
        assert free.found.multiplier_j_per_s[0, 0] > -AUXILIARY_W
        assert (free.certify().lower_bound_j <= free.front.energy_j).all()


def test_waiting_is_counted_where_it_cannot_be_helped():
    """The section ends in time, and the next one begins when its window opens: P times what is between, less dwells."""
    windows = timetable(arrivals=((0.0, FASTEST_S[0] + 2.0), FREE, FREE), departures=((0.0, 0.0), (300.0, 300.0), FREE))
    journey = run(windows, points=3, energy="pantograph")
    departure_s, arrival_s = clock_of(journey)
    waits_s = (departure_s[:, 1:] - arrival_s[:, :-1] - DWELL_S).sum(axis=1)
    assert journey.found.waiting_s == pytest.approx(waits_s, abs=1e-6)
    total_j = journey.section_energy_j.sum(axis=1) + AUXILIARY_W * waits_s
    assert journey.front.energy_j == pytest.approx(total_j)
    bound = journey.certify()
    assert (bound.lower_bound_j <= journey.front.energy_j).all()
    assert np.median(bound.gap_pct(journey.front.energy_j)) < 0.1


def test_where_pantographs_are_lowered_waiting_is_not_counted():
    """Nothing counts there: a train would rather linger there than wait, be it in another section."""
    line = replace(THREE, neutral_sections=(NeutralSection(STOPS_M[2] + 100.0, 50.0, True),))
    windows = timetable(departures=((0.0, 0.0), (300.0, 300.0), FREE))
    journey = tgvdp.journey(METRO, line, windows, points=2, energy="pantograph")
    assert (journey.found.waiting_s > 0.0).all()
    assert journey.found.waiting_w == 0.0
    assert (journey.certify().lower_bound_j <= journey.front.energy_j).all()


def test_the_profile_waits_where_the_window_is_later():
    journey = run(timetable(departures=((10.0, 10.0), (200.0, 210.0), FREE)), points=3)
    departure_s, arrival_s = clock_of(journey)
    assert departure_s[:, :2] == pytest.approx(np.tile([10.0, 200.0], (len(journey.front), 1)), abs=0.01)
    profile = journey.profile(0)
    stand = int(np.flatnonzero(np.diff(profile.position_m) == 0.0)[0])
    assert np.diff(profile.time_s)[stand] == pytest.approx(200.0 - arrival_s[0, 0])
    journey.plot("time_distance")


@pytest.mark.parametrize(
    ("windows", "message"),
    [
        ({"arrivals": ((0.0, FASTEST_S[0] - 3.0), FREE, FREE)}, "closes at .* it is missed by 3 s, and met when"),
        ({"arrivals": (FREE, FREE, (0.0, sum(FASTEST_S)))}, "at 4300 m closes at .* missed by 40 s"),
        ({"departures": ((0.0, 0.0), (0.0, FASTEST_S[0]), FREE)}, "at 1200 m closes at .* missed by 20 s"),
    ],
)
def test_windows_that_cannot_be_met_are_named(windows, message):
    with pytest.raises(InfeasibleError, match=message):
        run(timetable(**windows), points=3)


def test_a_stop_that_opens_late_is_reached_late_and_certified():
    """No departure waits for it: the train runs slower than its thriftiest run."""
    points = timetable(departures=((0.0, 0.0), FREE, FREE), arrivals=((9000.0, 9001.0), FREE, FREE)).points[:2]
    journey = run(Journey(points=points, track=THREE.name), points=3)
    departure_s, arrival_s = clock_of(journey)
    assert departure_s == pytest.approx(0.0)
    assert (arrival_s >= 9000.0 - 1e-6).all()
    assert (arrival_s <= 9001.0 + 1e-6).all()
    assert all(verdict.ok for point in journey.verify() for verdict in point)
    assert (journey.certify().lower_bound_j <= journey.front.energy_j).all()


def test_asked_times_are_arrivals_on_the_clock_and_margins_count_from_the_earliest():
    first_s = sum(FASTEST_S) + 2 * DWELL_S
    windows = timetable(departures=((10.0, 10.0), FREE, FREE), arrivals=(FREE, FREE, (0.0, first_s + 60.0)))
    journey = run(windows, at_s=(first_s + 30.0,), at_margin=(0.05,))
    asked_s = [first_s + 10.0 + 0.05 * sum(FASTEST_S), first_s + 30.0]
    assert clock_of(journey)[1][:, -1] == pytest.approx(asked_s, abs=0.1)
    with pytest.raises(InfeasibleError, match="is later than the last window allows"):
        run(windows, at_s=(first_s + 61.0,))
    with pytest.raises(InfeasibleError, match=f"it cannot arrive at {first_s:.6g} s: the earliest arrival is"):
        run(windows, at_s=(first_s,))


def test_a_window_that_is_left_is_named():
    windows = Windows((TimingPoint(0.0),), (TimingPoint(5.0, 10.0, 12.0),), ())
    assert not list(windows.left_by(np.zeros((2, 1)), np.array([[10.0], [12.0]]), 1e-3))
    (told,) = windows.left_by(np.zeros((2, 1)), np.array([[9.5], [12.2]]), 1e-3)
    assert told == "the window at 5 m is left: the train is there 0.5 s earlier than it opens"


def test_schedules_in_closed_form():
    """λ = exp(−T) in both sections, the second may begin at 3 s: what is saved until then is free."""
    point = TimingPoint
    demand = Demand(np.linspace(0.0, 10.0, 21), -np.linspace(0.0, 10.0, 21))
    windows = Windows((point(0.0, 0.0, 0.0), point(1.0, 3.0)), (point(1.0), point(2.0)), (0.0,))
    found = Timetable(windows, [1.0, 1.0], [demand, demand], 0.0).at(np.array([4.0, 5.0, 9.0]))
    assert found.supplement_s == pytest.approx(np.array([[2.0, 0.0], [2.0, 1.0], [3.5, 3.5]]), abs=0.1)
    assert found.departure_s[:, 1] == pytest.approx([3.0, 3.0, 4.5], abs=0.1)


@pytest.mark.parametrize(
    ("arrival", "departure", "dwell_s"),
    [
        ((140.0, 140.0), (160.0, 160.0), 20.0),
        ((140.0, 150.0), (150.0, 160.0), 20.0),
        ((140.0, 140.0), (200.0, 200.0), 30.0),
        (FREE, (160.0, 160.0), 30.0),
        ((140.0, 140.0), FREE, 30.0),
        (FREE, FREE, 30.0),
    ],
)
def test_a_timetable_says_how_long_a_train_stands_at_least(arrival, departure, dwell_s):
    """A stop of 20 s was "missed by 10 s", for 30 s are the default."""
    windows = windows_of(timetable((arrival, FREE, FREE), ((0.0, 0.0), departure, FREE)), 30.0)
    assert windows.dwells_s == (dwell_s, 30.0)


def test_a_shorter_stop_than_asked_for_is_told():
    arrival_s = math.ceil(FASTEST_S[0]) + 5.0
    times = timetable(((arrival_s, arrival_s), FREE, FREE), ((0.0, 0.0), (arrival_s + 12.0,) * 2, FREE))
    result = tgvdp.journey(METRO, THREE, times, points=3)
    assert any("12 s of its timetable, not 30 s" in warning for warning in result.warnings)
