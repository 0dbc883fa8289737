"""The front of a journey against every split on fine steps, today's practices, and its own definition."""

import numpy as np
import pytest

from tests.helpers.journey_case import fine_merge_j, sections_of
from tgvdp import EffortCurve, Gradient, SpeedLimit, Track, Train
from tgvdp.journeys import front as journeys
from tgvdp.journeys.front import journey_front

TOLERANCE_S = 3e-3


@pytest.fixture(scope="module")
def found():
    sections = sections_of()
    fastest_s = sum(section.fastest.duration_s for section in sections)
    supplement_s = fastest_s * np.linspace(0.0, 0.25, 12)
    return sections, supplement_s, journey_front(sections, supplement_s, TOLERANCE_S)


def test_running_times_are_met_and_energies_fall(found):
    sections, supplement_s, journey = found
    late_s = journey.front.time_s - sum(section.fastest.duration_s for section in sections) - supplement_s
    assert len(journey.front) == len(supplement_s)
    assert late_s.max() <= 1e-6
    assert late_s.min() >= -2.0 * TOLERANCE_S
    assert journey.complete
    assert not journey.exhausted


def test_what_whole_steps_leave_is_given_out():
    """Next to the fastest runs of two hops between stops chords foretold no saving, and 4.8 s were left."""
    freight = Train(
        mass_kg=2.2e6, traction=EffortCurve.from_caps(5e5, 6e6), friction_brake_n=1e6, davis_a_n=3e4,
        davis_c_n_per_mps2=35.0, max_deceleration_mps2=0.25,
    )  # fmt: skip
    line = Track(
        length_m=4100.0,
        stops_m=(0.0, 1400.0, 1425.0, 1431.0, 4100.0),
        speed_limits=(SpeedLimit(0.0, 20.0),),
        gradients=(Gradient(0.0, -47.0), Gradient(540.0, 0.0)),
    )
    sections = sections_of(line, freight)
    fastest_s = sum(section.fastest.duration_s for section in sections)
    supplement_s = fastest_s * np.linspace(0.0, 1.0, 12)
    front = journey_front(sections, supplement_s, TOLERANCE_S).front
    assert len(front) == len(supplement_s)
    assert np.abs(front.time_s - fastest_s - supplement_s).max() <= 2.0 * TOLERANCE_S


def test_no_split_on_fine_steps_is_cheaper(found):
    _, supplement_s, journey = found
    for index in (2, 6, 11):
        finest_j = fine_merge_j(sections_of(), float(supplement_s[index]))
        assert journey.front.energy_j[index] == pytest.approx(finest_j, rel=1e-3)
        assert journey.front.energy_j[index] <= finest_j * (1.0 + 1e-4)


def test_no_practice_is_cheaper(found):
    _, _, journey = found
    assert set(journey.practices) == {"proportional_to_time", "proportional_to_distance", "all_at_the_end"}
    for practice in journey.practices.values():
        assert (practice.energy_j >= journey.front.energy_j).all()
        assert (practice.time_s <= journey.front.time_s + 2.0 * TOLERANCE_S).all()
    assert journey.practices["all_at_the_end"].energy_j[-1] > 1.05 * journey.front.energy_j[-1]


def test_all_sections_run_at_one_multiplier(found):
    sections, _, journey = found
    own = np.column_stack(
        [section.multiplier_j_per_s[run] for section, run in zip(sections, journey.run.T, strict=True)]
    )
    apart = np.abs(own[1:] / journey.multiplier_j_per_s[1:] - 1.0)
    assert np.median(apart) < 0.01
    assert np.isinf(journey.multiplier_j_per_s[0]).all()


def test_a_front_that_is_not_convex_takes_what_the_exact_merge_finds(monkeypatch):
    """Two sections that save only in whole steps of 10 s: no multiplier leads to one step, the merge does."""
    sections = sections_of()[:2]
    for section in sections:
        monkeypatch.setattr(section, "method", _in_steps(section.method))
    whole = journey_front(sections, np.array([0.0, 5.0, 10.0, 20.0]), TOLERANCE_S)
    assert whole.front.time_s - whole.front.time_s[0] == pytest.approx([0.0, 10.0, 20.0], abs=2.0 * TOLERANCE_S)


def _in_steps(method):
    def stepped(trip, fastest, target_s, tolerance_s):
        wanted_s = fastest.duration_s + 10.0 * np.floor((target_s - fastest.duration_s) / 10.0 + 1e-9)
        return method(trip, fastest, np.unique(wanted_s), tolerance_s)

    return stepped


def test_the_fastest_journey_alone():
    sections = sections_of()
    journey = journey_front(sections, np.zeros(1), TOLERANCE_S)
    assert journey.front.time_s == pytest.approx([sum(section.fastest.duration_s for section in sections)])


def test_sections_are_sampled_as_far_as_the_merge_uses_them(monkeypatch):
    """A first sample that ends too early is extended."""
    monkeypatch.setattr(journeys, "_FIRST_STEPS", 4)
    supplement_s = np.array([40.0])
    short = journey_front(sections_of(), supplement_s, TOLERANCE_S)
    monkeypatch.undo()
    whole = journey_front(sections_of(), supplement_s, TOLERANCE_S)
    assert short.front.energy_j == pytest.approx(whole.front.energy_j, rel=1e-4)
