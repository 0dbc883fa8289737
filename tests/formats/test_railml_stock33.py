"""Trains of railML 3.3, whose schema has other names than 3.2, and what they and those of 2.x draw and brake with."""

from itertools import pairwise

import pytest

from tests.helpers.railml_stock_case import STOCK_2, STOCK_33
from tests.helpers.refusal import refusal
from tgvdp.formats import load_train
from tgvdp.model.effort import EffortCurve
from tgvdp.model.train import BrakingRate
from tgvdp.units import kmh_to_mps

pytest.importorskip("lxml")

ORDER = '<rail3:trainOrder orderNumber="1" vehicleRef="loco"/><rail3:trainOrder orderNumber="2" vehicleRef="coach"/>'
EFFORTS = STOCK_33[STOCK_33.index("<rail3:details>") : STOCK_33.index("</rail3:details>") + 16]
WHOLE = STOCK_33[STOCK_33.index("<rail3:tractionMode") : STOCK_33.index("</rail3:tractionMode>") + 21]
RATES = """<rail3:decelerationTable>
 <rail3:valueTable xValueName="speed" xValueUnit="km/h" yValueName="deceleration" yValueUnit="m/s/s">
  <rail3:valueLine xValue="0"><rail3:value yValue="0.9"/></rail3:valueLine>
  <rail3:valueLine xValue="60"><rail3:value yValue="0.9"/></rail3:valueLine>
  <rail3:valueLine xValue="120"><rail3:value yValue="0.6"/></rail3:valueLine>
 </rail3:valueTable></rail3:decelerationTable></rail3:formation>"""


def test_train_of_the_schema_of_version_3_3(saved_xml):
    train = load_train(saved_xml(STOCK_33))
    assert (train.name, train.mass_kg, train.length_m, train.max_speed_mps) == ("IC", 180e3, 46.0, kmh_to_mps(140.0))
    assert train.rotating_mass_factor == pytest.approx(1.0 + 0.15 * 130.0 / 180.0)
    points = [(kmh_to_mps(v), f) for v, f in ((0.0, 270e3), (40.0, 200e3), (120.0, 66e3))]
    assert train.traction == EffortCurve.from_points(points)
    assert train.davis_a_n == 3800.0
    assert train.davis_b_n_per_mps == pytest.approx(45.0 * 3.6)
    assert train.davis_c_n_per_mps2 == pytest.approx(2.5 * 12.96)
    assert train.braking_rates == (BrakingRate(0.0, 0.8),)


def test_effort_of_the_whole_formation_is_a_cap_of_force_and_power(saved_xml):
    text = STOCK_33.replace(EFFORTS, "")
    of_vehicle, of_whole = load_train(saved_xml(text)), load_train(
        saved_xml(text.replace('<rail3:info maxTractiveEffort="250000" tractivePower="2400000"/>', ""))
    )  # fmt: skip
    assert of_vehicle.traction == EffortCurve.from_caps(250e3, 2.4e6)
    assert of_whole.traction == EffortCurve.from_caps(270e3, 2.42e6)
    assert " tractionMode," in of_vehicle.notes[-1]
    assert " tractionMode," not in of_whole.notes[-1]


def test_a_formation_may_describe_itself_without_vehicles(saved_xml):
    alone = STOCK_33.replace(ORDER, "").replace('length="46" ', "")
    train = load_train(saved_xml(alone, "#ic"))
    assert (train.mass_kg, train.traction) == (180e3, EffortCurve.from_caps(270e3, 2.42e6))
    assert "no length, and no trainOrder names vehicles: taken as 0 m" in train.notes
    for old, new, message in (
        ('bruttoWeight="180" ', "", "@bruttoWeight: missing attribute (t), and so is tareWeight, and no trainOrder"),
        ('speed="140" bruttoWeight="180"', 'bruttoWeight="180"', "@speed: missing attribute (km/h), and no trainOrder"),
        (WHOLE, "", "formation: no vehicle has a tractiveEffort table"),
    ):
        assert message in refusal(load_train, saved_xml(alone.replace(old, new), "#ic"))


