"""Phases of runs as they are driven: none so short that it is there only because a cell ends."""

import numpy as np
import pytest

import tgvdp
from tests.helpers.phases_case import CASES, POINTS, phases_s


@pytest.mark.parametrize(
    "case", [name for name, (_, _, trip) in CASES.items() if not trip.get("energy", trip.get("mass_model"))]
)
def test_no_phase_is_there_only_because_a_cell_ends(case):
    """Dabs of traction, and coasting of some metres, where a run entered a cell next to its line of switching."""
    train, track, trip = CASES[case]
    result = tgvdp.search(train, track, points=POINTS, min_phase_s=0.0, **trip)
    for index in range(1, len(result.front)):
        assert (phases_s(result.profile(index))[:-1] > 0.02).all()


def test_cells_braked_by_the_dynamic_brake_are_one_phase():
    """Before each of them the run coasted for millimetres."""
    train, track, trip = CASES["pantograph"]
    result = tgvdp.search(train, track, points=POINTS, min_phase_s=0.0, **trip)
    short = [(phases_s(result.profile(index)) < 0.1).sum() for index in range(1, len(result.front))]
    assert np.mean(short) <= 2.5
