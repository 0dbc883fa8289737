"""What is written reads back as the same thing, or the difference is said."""

import dataclasses
import json
import math
import tomllib
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.format_case import TTOBENCH_TRAIN_14, write_json
from tests.helpers.settings import fuzz
from tgvdp.cli import main
from tgvdp.errors import InputError
from tgvdp.formats import load_scenario
from tgvdp.formats.scenario import Scenario
from tgvdp.formats.syntax.decimals import decimal, in_unit, tidy
from tgvdp.formats.write import TARGETS, scenario_of, write_bytes
from tgvdp.model import catalog
from tgvdp.model.adhesion import Adhesion
from tgvdp.model.effort import EffortCurve, EffortPiece
from tgvdp.model.journey import Journey, TimingPoint
from tgvdp.model.track import SpeedLimit, Track
from tgvdp.model.train import Train
from tgvdp.units import kmh_to_mps, to_si

TRAIN = Train(name="emu", mass_kg=2e5, traction=EffortCurve.from_caps(2e5, 4e6), max_speed_mps=40.0)
TRACK = Track(name="line", length_m=1e4, speed_limits=(SpeedLimit(0.0, 30.0),))
JOURNEY = Journey(
    name="line_1",
    track="line",
    points=(
        TimingPoint(0.0, 0.0, 0.0, 0.0, 0.0),
        TimingPoint(4000.0, 100.0, math.inf, 10.0, 20.0),
        TimingPoint(5000.0),
        TimingPoint(6000.0, 200.0, 220.0, 0.0, 0.0),
        TimingPoint(6000.0, 230.0, 240.0, 0.0, 0.0),
        TimingPoint(1e4, -math.inf, 600.0, 0.0, 0.0),
    ),
)


def read_back(part, target, folder):
    """What a written file holds, and what was said to be lost."""
    written = write_bytes(part, target)
    path = folder / f"file.{'toml' if target == 'toml' else 'json'}"
    path.write_bytes(written.data)
    return load_scenario(path), written.losses


#: One draw for all of an example: thousands of examples of dozens of draws each would take minutes.
DICE = st.integers(0, 2**63).map(Random)


def size(dice, low, high):
    """Number as people write it, with up to four decimals."""
    return dice.randint(int(low * 10_000), int(high * 10_000)) / 10_000


def positions(dice, most, to_m):
    """Increasing positions from 0 m on, below the end of a line."""
    return [0.0, *sorted(one / 10 for one in dice.sample(range(1, 10 * to_m - 1), dice.randrange(most)))]


def effort(dice, forms=("caps", "points", "polynomials")):
    """Curve of one of three forms, from numbers in km/h and kN."""
    form = dice.choice(forms)
    if form == "caps":
        power_kw = dice.choice([math.inf, size(dice, 100, 9000)])
        return EffortCurve.from_caps(size(dice, 10, 900) * 1000, power_kw * 1000)
    speeds_mps = [kmh_to_mps(speed_kmh) for speed_kmh in positions(dice, 6, 300)]
    if form == "points":
        rows = [speed_mps for speed_mps in speeds_mps for _ in range(dice.choice([1, 1, 2]))]
        return EffortCurve.from_points([(speed_mps, size(dice, 1, 900) * 1000) for speed_mps in rows])
    return EffortCurve(
        tuple(
            EffortPiece(speed_mps, 0.0, size(dice, 1e3, 9e5), size(dice, 0, 900) * 3.6, size(dice, 0, 9) * 12.96)
            for speed_mps in speeds_mps
        )
    )


def make_train(dice, forms=("caps", "points", "polynomials"), native=True):
    limits = ("max_acceleration_mps2", "max_deceleration_mps2")
    optional = {name: size(dice, 0.1, 3.0) for name in limits if dice.random() < 0.5}
    if dice.random() < 0.5:
        optional["braking"] = effort(dice, forms)
    optional["tunnel_drag"] = [(size(dice, 20, 60), size(dice, 0, 9) * 12.96)][: dice.randrange(2)]
    if native and dice.random() < 0.5:
        optional["auxiliary_power_w"] = size(dice, 0, 900) * 1000
        speeds_kmh = positions(dice, 4, 300)
        optional["braking_rates"] = [(kmh_to_mps(speed_kmh), size(dice, 0.1, 2)) for speed_kmh in speeds_kmh]
        optional["adhesion"] = Adhesion(size(dice, 0.2, 1) * 1000, dice.choice([None, size(dice, 0.05, 0.4)]))
    return Train(
        name="emu",
        mass_kg=size(dice, 1, 9000) * 1000,
        rotating_mass_factor=1.0 + size(dice, 0, 50) / 100,
        length_m=size(dice, 0, 1000),
        traction=effort(dice, forms),
        friction_brake_n=size(dice, 0, 3000) * 1000,
        davis_a_n=size(dice, 0, 1e5),
        davis_b_n_per_mps=size(dice, 0, 1e3) * 3.6,
        davis_c_n_per_mps2=size(dice, 0, 10) * 12.96,
        max_speed_mps=kmh_to_mps(size(dice, 1, 500)),
        traction_efficiency=size(dice, 1, 100) / 100,
        regeneration_efficiency=size(dice, 0, 100) / 100,
        **optional,
    )


