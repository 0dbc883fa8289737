"""The JSON object and the CSV tables: schema, figures, and rows that reproduce the run they describe."""

import csv
import io
import json
import time
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.report_case import PROVENANCE, VERDICT, Found, make_result, railway_trip, toy_trip
from tgvdp.certificate.front import Certificate
from tgvdp.errors import InputError
from tgvdp.report.columns import to_csv
from tgvdp.report.profiles import PROFILE_DIGITS, choose_runs, profile_columns
from tgvdp.report.tables import BALANCE_FIELDS, FRONT_COLUMNS, front_columns, make_tariff, result_object
from tgvdp.runs.profile import REGIMES


@pytest.fixture(scope="module")
def result():
    return make_result(railway_trip(), [24.0, 20.0, 16.0])


def content_of(result, verdict=VERDICT):
    return result_object(result, [verdict] * len(result.front), PROVENANCE)


def table(data):
    return list(csv.DictReader(io.StringIO(data.decode())))


def front_csv(content):
    return to_csv(front_columns(content))


def profiles_csv(result):
    return to_csv(profile_columns(result, choose_runs(result)), PROFILE_DIGITS)


def test_object_has_the_published_schema(result):
    content = content_of(result)
    assert content["schema"] == "tgvdp.search/1"
    assert set(content["fastest"]) == {
        *("time_s", "energy_kwh", "stepped_time_s", "peak_power_kw", "balance", "ride", "advice"),
    }
    assert content["energy"] == {"model": "wheel"}
    for point in content["front"]:
        assert list(point) == [*FRONT_COLUMNS, "balance", "ride", "advice", "replay"]
        assert list(point["balance"]) == list(BALANCE_FIELDS)
        assert point["balance"]["wheel_kwh"] == pytest.approx(point["energy_kwh"])
        assert list(point)[:6] == ["id", "time_s", "delay_s", "margin_pct", "energy_kwh", "saved_pct"]
        assert set(point["replay"]) == {
            "time_error_pct",
            "energy_error_pct",
            "overspeed_mps",
            "effort_excess_pct",
            "ok",
        }
    assert content["counters"] == {"expanded": 12, "generated": 34}
    assert content["provenance"] == PROVENANCE
    assert content["complete"] is True
    assert "warning" not in content


def test_object_survives_json_unchanged(result):
    content = content_of(result)
    assert json.loads(json.dumps(content, allow_nan=False)) == content


def test_figures_follow_from_the_front(result):
    content = content_of(result)
    fastest_s, fastest_kwh = result.fastest.time_s, result.fastest.energy_j / 3.6e6
    for index, point in enumerate(content["front"]):
        assert point["id"] == index
        assert point["time_s"] == result.front.time_s[index]
        assert point["delay_s"] == pytest.approx(point["time_s"] - fastest_s)
        assert point["margin_pct"] == pytest.approx(100 * point["delay_s"] / fastest_s)
        assert point["energy_kwh"] == pytest.approx(result.front.energy_j[index] / 3.6e6)
        assert point["saved_pct"] == pytest.approx(100 * (1 - point["energy_kwh"] / fastest_kwh))


def test_a_partial_result_says_so(result):
    content = content_of(replace(result, complete=False, warnings=("ended by its budget",)))
    assert content["complete"] is False
    assert content["warning"] == "ended by its budget"


def test_bounds_are_in_every_table_when_proven(result):
    unknown = content_of(result)["front"][1]
    assert [unknown[name] for name in ("price_kwh_per_min", "lower_bound_kwh", "gap_pct")] == [None, None, None]
    bound_j = 0.99 * result.front.energy_j
    certificate = Certificate(bound_j, np.full(3, 1.0), np.array([1.0]), np.array([0.0]), 0.0, 0.0)
    content = result_object(result, [VERDICT] * 3, PROVENANCE, certificate)
    for point, row in zip(content["front"], table(front_csv(content)), strict=True):
        assert point["lower_bound_kwh"] == pytest.approx(0.99 * point["energy_kwh"])
        assert float(row["lower_bound_kwh"]) == pytest.approx(point["lower_bound_kwh"], rel=1e-8)
        assert float(row["gap_pct"]) == point["gap_pct"] == 1.0
        assert row["price_kwh_per_min"] == ""


def test_figures_that_json_cannot_write_become_null(result):
    content = content_of(result, replace(VERDICT, energy_error_pct=float("inf"), ok=np.False_))
    assert content["front"][0]["replay"]["energy_error_pct"] is None
    assert content["front"][0]["replay"]["ok"] is False
    json.dumps(content, allow_nan=False)


