"""The journey front of the published metro line against every combination of coarse fronts of its 13 sections."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from tests.helpers.journey_case import method, sections_of
from tgvdp.formats import load_track, load_train
from tgvdp.journeys.front import journey_front
from tgvdp.journeys.section import SectionRuns

TOLERANCE_S = 1e-3
#: Supplements of the runs that each section has, s: what is between them does not exist.
STEP_S, STEPS = 5.0, 3


@pytest.fixture(scope="module")
def sections(shared):
    folder = shared / "ttobench"
    line = load_track(folder / "tracks" / "CN_Songjiazhuang_Yizhuang.json")
    return sections_of(line, load_train(folder / "trains" / "CN_Beijing_Subway.json"))


@pytest.fixture(scope="module")
def fronts(sections):
    """Coarse fronts, solved once: what any search of them may find."""
    steps_s = STEP_S * np.arange(STEPS)
    return [method(one.trip, one.fastest, one.fastest.duration_s + steps_s, TOLERANCE_S) for one in sections]


def coarse(section, front):
    """A section whose runs are those of its coarse front."""

    def found(trip, fastest, target_s, tolerance_s):
        run = np.searchsorted(front.duration_s, target_s * (1.0 + 1e-9), side="right") - 1
        run = np.unique(run[run >= 0])
        exhausted = bool(target_s[-1] > front.duration_s[-1] + STEP_S)
        return replace(
            front,
            duration_s=front.duration_s[run],
            energy_j=front.energy_j[run],
            multiplier_j_per_s=front.multiplier_j_per_s[run],
            exhausted=exhausted,
        )

    return SectionRuns(section.trip, section.fastest, found)


def every_sum(fronts):
    """Times, s, and energies, J, of all combinations of runs of the sections."""
    time_s, energy_j = np.zeros(1), np.zeros(1)
    for front in fronts:
        time_s = np.add.outer(time_s, front.duration_s).ravel()
        energy_j = np.add.outer(energy_j, front.energy_j).ravel()
    return time_s, energy_j


def agree(sections, fronts, total_s):
    found = journey_front([coarse(*one) for one in zip(sections, fronts, strict=True)], total_s, TOLERANCE_S)
    time_s, energy_j = every_sum(fronts)
    fastest_s = sum(one.fastest.duration_s for one in sections)
    for own_s in total_s:
        least_j = energy_j[time_s <= fastest_s + own_s + 1e-6].min()
        reached = found.front.energy_j[found.front.time_s <= fastest_s + own_s + 1e-6].min()
        assert reached == pytest.approx(least_j, rel=1e-12)


def test_all_sections_at_once(sections, fronts):
    """1.6 million combinations."""
    assert len(sections) == 13
    agree(sections, fronts, STEP_S * np.arange((STEPS - 1) * len(sections) + 1))


def test_all_pairs(sections, fronts):
    for first, second in combinations(range(len(sections)), 2):
        both = [sections[first], sections[second]], [fronts[first], fronts[second]]
        agree(*both, STEP_S * np.arange(2 * STEPS - 1))
