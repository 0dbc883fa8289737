"""Energy models: maps that are refused, where energy goes, violations, and the models from file to result."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import tgvdp
from tests.helpers.energy_case import TRACK, TRAIN, perfect_map
from tgvdp.cli import main
from tgvdp.errors import InputError
from tgvdp.model.energy import WHEEL, EnergyMap, EnergyModel, violations
from tgvdp.referee.replay import replay
from tgvdp.runs.profile import profile_of


@pytest.fixture(scope="module")
def results():
    models = {"wheel": "wheel", "pantograph": "pantograph", "map": perfect_map(TRAIN, 0.1)}
    return {name: tgvdp.search(TRAIN, TRACK, points=12, energy=model) for name, model in models.items()}


@pytest.mark.parametrize("kind", ["wheel", "pantograph", "map"])
def test_every_point_replays_by_its_own_model(results, kind):
    result = results[kind]
    assert len(result.front) >= 10
    for verdict in result.verify():
        assert verdict.ok
        assert abs(verdict.energy_error_pct) <= 0.05
    assert result.trip.energy.kind == kind


def test_the_referee_sees_a_wrong_model(results):
    result = results["pantograph"]
    profile = result.profile(5)
    for other in (WHEEL, EnergyModel("map", perfect_map(TRAIN, 0.1))):
        assert not replay(replace(result.trip, energy=other), profile).ok


def test_balance_is_by_definition(results):
    """η_t = 0.8, η_r = 0.6 and 200 kW, row by row; the wheel model shows the same pantograph beside its own energy."""
    trip = results["pantograph"].trip
    profile = results["pantograph"].profile(6)
    work = profile.force_n[:-1] * np.diff(profile.position_m)
    balance = profile.balance
    assert balance.wheel_j == pytest.approx(work[work > 0.0].sum(), rel=1e-9)
    assert balance.auxiliary_j == pytest.approx(2e5 * profile.duration_s, rel=1e-9)
    assert balance.pantograph_j == pytest.approx(
        balance.wheel_j / 0.8 - balance.regenerated_j + balance.auxiliary_j, rel=1e-9
    )
    assert profile.total_energy_j == pytest.approx(balance.pantograph_j, rel=1e-9)
    assert balance.braking_losses_j == pytest.approx(-work[work < 0.0].sum() - balance.regenerated_j, rel=1e-9)
    assert 0.0 < balance.regenerated_j <= 0.6 * -work[work < 0.0].sum() * (1.0 + 1e-9)
    at_wheel = profile_of(replace(trip, energy=WHEEL), profile.position_m - trip.origin_m, profile.speed_mps**2)
    assert at_wheel.balance == pytest.approx(balance)
    assert at_wheel.total_energy_j == pytest.approx(balance.wheel_j, rel=1e-9)


def test_each_model_is_minimised_by_its_own_front(results):
    """At equal times no front of another model is cheaper by this model's own count."""
    for kind, result in results.items():
        own_s, own_j = result.front.time_s, result.front.energy_j
        for other in results.values():
            if other is result:
                continue
            for index in range(1, len(other.front) - 1):
                rows = other.profile(index)
                charged = profile_of(result.trip, rows.position_m - result.trip.origin_m, rows.speed_mps**2)
                best_j = float(np.interp(charged.duration_s, own_s, own_j))
                assert charged.total_energy_j >= best_j - 4e-3 * abs(own_j[0]), (kind, index)


def test_auxiliary_power_makes_hurrying_worthwhile():
    """E(T) + P·T ends where saving a second costs what the auxiliaries draw in it."""
    hungry = replace(TRAIN, auxiliary_power_w=3e6)
    result = tgvdp.search(hungry, TRACK, points=25, energy="pantograph")
    modest = tgvdp.search(TRAIN, TRACK, points=25, energy="pantograph")
    assert result.front.time_s[-1] < modest.front.time_s[-1]
    assert result.warnings
    assert (np.diff(result.front.energy_j) < 0.0).all()


