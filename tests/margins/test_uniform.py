"""The uniform margin: what a wider corridor allows is no dearer than what a narrower one does."""

from dataclasses import replace

import pytest

import tgvdp
from tests.helpers.journey_case import LINE, METRO

#: Runs in wide corridors are found to this share of their energy.
FOUND = 5e-3


@pytest.mark.parametrize("stops_m", [(1200.0, 3400.0), (4300.0, 6000.0)])
def test_wider_corridors_are_no_dearer(stops_m):
    journey = tgvdp.journey(METRO, replace(LINE, stops_m=stops_m), points=2)
    found = [journey.margins("5%", within=within) for within in (0.02, 0.1, 0.2)]
    energies_j = [one.energy_j["uniform"] for one in found]
    assert energies_j[1] < energies_j[0] < found[0].energy_j["linear"]
    assert energies_j[2] <= energies_j[1] * (1.0 + FOUND)
    assert energies_j[2] <= 1.05 * found[2].energy_j["optimum"]
    assert all(
        run.duration_s == pytest.approx(one.time_s["linear"], abs=0.1) for one in found for run in one.runs["uniform"]
    )
