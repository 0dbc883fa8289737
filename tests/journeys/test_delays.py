"""Delays: a single section in closed form, no delays, common random numbers, and the second front."""

from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tests.helpers.journey_case import LINE, METRO, method, sections_of
from tgvdp.errors import InputError
from tgvdp.journeys.delays import Delays, robustness, standard_delays
from tgvdp.model.journey import Journey, TimingPoint


@pytest.fixture(scope="module")
def journey():
    return tgvdp.journey(METRO, LINE, points=9, dwell_s=20.0)


def test_without_delays_everything_is_as_planned(journey):
    nothing = Delays(np.zeros((1, 4)), np.zeros((1, 4)))
    found = journey.robustness(4, delays=nothing)
    assert found.energy_j == pytest.approx(found.planned_j)
    assert found.delay_s == pytest.approx(np.zeros(len(found.names)), abs=1e-9)
    assert (found.punctual == 1.0).all()
    assert found.names[found.on_both] == "optimum"
    assert found.planned_j[0] == pytest.approx(journey.front.energy_j[4])


def test_one_late_departure_in_closed_form():
    """20 s late with 8 s in hand: 12 s late, by the fastest run; 5 s late: in time, by a faster run."""
    (section,) = sections_of(replace(LINE, stops_m=(1200.0, 3400.0)))
    fastest_s = section.fastest.duration_s
    section.reach(np.linspace(0.0, 10.0, 41), 1e-3)
    found = {
        late_s: robustness(
            [section], {"optimum": np.array([fastest_s + 8.0])}, 20.0, Delays(np.full((1, 1), late_s), np.zeros((1, 1)))
        )
        for late_s in (20.0, 5.0)
    }
    assert found[20.0].delay_s[0] == pytest.approx(12.0)
    assert found[20.0].energy_j[0] == pytest.approx(section.fastest.total_energy_j)
    assert found[5.0].delay_s[0] == 0.0
    faster = method(section.trip, section.fastest, np.array([fastest_s + 3.0]), 1e-3)
    assert found[5.0].energy_j[0] == pytest.approx(faster.energy_j[0], rel=2e-3)


def test_a_supplement_at_the_end_leaves_every_stop_late(journey):
    found = journey.robustness(4, mean_delay_s=10.0)
    optimum, end = found.names.index("optimum"), found.names.index("all_at_the_end")
    assert found.delay_s[end] > 1.5 * found.delay_s[optimum]
    assert found.punctual[end] >= found.punctual[optimum] - 0.05
    assert (found.energy_j > found.planned_j).all()


def test_the_second_front_and_the_allocation_on_both(journey):
    found = journey.robustness(4, mean_delay_s=10.0)
    for at in range(len(found.names)):
        ahead = (found.front.time_s <= found.delay_s[at]) & (found.front.energy_j <= found.energy_j[at])
        assert ahead.any()
    assert found.on_both in found.front.source
    assert found.planned_j[found.on_both] == found.planned_j[found.front.source].min()


def test_the_same_delays_for_all_and_every_time(journey):
    again = [journey.robustness(4, mean_delay_s=10.0).energy_j for _ in range(2)]
    assert again[0].tolist() == again[1].tolist()
    drawn = standard_delays([100.0, 300.0], 10.0, disturbance=0.05, scenarios=20_000)
    assert drawn.departure_s.mean(axis=0) == pytest.approx([10.0, 10.0], rel=0.03)
    assert drawn.running_s.mean(axis=0) == pytest.approx([5.0, 15.0], rel=0.03)


def test_what_is_refused(journey):
    with pytest.raises(InputError, match="mean_s must be at least 0 s"):
        journey.robustness(mean_delay_s=-1.0)
    with pytest.raises(InputError, match="scenarios must be at least 1"):
        standard_delays([100.0], 10.0, scenarios=0)
    timed = Journey(
        points=(TimingPoint(0.0, 0.0, 0.0, 0.0, 0.0), TimingPoint(6000.0, 0.0, 900.0, 0.0, 0.0)), track=LINE.name
    )
    with pytest.raises(InputError, match="without windows only"):
        tgvdp.journey(METRO, LINE, timed, points=2).robustness()
