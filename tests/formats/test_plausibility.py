"""Slips of unit stand out, real trains and lines do not; nothing is refused."""

import json
import math
import re
from dataclasses import replace

import pytest

from tests.helpers.format_case import SCENARIO, TTOBENCH_TRACK, TTOBENCH_TRAIN, changed, write_json
from tests.helpers.railml_line_case import LINE_2
from tests.helpers.railml_stock_case import STOCK_2
from tgvdp.cli import main
from tgvdp.formats import load_track, load_train
from tgvdp.formats.review.figures import balancing_speed_mps, track_figures
from tgvdp.formats.review.plausibility import check_track, check_train, review_file
from tgvdp.model import catalog
from tgvdp.model.effort import EffortCurve
from tgvdp.model.track import Curve, Gradient, SpeedLimit, Track, Tunnel
from tgvdp.model.train import Train

TRAIN = load_train("tgv")
TRACK = load_track("lgv-100km")


def warnings(checks):
    """Names of the checks that warn, without the position of rows."""
    return {re.sub(r" at \d.*", "", check.name) for check in checks if not check.ok}


def scaled(curve, factor):
    return EffortCurve(tuple((from_mps, *(factor * term for term in terms)) for from_mps, *terms in curve.pieces))


@pytest.mark.parametrize("name", catalog.names("train"))
def test_trains_of_the_catalog_are_plausible(name):
    assert warnings(check_train(load_train(name))) == set()


@pytest.mark.parametrize("name", catalog.names("track"))
def test_lines_of_the_catalog_are_plausible(name):
    assert warnings(check_track(load_track(name))) == set()


def test_published_files_are_plausible_but_for_what_is_odd_in_them(shared):
    odd = {}
    for folder, check in (("trains", check_train), ("tracks", check_track)):
        load = load_train if folder == "trains" else load_track
        for path in sorted((shared / "ttobench" / folder).glob("*.json")):
            odd[path.stem] = warnings(check(load(path)))
    assert {name: found for name, found in odd.items() if found} == {
        "CN_Beijing_Subway": {"rotating mass factor"},  # published as 0 %
    }
    for name in ("fast", "electric"):
        assert warnings(check_train(load_train(shared / "osrd" / f"{name}_rolling_stock.json"))) == set()
    assert warnings(check_train(load_train(shared / "railtoolkit" / "trains" / "local.yaml"))) == set()


def test_a_heavy_ore_train_is_plausible():
    ore = Train(
        mass_kg=2e7, length_m=2000.0, rotating_mass_factor=1.04, traction=EffortCurve.from_caps(2.2e6, 1.3e7),
        friction_brake_n=5e6, davis_a_n=1.5e5, davis_b_n_per_mps=5e3, davis_c_n_per_mps2=120.0, max_speed_mps=20.0,
    )  # fmt: skip
    assert warnings(check_train(ore)) == set()


@pytest.mark.parametrize(
    ("slip", "expected"),
    [
        ({"traction": scaled(TRAIN.traction, 1000)},
         {"starting effort to weight", "starting acceleration", "power to mass"}),
        ({"traction": scaled(TRAIN.traction, 0.001)},
         {"starting effort to weight", "starting acceleration", "power to mass", "balancing speed"}),
        ({"mass_kg": TRAIN.mass_kg / 1000}, {"mass", "power to mass", "starting effort to weight"}),
        ({"mass_kg": TRAIN.mass_kg * 1000}, {"mass", "power to mass", "mass per length"}),
        ({"max_speed_mps": TRAIN.max_speed_mps * 3.6}, {"top speed", "balancing speed"}),
        ({"max_speed_mps": 80 / 3.6**2}, {"resistance at top speed"}),
        ({"max_speed_mps": 50 / 3.6**2}, {"top speed"}),
        ({"davis_c_n_per_mps2": TRAIN.davis_c_n_per_mps2 * 12.96}, {"resistance at top speed", "balancing speed"}),
        ({"davis_c_n_per_mps2": TRAIN.davis_c_n_per_mps2 / 12.96}, {"quadratic resistance"}),
        ({"davis_a_n": TRAIN.davis_a_n * 1000},
         {"rolling resistance", "resistance at top speed", "balancing speed"}),
        ({"davis_a_n": TRAIN.davis_a_n / 1000}, {"rolling resistance"}),
        ({"friction_brake_n": 0.0, "braking": EffortCurve.from_caps(0.0)}, {"full braking"}),
        ({"rotating_mass_factor": 1.0}, {"rotating mass factor"}),
        ({"traction_efficiency": 0.0085}, {"traction efficiency"}),
        ({"length_m": 0.2}, {"mass per length"}),
        ({"auxiliary_power_w": 4e8}, {"auxiliary power to mass"}),
        ({"traction": EffortCurve.from_points([(0.0, 2e4), (80.0, 2e5)])}, {"rise of effort with speed"}),
        ({"traction": EffortCurve.from_points([(0.0, 2e5), (30.0, 2e5), (31.0, 1e4)])}, {"power at top speed"}),
    ],
)  # fmt: skip
def test_slips_in_trains_stand_out(slip, expected):
    assert expected <= warnings(check_train(replace(TRAIN, **slip)))