def test_a_tariff_counts_what_is_drawn(result):
    content = result_object(result, [VERDICT] * 3, PROVENANCE, tariff=make_tariff(0.2, 50.0))
    assert content["tariff"] == {"price_per_kwh": 0.2, "co2_g_per_kwh": 50.0}
    for run in (content["fastest"], *content["front"]):
        assert run["cost_eur"] == pytest.approx(0.2 * run["balance"]["pantograph_kwh"])
        assert run["co2_kg"] == pytest.approx(0.05 * run["balance"]["pantograph_kwh"])
    assert {"cost_eur", "co2_kg"} <= set(table(front_csv(content))[0])
    only_price = result_object(result, [VERDICT] * 3, PROVENANCE, tariff=make_tariff(price_per_kwh=0.0))
    assert only_price["fastest"]["cost_eur"] == 0.0
    assert "co2_kg" not in only_price["fastest"]
    for wrong in ({"price_per_kwh": -0.1}, {"co2_g_per_kwh": float("nan")}):
        with pytest.raises(InputError, match="tariff: "):
            make_tariff(**wrong)


def test_peak_power_is_force_times_speed_within_the_limit(result):
    trip, content = result.trip, content_of(result)
    for index, point in enumerate(content["front"]):
        profile = result.profile(index)
        faster = np.maximum(profile.speed_mps[:-1], profile.speed_mps[1:])
        limit = np.array([trip.train.traction_limit.effort_n(v) for v in faster])
        slow_twin_w = np.max(np.minimum(profile.force_n[:-1], limit) * faster)
        assert point["peak_power_kw"] == pytest.approx(slow_twin_w / 1000.0)
        assert point["peak_power_kw"] <= 8000.0 * (1 + 1e-12)


def test_no_saving_where_the_fastest_run_needs_nothing(result):
    free = replace(result, fastest=replace(result.fastest, energy_j=0.0))
    assert [point["saved_pct"] for point in content_of(free)["front"]] == [0.0, 0.0, 0.0]


def test_one_verdict_per_point_is_needed(result):
    with pytest.raises(ValueError, match="shorter"):
        result_object(result, [VERDICT], PROVENANCE)


def test_front_csv_holds_the_points_of_the_object(result):
    content = content_of(result)
    rows = table(front_csv(content))
    energies = [point["energy_kwh"] for point in content["front"]]
    assert [float(row["energy_kwh"]) for row in rows] == pytest.approx(energies, rel=1e-8)
    assert len({len(row["time_s"].partition(".")[2]) for row in rows}) == 1  # the same decimals in all rows
    assert [int(row["id"]) for row in rows] == [0, 1, 2]
    assert rows[0]["ok"] == "True"


@pytest.mark.parametrize(("trip", "speeds"), [(railway_trip(), [24.0, 20.0]), (toy_trip(), [0.6, 0.5])])
def test_profiles_csv_reproduces_each_run(trip, speeds):
    """Distance and duration of the rows alone, with v² linear between them, and the work of their efforts."""
    result = make_result(trip, speeds)
    text = profiles_csv(result)
    assert text.splitlines()[0] == b"id,position_m,speed_mps,limit_mps,gradient_permil,time_s,force_n,energy_j,regime"
    rows = table(text)
    assert list(dict.fromkeys(row["id"] for row in rows)) == ["fastest", "0", "1"]
    for name, profile in (("fastest", result.fastest.profile), ("0", result.profile(0)), ("1", result.profile(1))):
        mine = [row for row in rows if row["id"] == name]
        x, v, t, f, e = (
            np.array([float(row[column]) for row in mine])
            for column in ("position_m", "speed_mps", "time_s", "force_n", "energy_j")
        )
        assert np.sum(2 * np.diff(x) / (v[1:] + v[:-1])) == pytest.approx(profile.duration_s, rel=1e-9)
        assert np.sum(np.maximum(f[:-1], 0) * np.diff(x)) == pytest.approx(profile.total_energy_j, rel=1e-7)
        assert (t[-1], e[-1]) == pytest.approx((profile.duration_s, profile.total_energy_j), rel=1e-10)
        assert [row["regime"] for row in mine] == profile.regime_names
        assert set(profile.regime_names) <= set(REGIMES)


def test_sixty_profiles_are_written_quickly():
    """Sixty profiles of a thousand rows take 0.08 s here; the bar leaves room for a slow machine."""
    trip = railway_trip()
    small = make_result(trip, [20.0])
    x = np.linspace(0.0, trip.distance_m, 1000)
    w = 400.0 * np.minimum(1.0, 5.0 * np.minimum(x, x[::-1]) / trip.distance_m)
    front = type(small.front).of(np.arange(60.0), -np.arange(60.0))
    result = replace(small, front=front, _found=Found(front.time_s, front.energy_j, lambda _: (x, w)))
    started = time.perf_counter()
    text = profiles_csv(result)
    assert time.perf_counter() - started < 1.0
    assert text.count(b"\n") == 1 + 41 + 60_000
