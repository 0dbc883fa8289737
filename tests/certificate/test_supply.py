"""The certificate of lines with neutral sections: no traction there, no auxiliaries if the pantograph is lowered."""

from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tests.helpers.metro_case import TRAIN
from tgvdp import Track

LINE = Track(
    length_m=4000.0,
    speed_limits=((0.0, 16.0), (600.0, 25.0), (3000.0, 18.0)),
    gradients=((0.0, 3.0), (700.0, -8.0), (1500.0, 0.0), (1900.0, 6.0)),
)


def found(lowered, method, **options):
    """A search on the line with a long stretch without traction, and without auxiliaries if lowered."""
    track = replace(LINE, neutral_sections=((1200.0, 900.0, lowered),))
    return tgvdp.search(TRAIN, track, energy="pantograph", method=method, **options)


@pytest.fixture(scope="module")
def lowered():
    return found(True, "front", points=12)


@pytest.fixture(scope="module")
def certificate(lowered):
    return lowered.certify()


def test_no_run_lies_below(lowered, certificate):
    exact = found(True, "exact", segment_m=250.0, speeds=16)
    for result in (lowered, exact):
        for time_s, energy_j in zip(result.path_time_s, result.path_energy_j, strict=True):
            assert energy_j >= certificate.at(time_s)
    assert 0.0 < np.median(certificate.gap_pct) < 0.5


def test_auxiliaries_that_draw_all_the_time_would_be_too_much(lowered):
    powered = found(False, "front", points=12).certify()
    slower = list(zip(lowered.front.time_s, lowered.front.energy_j, strict=True))[1:]
    assert all(powered.at(time_s) > energy_j for time_s, energy_j in slower)


def test_what_they_draw_at_least_is_counted(lowered, certificate):
    """Lowering the pantograph saves no more than the auxiliaries take over the stretch at the slowest."""
    none = tgvdp.search(
        replace(TRAIN, auxiliary_power_w=0.0), lowered.trip.track, energy="pantograph", points=12
    ).certify()
    fastest_s = float(lowered.front.time_s[0])
    least_j = TRAIN.auxiliary_power_w * 3100.0 / 25.0
    assert certificate.at(fastest_s * 1.1) >= none.at(fastest_s * 1.1) + 0.999 * least_j