def make_track(dice, native=True):
    def radius_m():
        return dice.choice([math.inf, size(dice, 50, 9999), -size(dice, 50, 9999)])

    def some(row):
        return [(at_m, *row()) for at_m in positions(dice, 6, 10_000)] if dice.random() < 0.7 else ()

    return Track(
        name="line",
        length_m=10_000.0,
        speed_limits=[(at_m, kmh_to_mps(size(dice, 5, 400))) for at_m in positions(dice, 6, 10_000)],
        gradients=some(lambda: [size(dice, -60, 60)]),
        curves=some(lambda: [radius_m(), radius_m()]),
        tunnels=[(5000.0, size(dice, 0, 4000), size(dice, 20, 100))][: dice.randrange(2)],
        neutral_sections=[(5000.0, size(dice, 0, 400), dice.random() < 0.5)][: dice.randrange(2) if native else 0],
        stops_m=[*positions(dice, 4, 10_000), 10_000.0],
        altitude_m=size(dice, -100, 3000),
    )


@pytest.mark.parametrize("target", ["toml", "json"])
def test_native_files_give_back_what_people_write_exactly(tmp_path, target):
    @fuzz()
    @given(DICE)
    def check(dice):
        train, track = make_train(dice), make_track(dice)
        options = dice.choice([{}, {"points": 20, "method": "front", "max_margin_pct": size(dice, 1, 40)}])
        scenario = Scenario(name="trip", format="memory", train=train, track=track, options=options)
        again, losses = read_back(scenario, target, tmp_path)
        assert losses == ()
        assert again.options == options
        assert again.track == track
        assert dataclasses.replace(again.train, traction=train.traction, braking=train.braking) == train

    check()


def test_ttobench_files_give_back_what_people_write_exactly(tmp_path):
    @fuzz()
    @given(DICE)
    def check(dice):
        part = make_train(dice, ["caps"], False) if dice.random() < 0.5 else make_track(dice, False)
        again, losses = read_back(part, "ttobench", tmp_path)
        assert losses == ()
        made = again.train or again.track
        if isinstance(part, Train):
            for name in ("traction", "braking"):
                curve = getattr(part, name)
                if len(curve.pieces) == 1:  # no power limit: written as one that the train never reaches
                    assert getattr(made, name).effort_n(part.max_speed_mps * 0.999) == curve.effort_n(0.0)
                else:
                    assert getattr(made, name) == curve
            made = dataclasses.replace(made, traction=part.traction, braking=part.braking)
        assert made == part

    check()


@given(st.floats(1e-6, 1e9), st.sampled_from(["km/h", "m/s"]))
def test_any_speed_reads_back_to_the_last_bit(value, unit):
    def read(number):
        return to_si(number, unit, "speed")

    assert read(decimal(value, read(1.0), read)) == pytest.approx(value, rel=3e-16)


def test_round_numbers_are_written_as_people_write_them():
    assert decimal(kmh_to_mps(160.0), 1 / 3.6, kmh_to_mps) == 160.0
    assert in_unit([kmh_to_mps(90.0), kmh_to_mps(120.0)], "speed", ("km/h", "m/s")) == ("km/h", [90.0, 120.0])
    assert in_unit([1.7976931348623157], "speed", ("km/h", "m/s"))[0] in ("km/h", "m/s")
    assert json.dumps(tidy({"a": [1.0, 2.5, True, 1e300], "b": "1.0"})) == '{"a": [1, 2.5, true, 1e+300], "b": "1.0"}'


@pytest.mark.parametrize(
    ("kind", "name"), [(kind, name) for kind in ("train", "track") for name in catalog.names(kind)]
)
@pytest.mark.parametrize("target", ["toml", "json"])
def test_catalog_survives(tmp_path, kind, name, target):
    scenario = load_scenario(catalog.path(name, kind))
    again, losses = read_back(scenario, target, tmp_path)
    assert losses == ()
    assert getattr(again, kind) == getattr(scenario, kind)
    assert getattr(again, kind).notes == getattr(scenario, kind).notes


@pytest.mark.parametrize("target", ["toml", "json"])
def test_efforts_that_no_points_hold_exactly_lose_rounding_alone(tmp_path, target):
    """Twelve digits, as people write them, are kept only where they are all there is."""
    random = Random(5)
    for _ in range(20):
        rows = [(5.0 * at, random.uniform(1e5, 4e5) * (1.0 - 0.02 * at)) for at in range(10)]
        train = dataclasses.replace(TRAIN, traction=EffortCurve.from_points(rows))
        again, losses = read_back(scenario_of(train), target, tmp_path)
        assert losses == ()
        for speed_mps, effort_n in rows:
            assert again.train.traction.effort_n(speed_mps) == pytest.approx(effort_n, rel=0, abs=2e-15 * 4e5)