def test_a_table_of_decelerations_brakes_in_steps_below_it(saved_xml):
    train = load_train(saved_xml(STOCK_33.replace("</rail3:formation>", RATES)))
    rates = train.braking_rates
    assert rates[:2] == (BrakingRate(0.0, 0.9), BrakingRate(kmh_to_mps(60.0), pytest.approx(0.9 - 0.3 / 17)))
    assert rates[-1] == BrakingRate(kmh_to_mps(120.0), 0.6)
    for (from_mps, rate), (to_mps, _) in pairwise(rates[1:]):
        line = [0.9 - 0.3 * (v - kmh_to_mps(60.0)) / kmh_to_mps(60.0) for v in (from_mps, to_mps)]
        assert line[1] == pytest.approx(rate)
        assert line[0] < 1.031 * rate
    assert "full braking is decelerationTable, in steps below it" in train.notes
    assert any("trainBrakes@meanDeceleration" in note for note in train.notes if note.startswith("not used"))
    message = refusal(load_train, saved_xml(STOCK_33.replace("</rail3:formation>", RATES.replace('"0.6"', '"0"'))))
    assert message.endswith("valueTable: decelerations must be above 0 m/s², got 0 m/s²")
    unit = refusal(load_train, saved_xml(STOCK_33.replace("</rail3:formation>", RATES.replace("m/s/s", "g"))))
    assert unit.endswith("valueTable: unknown unit 'g' of acceleration; known: m/s^2")


def with_caps(attributes, text=STOCK_2):
    return text.replace('totalTractEfficiency="0.85"', f'totalTractEfficiency="0.85" {attributes}')


def test_largest_effort_and_power_of_the_brake_make_a_dynamic_brake(saved_xml):
    train = load_train(saved_xml(with_caps('maxBrakeEffort="100000" maxBrakePower="3e6" totalBrakeEfficiency="0.8"')))
    assert train.braking == EffortCurve.from_caps(200e3, 6e6)
    assert (train.traction_efficiency, train.regeneration_efficiency) == (0.85, 0.8)
    caps = (
        'power="1e6" totalTractEfficiency="0.85" maxBrakeEffort="50000" maxBrakePower="1e6" totalBrakeEfficiency="0.7"'
    )
    coach = f'tareWeight="40"><engine><propulsion {caps}/></engine></vehicle>'
    both = with_caps('maxBrakeEffort="1e5" maxBrakePower="3e6" totalBrakeEfficiency="0.8"')
    mixed = load_train(saved_xml(both.replace('tareWeight="40"/>', coach)))
    assert mixed.regeneration_efficiency == 0.7
    assert "totalBrakeEfficiency 0.7 is the least of 2" in mixed.notes
    half = load_train(saved_xml(with_caps('maxBrakeEffort="100000" totalBrakeEfficiency="0.8"')))
    assert half.braking == EffortCurve.from_caps(0.0)
    assert half.regeneration_efficiency == 0.0
    assert any("propulsion@maxBrakeEffort" in note for note in half.notes if note.startswith("not used"))


def test_auxiliaries_of_all_vehicles_draw_power(saved_xml):
    coach = 'tareWeight="40"><wagon auxiliaryPowerConsumption="30000"/></vehicle>'
    text = STOCK_2.replace('tareWeight="40"/>', coach)
    text = text.replace("<tractiveEffort>", '<auxiliarySupply power="50000"/><tractiveEffort>')
    assert load_train(saved_xml(text)).auxiliary_power_w == 2 * 50e3 + 6 * 30e3


def test_caps_of_different_shape_are_summed_by_chords(saved_xml):
    caps = """<engine><propulsion power="1000000" maxTractEffort="100000" totalTractEfficiency="0.85"/></engine>"""
    text = STOCK_2.replace('tareWeight="40"/>', f'tareWeight="40">{caps}</vehicle>')
    one, both = load_train(saved_xml(STOCK_2)), load_train(saved_xml(text))
    for speed_mps in (0.0, 5.0, 11.3, 25.0, 38.0):
        more_n = 6.0 * min(100e3, 1e6 / max(speed_mps, 1.0))
        assert both.traction.effort_n(speed_mps) == pytest.approx(one.traction.effort_n(speed_mps) + more_n, rel=2e-4)