@pytest.mark.parametrize(
    ("slip", "expected"),
    [
        ({"speed_limits": [SpeedLimit(0.0, 25.0 / 3.6)]}, {"highest speed limit"}),
        ({"speed_limits": [SpeedLimit(0.0, 300.0)]}, {"speed limit", "highest speed limit"}),
        ({"gradients": [Gradient(0.0, 0.012)]}, {"steepest gradient"}),
        ({"gradients": [Gradient(0.0, 120.0)]}, {"gradient", "steepest gradient"}),
        ({"curves": [Curve(0.0, 0.8, 0.8)]}, {"radius", "lateral acceleration"}),
        ({"curves": [Curve(0.0, -300.0, 500.0)]}, {"lateral acceleration"}),
        ({"tunnels": [Tunnel(0.0, 100.0, 5.0)]}, {"tunnel cross section"}),
    ],
)
def test_slips_in_lines_stand_out(slip, expected):
    assert warnings(check_track(replace(TRACK, **slip))) == expected


def test_length_in_the_wrong_unit():
    assert warnings(check_track(Track(length_m=12.5, speed_limits=(SpeedLimit(0.0, 30.0),)))) == {"length"}


@pytest.mark.parametrize(("radius_m", "told"), [(math.inf, "1, straight"), (-400.0, "1, tightest 400 m")])
def test_a_line_without_a_bend_has_no_tightest_curve(radius_m, told):
    line = replace(TRACK, curves=(Curve(0.0, math.inf, radius_m),))
    (shown,) = (str(figure) for figure in track_figures(line) if figure.name == "curves")
    assert shown == told


def test_only_the_first_of_many_odd_rows_are_named():
    steep = replace(TRACK, gradients=[Gradient(float(at), 100.0) for at in range(0, 1000, 10)])
    assert sum(check.name.startswith("gradient at") for check in check_track(steep)) == 5


def test_balancing_speed_in_closed_form():
    train = Train(mass_kg=1e5, traction=EffortCurve.from_caps(1e5, 1e6), davis_c_n_per_mps2=8.0, max_speed_mps=100.0)
    assert balancing_speed_mps(train) == pytest.approx((1e6 / 8.0) ** (1 / 3), rel=1e-9)  # P/v = C·v²
    assert balancing_speed_mps(replace(train, max_speed_mps=40.0)) == 40.0


def line_named(review, name):
    return next(line for check, line in review.checks if check.name.startswith(name))


@pytest.mark.parametrize("indent", [1, 4])
def test_lines_of_ttobench_files(tmp_path, indent):
    path = tmp_path / "train.json"
    path.write_text(json.dumps(changed(TTOBENCH_TRAIN, ("max speed", "value"), 4000), indent=indent))
    (review,) = review_file(path)
    rows = path.read_text().splitlines()
    assert '"value": 4000' in rows[line_named(review, "top speed") - 1]
    path.write_text(json.dumps(changed(TTOBENCH_TRACK, ("gradients", "values", 1, 1), 77.0), indent=indent))
    (review,) = review_file(path)
    assert "77.0" in "".join(
        path.read_text().splitlines()[(line := line_named(review, "gradient at 2000")) - 1 : line + 2]
    )


def test_lines_of_a_scenario_and_of_its_references(tmp_path):
    path = tmp_path / "trip.toml"
    path.write_text(SCENARIO)
    train, track = review_file(path)
    rows = SCENARIO.splitlines()
    assert "mass_t" in rows[line_named(train, "mass") - 1]
    assert "speed_limits" in rows[line_named(track, "highest speed limit") - 1]
    path.write_text('\ntrain = "tgv"\n')
    (review,) = review_file(path)
    assert line_named(review, "mass") == 2


def test_lines_of_railtoolkit_and_osrd(shared):
    pytest.importorskip("ruamel.yaml")
    train = shared / "railtoolkit" / "trains" / "local.yaml"
    (review,) = review_file(train)
    assert "rotation_mass: 1.08" in train.read_text().splitlines()[line_named(review, "rotating") - 1]
    path = shared / "railtoolkit" / "paths" / "slope.yaml"
    (review,) = review_file(path)
    assert "20.0" in path.read_text().splitlines()[line_named(review, "steepest") - 1]
    stock = shared / "osrd" / "fast_rolling_stock.json"
    (review,) = review_file(stock)
    assert '"mass": 900000' in stock.read_text().splitlines()[line_named(review, "mass") - 1]


def test_lines_of_railml(tmp_path):
    pytest.importorskip("lxml")
    (tmp_path / "line.xml").write_text(LINE_2.replace('slope="-4.0"', 'slope="-400"'))
    up, down = review_file(tmp_path / "line.xml")
    assert 'slope="-400"' in LINE_2.replace('slope="-4.0"', 'slope="-400"').splitlines()[line_named(up, "gradient") - 1]
    assert line_named(up, "gradient") == line_named(down, "gradient")
    (tmp_path / "stock.xml").write_text(STOCK_2)
    (review,) = review_file(tmp_path / "stock.xml")
    assert "massDependent" in STOCK_2.splitlines()[line_named(review, "rolling resistance") - 1]
    (review,) = review_file(tmp_path / "stock.xml#ic")
    assert line_named(review, "mass") == STOCK_2.splitlines().index('   <formation id="ic" name="IC">') + 1


def test_validate_warns_and_reports_what_is_usual_on_demand(tmp_path, capsys):
    path = write_json(tmp_path / "train.json", changed(TTOBENCH_TRAIN, ("max speed", "unit"), "m/s"))
    assert main(["validate", str(path)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert "    warning  top speed 518.4 km/h (usual 20 to 400: km/h given as m/s?), line 1\n" in out
    assert "    ok  " not in out
    assert main(["validate", "-v", str(path)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert "  plausibility of train toy: " in out
    assert "    ok  " in out
    assert "    warning  top speed 518.4 km/h (usual 20 to 400: km/h given as m/s?), line 1\n" in out