@pytest.mark.parametrize("folder", ["trains", "tracks", "journeys"])
def test_published_files_survive(shared, tmp_path, folder):
    for path in sorted((shared / "ttobench" / folder).glob("*.json")):
        before = load_scenario(path)
        after, losses = read_back(before, "ttobench", tmp_path)
        assert losses == ()
        assert (after.train, after.track, after.journey) == (before.train, before.track, before.journey)


def test_what_does_not_act_is_kept_and_said_to_be_lost(tmp_path):
    path = write_json(tmp_path / "toy.json", TTOBENCH_TRAIN_14)
    train = load_scenario(path)
    again, losses = read_back(train, "ttobench", tmp_path)
    assert losses == ()
    assert (again.train, again.kept) == (train.train, train.kept)
    assert again.kept["train"].keys() == {"num seats", "ETCS braking data"}
    assert read_back(train, "toml", tmp_path)[1] == (
        "train toy: ETCS braking data: not held by this format",
        "train toy: num seats: not held by this format",
    )
    (tmp_path / "trip.toml").write_text('train = "toy.json"\ntrack = "flat-100km"\n')
    out = tmp_path / "out.json"
    assert main(["convert", "--only", "train", str(tmp_path / "trip.toml"), str(out)]) == 0
    assert json.loads(out.read_text())["ETCS braking data"] == TTOBENCH_TRAIN_14["ETCS braking data"]


def test_a_journey_survives(tmp_path):
    again, losses = read_back(JOURNEY, "ttobench", tmp_path)
    assert losses == ()
    assert again.journey == JOURNEY


def test_toml_is_written_for_people():
    text = write_bytes(dataclasses.replace(TRAIN, notes=('a "quoted" note',)), "toml").data.decode()
    assert text.startswith('name = "emu"\n\n[train]\nmass_t = 200\n')
    assert '    "a \\"quoted\\" note",\n' in text
    assert "\n[train.traction]\nforce_kn = 200\npower_kw = 4000\n" in text
    assert tomllib.loads(text)["train"]["max_speed_kmh"] == 144


@pytest.mark.parametrize(
    ("part", "target", "loss"),
    [
        (dataclasses.replace(TRAIN, name="EMU 7"), "ttobench", "train EMU 7: name: 'EMU 7' reads back as 'EMU_7'"),
        (dataclasses.replace(TRACK, stops_m=(4000.0,)), "ttobench",
         "track line: stops_m: (4000.0,) reads back as (0.0, 4000.0, 10000.0)"),
        (dataclasses.replace(JOURNEY, name="morning"), "ttobench",
         "journey morning: name: 'morning' reads back as 'line_morning'"),
        (Scenario(name="trip", format="", train=TRAIN, options={"points": 9}), "ttobench",
         "run option points: not held by this format"),
        (Scenario(name="trip", format="", train=TRAIN, journey=JOURNEY), "toml",
         "journey line_1: not held by this format"),
    ],
)  # fmt: skip
def test_what_a_format_does_not_hold_is_said(tmp_path, part, target, loss):
    assert read_back(part, target, tmp_path)[1] == (loss,)


@pytest.mark.parametrize(
    ("part", "target", "message"),
    [
        (dataclasses.replace(TRAIN, max_speed_mps=math.inf), "toml", "the native format needs a top speed"),
        (dataclasses.replace(TRAIN, max_speed_mps=math.inf), "ttobench", "TTOBench needs a top speed"),
        (dataclasses.replace(TRAIN, rotating_mass_factor=1.6), "ttobench", "factors of 1 to 1.5, got 1.6"),
        (dataclasses.replace(TRAIN, traction=EffortCurve.from_points([(0.0, 2e5), (20.0, 1e5)])), "ttobench",
         "TTOBench holds a force and a power limit, not a curve of 2 pieces"),
        (dataclasses.replace(TRAIN, traction=EffortCurve((EffortPiece(0.0, c0_n=1e5), EffortPiece(5.0, 1e5, 1e4)))),
         "json", "none of force and power, points and polynomials holds its 2 pieces"),
        (Scenario(name="trip", format="", train=TRAIN, track=TRACK), "ttobench",
         "holds one of train, track and journey, got train and track"),
        (JOURNEY, "toml", "the native format holds no journey"),
    ],
)  # fmt: skip
def test_what_a_format_cannot_do_without_is_refused(part, target, message):
    with pytest.raises(InputError, match=message):
        write_bytes(part, target)


def test_every_target_writes_a_train_and_a_track():
    for target in TARGETS:
        for part in (TRAIN, TRACK):
            assert write_bytes(scenario_of(part), target).losses == ()
