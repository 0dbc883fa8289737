"""`tgvdp.sweep`: scenarios in, results out, nothing kept."""

import numpy as np
import pytest

import tgvdp
from tests.helpers.metro_case import TRAIN

pytest.importorskip("distributed")

LINE = tgvdp.Track(length_m=1200.0, speed_limits=(tgvdp.SpeedLimit(0.0, 18.0),), stops_m=(0.0, 700.0, 1200.0))


def test_results_are_those_of_searches():
    taken = []

    def scenarios():
        for wind_mps in range(12):
            taken.append(wind_mps)
            yield {"train": TRAIN, "track": LINE, "wind_mps": float(wind_mps), "points": 4}
        yield {"train": TRAIN, "track": LINE, "at_s": [1.0]}  # faster than the fastest run

    results = sorted(tgvdp.sweep(scenarios(), workers=2), key=lambda result: result.number)
    assert [result.number for result in results] == list(range(13))
    *good, bad = results
    assert (bad.status, bad.front) == ("failed", None)
    assert bad.error.startswith("search: ")
    for result in good:
        expected = tgvdp.search(TRAIN, LINE, wind_mps=result.scenario["wind_mps"], points=4)
        assert np.array_equal(result.front.time_s, expected.front.time_s)
        assert np.array_equal(result.front.energy_j, expected.front.energy_j)
        assert result.fastest_energy_j == expected.fastest.energy_j


def test_journeys_too_and_an_endless_iterable_is_left():
    def endless():
        while True:
            yield {"train": TRAIN, "track": LINE, "points": 3}

    results = tgvdp.sweep(endless(), kind="journey", workers=1)
    first = next(results)
    results.close()
    expected = tgvdp.journey(TRAIN, LINE, points=3)
    assert np.array_equal(first.front.energy_j, expected.front.energy_j)


@pytest.mark.parametrize(
    ("scenario", "message"),
    [
        ({"train": TRAIN}, "scenario 0: must have a train and a track"),
        ({"train": TRAIN, "track": LINE, "wind": 3}, "scenario 0: search has no argument 'wind'"),
        ({"train": "nothing", "track": LINE}, "scenario 0: unknown train 'nothing'"),
    ],
)
def test_what_is_no_scenario_is_named(scenario, message):
    with pytest.raises(tgvdp.InputError, match=message):
        list(tgvdp.sweep([scenario], workers=1))