def test_violations_are_found_where_the_map_gives_too_little():
    fair = perfect_map(TRAIN, 0.1)
    assert violations(TRAIN, fair) == []
    powers = [list(row) for row in fair.power_w]
    powers[20][2] *= 0.5
    powers[30][0] *= 2.0
    found = violations(TRAIN, replace(fair, power_w=tuple(map(tuple, powers))))
    assert {(one.speed_mps, one.demand) for one in found} == {(fair.speed_mps[20], 1.0), (fair.speed_mps[30], -1.0)}
    assert all(one.power_w < one.bound_w for one in found)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"speed_mps": (0.0,)}, "speed_mps must have 2 to"),
        ({"speed_mps": (0.0, 0.0, 9.0)}, "speed_mps must increase, got 0 after 0"),
        ({"speed_mps": (-1.0, 5.0, 9.0)}, "speed_mps must be at least 0 m/s, got -1 m/s"),
        ({"demand": (-2.0, 0.0)}, "demand must be within -1..1"),
        ({"demand": "ab"}, "demand must be a list of numbers"),
        ({"power_w": ((0.0, 1.0),)}, "power_w must have 3 rows of 2 values"),
        ({"power_w": ((0.0, 1.0), (0.0, math.nan), (0.0, 1.0))}, r"power_w\[1\]\[1\] must be finite"),
    ],
)
def test_maps_that_are_refused(change, message):
    given = {"speed_mps": (0.0, 5.0, 9.0), "demand": (0.0, 1.0), "power_w": ((0.0, 1.0),) * 3} | change
    with pytest.raises(InputError, match=message):
        EnergyMap(**given)


@pytest.mark.parametrize(("kind", "energy_map"), [("steam", None), ("map", None), ("wheel", perfect_map(TRAIN))])
def test_models_that_are_refused(kind, energy_map):
    with pytest.raises(InputError, match="energy"):
        EnergyModel(kind, energy_map)


def test_a_scenario_carries_its_map(tmp_path, capsys):
    """The map of the file, one of the catalog, and a file of its own are three ways to name one."""
    fair = perfect_map(TRAIN, 0.1)
    table = {
        "speed_kmh": [3.6 * v for v in fair.speed_mps],
        "demand": list(fair.demand),
        "power_kw": [[p / 1e3 for p in row] for row in fair.power_w],
    }
    trip = {"train": "alstom-emu", "track": "flat-100km", "run": {"to_m": 3000.0, "points": 4, "energy": "map"}}
    (tmp_path / "trip.json").write_text(json.dumps({**trip, "map": table}))
    (tmp_path / "own.json").write_text(json.dumps({"map": table}))
    found = {}
    for name, arguments in {"held": (), "file": ("--energy", str(tmp_path / "own.json"))}.items():
        out = str(tmp_path / name)
        assert main(["search", "--scenario", str(tmp_path / "trip.json"), *arguments, "--quiet", "--out", out]) == 0
        content = json.loads((tmp_path / name / "result.json").read_text())
        found[name] = [point["energy_kwh"] for point in content["front"]]
        assert content["energy"]["model"] == "map"
    assert found["held"] == found["file"]
    assert main(["validate", str(tmp_path / "own.json")]) == 0
    assert "map own (native)" in capsys.readouterr().out


def test_the_table_says_where_energy_goes(tmp_path, capsys):
    arguments = ["--train", "alstom-emu", "--track", "flat-100km", "--to", "3000", "--points", "4", "--no-certify"]
    assert main(["search", *arguments, "--energy", "map", "--out", str(tmp_path)]) == 0
    text = capsys.readouterr().out
    assert "energy by map alstom-map; where it goes, kWh:" in text
    assert "braking losses" in text
    assert "breaks the conservation of energy at" in text


def test_unknown_models_are_bad_input(tmp_path, capsys):
    assert main(["search", "--energy", "alstom", "--out", str(tmp_path / "x")]) == 3
    assert "did you mean 'alstom-map'?" in capsys.readouterr().err
    with pytest.raises(InputError, match="energy must be one of"):
        tgvdp.search(TRAIN, TRACK, energy=3)
