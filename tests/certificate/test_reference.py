"""The certificate on real lines against reference optima of a direct-transcription solver."""

import csv
from collections import defaultdict

import numpy as np
import pytest

import tgvdp
from benchmarks.instances import synthetic_track, synthetic_train

#: A bound may pass a reference, itself a discretisation, by this share of its energy at most.
_ROUNDING = 1e-4


def _rows(shared):
    found = defaultdict(list)
    with open(shared / "reference" / "optimum.csv", newline="") as file:
        for row in csv.DictReader(file):
            if row["variant"] == "A":
                key = row["track"], row["train"], float(row["from_stop_m"]), float(row["to_stop_m"])
                found[key].append((float(row["T_s"]), float(row["E_ref_kWh"])))
    return found


@pytest.mark.slow
def test_bounds_on_all_reference_lines(shared):
    tracks, trains = shared / "ttobench" / "tracks", shared / "ttobench" / "trains"
    for (track, train, origin_m, destination_m), points in _rows(shared).items():
        result = tgvdp.search(
            tgvdp.load_train(trains / f"{train}.json"),
            tgvdp.load_track(tracks / f"{track}.json"),
            origin_m=origin_m,
            destination_m=destination_m,
        )
        certificate = result.certify()
        place = f"{track} {origin_m:g}"
        for time_s, energy_kwh in points:
            bound_kwh = certificate.at(time_s) / 3.6e6
            assert bound_kwh <= energy_kwh * (1.0 + _ROUNDING), place
            assert bound_kwh >= energy_kwh * (1.0 - 2.5e-3), place
        assert np.median(certificate.gap_pct) <= 0.1, place
        assert certificate.gap_pct.min() > -0.01, place
        assert certificate.gap_pct.max() < 0.35, place


def test_coasting_between_two_touches_of_the_limit():
    """Down to the limit, coasting over a summit, and at the limit again: the costate may jump at both touches."""
    result = tgvdp.search(synthetic_train(), synthetic_track(500e3), points=8)
    gap_pct = result.certify().gap_pct
    assert gap_pct.min() > -0.01
    assert gap_pct[1:].max() < 0.2
