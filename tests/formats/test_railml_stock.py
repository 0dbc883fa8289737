"""Trains of railML: how many of them, which propulsion, what turns, and the boxes and units of the schema of 3.2."""

import pytest

from tests.helpers.railml_stock_case import STOCK_2, STOCK_3, STOCK_32
from tests.helpers.refusal import refusal
from tgvdp.formats import load_train
from tgvdp.model.effort import EffortCurve
from tgvdp.model.train import BrakingRate
from tgvdp.units import kmh_to_mps

pytest.importorskip("lxml")


def table(yields, element="brakeEffort"):
    return f"""<{element}><valueTable xValueUnit="km/h" yValueUnit="kN">
      <valueLine xValue="0"><values yValue="{yields}"/></valueLine></valueTable></{element}>"""


def test_train_of_the_schema_of_version_3_2(saved_xml):
    train = load_train(saved_xml(STOCK_32))
    assert (train.name, train.mass_kg, train.length_m) == ("IC", 200_000.0, 72.0)
    assert train.traction.effort_n(kmh_to_mps(30.0)) == 300e3
    for speed_kmh in (48.0, 70.0, 100.0, 160.0):  # constant power above 48 km/h, by chords
        assert train.traction.effort_n(kmh_to_mps(speed_kmh)) == pytest.approx(14.4e6 / speed_kmh, rel=3e-4)
    assert train.braking == EffortCurve.from_points([(0.0, 150e3)])
    assert train.davis_a_n == pytest.approx(2000.0)
    assert train.davis_b_n_per_mps == pytest.approx(10.0 * 3.6)
    assert train.davis_c_n_per_mps2 == pytest.approx(0.3 * 12.96)
    assert (train.max_acceleration_mps2, train.braking_rates) == (0.6, (BrakingRate(0.0, 0.7),))
    assert "no rotating mass is given for loco, coach: taken as none" in train.notes


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("other:kN", "other:kp", "segmentTable: unknown unit 'kp' of force; known: N, kN"),
        ('segmentStartValue="48"', 'segmentStartValue="0"', "[1]@segmentStartValue: the next segmentStartLine must"),
        ('coefficientValue="300"', 'coefficientValue="-300"', "[1]: must be at least 0 kN, got -300 kN at 0 km/h"),
        ('<constantValue coefficientValue="300"/>', "", "[1]: must hold 2 constantValue, as there are exponents"),
        ('exponentValue="-1"', "", "polynomialHeader[2]@exponentValue: missing attribute"),
        ('coefficientValue="0"/>\n       </segmentStartLine>', 'coefficientValue="9"/></segmentStartLine>',
         "segmentStartLine[1]: must be finite, got inf kN at 0 km/h"),
        ("<polynomialHeader", "<header", "segmentTable: missing element polynomialHeader"),
        ("<segmentStartLine ", "<line ", "segmentTable: missing element segmentStartLine"),
    ],
)  # fmt: skip
def test_errors_of_polynomials_name_line_element_and_attribute(saved_xml, old, new, message):
    text = STOCK_32.replace(old, new)
    if old.startswith("<segmentStartLine"):
        text = text.replace("</segmentStartLine>", "</line>")
    assert message in refusal(load_train, saved_xml(text))


def test_a_unit_that_is_missing_is_said(saved_xml):
    train = load_train(saved_xml(STOCK_3.replace(' yValueUnit="N"', "")))
    assert "valueTable in line 12 has no yValueUnit: read as N" in train.notes


def test_a_table_of_points_goes_before_polynomials_of_the_same_effort(saved_xml):
    text = STOCK_32.replace("<tractiveEffort>", table(200, "tractiveEffort")[: -len("</tractiveEffort>")])
    assert load_train(saved_xml(text)).traction == EffortCurve.from_points([(0.0, 200e3)])


def test_effort_of_a_formation_as_a_whole_counts_where_its_vehicles_have_none(saved_xml):
    engine = STOCK_32[STOCK_32.index("<tractiveEffort>") : STOCK_32.index("</tractiveEffort>") + 17]
    whole = STOCK_32.replace(engine, "").replace(
        '<trainEngine maxAcceleration="0.6"/>', f'<trainEngine maxAcceleration="0.6">{engine}</trainEngine>'
    )
    assert load_train(saved_xml(whole)).traction == load_train(saved_xml(STOCK_32)).traction


def test_a_train_of_several_formations_is_that_many_of_each(saved_xml):
    one, two = load_train(saved_xml(STOCK_2)), load_train(
        saved_xml(STOCK_2.replace('<formation id="ic"', '<formation formationCount="2" id="ic"'))
    )  # fmt: skip
    assert (two.mass_kg, two.length_m) == (2 * one.mass_kg, 2 * one.length_m)
    assert two.traction.effort_n(20.0) == 2 * one.traction.effort_n(20.0)
    assert two.resistance_n(20.0) == pytest.approx(2 * one.resistance_n(20.0))
    assert two.rotating_mass_factor == one.rotating_mass_factor
    assert "formationCount 2: the train is 2 such formations, resistance and all" in two.notes
    message = refusal(
        load_train, saved_xml(STOCK_2.replace('<formation id="ic"', '<formation formationCount="0" id="ic"'))
    )
    assert message.endswith("formation@formationCount: must be at least 1 formations, got '0'")


@pytest.mark.parametrize(
    ("given", "factor"),
    [
        ('additionalRotationMass="16"', 1.0 + 2 * 16.0 / 460.0),
        ('rotationMassFactor="1.2"', 1.0 + 2 * 0.2 * 80.0 / 460.0),
        ('rotationMassFactor="1.3" additionalRotationMass="16"', 1.0 + 2 * 16.0 / 460.0),
        ('rotationMassFactor="1.2" additionalRotationMass="0"', 1.0 + 2 * 0.2 * 80.0 / 460.0),
    ],
)
def test_rotating_masses_are_given_in_tonnes_or_by_a_factor(saved_xml, given, factor):
    text = STOCK_2.replace('rotationMassFactor="1.2"', given)
    assert load_train(saved_xml(text)).rotating_mass_factor == pytest.approx(factor)


def test_rotating_masses_of_wagons_count_and_missing_ones_are_said(saved_xml):
    train = load_train(saved_xml(STOCK_2))
    assert "no rotating mass is given for coach: taken as none" in train.notes
    wagon = 'tareWeight="40"><wagon additionalRotationMass="2"/></vehicle>'
    train = load_train(saved_xml(STOCK_2.replace('tareWeight="40"/>', wagon)))
    assert train.rotating_mass_factor == pytest.approx(1.0 + (2 * 0.2 * 80.0 + 6 * 2.0) / 460.0)
    assert not any("no rotating mass" in note for note in train.notes)


def bimode(electric="", diesel="", vehicle=""):
    propulsion = STOCK_2[STOCK_2.index("<propulsion ") : STOCK_2.index("</propulsion>") + 13]
    other = propulsion.replace('id="ac"', 'id="diesel"').replace('yValue="300"', 'yValue="200"')
    both = [one.replace("</propulsion>", f"{brake}</propulsion>") for one, brake in
            ((propulsion, electric), (other, diesel))]  # fmt: skip
    return STOCK_2.replace(propulsion, "".join(both)).replace("</engine>", f"</engine>{vehicle}")


def braking_n(train):
    return train.braking.effort_n(10.0)


def test_the_dynamic_brake_is_that_of_the_chosen_propulsion(saved_xml):
    both = bimode(table(100), table(40))
    assert braking_n(load_train(saved_xml(both, "#ic:ac"))) == 200e3
    assert braking_n(load_train(saved_xml(both, "#ic:diesel"))) == 80e3
    one = bimode(electric=table(100))
    diesel = load_train(saved_xml(one, "#ic:diesel"))
    assert braking_n(diesel) == 0.0
    assert "propulsion ac is not used" in diesel.notes


def test_a_brake_of_the_vehicle_counts_where_the_propulsion_has_none(saved_xml):
    brakes = f"<vehicleBrakes><vehicleBrake>{table(60)}</vehicleBrake></vehicleBrakes>"
    text = bimode(electric=table(100), vehicle=brakes)
    assert braking_n(load_train(saved_xml(text, "#ic:diesel"))) == 120e3
    electric = load_train(saved_xml(text, "#ic:ac"))
    assert braking_n(electric) == 200e3
    assert any("vehicleBrakes" in note for note in electric.notes if note.startswith("not used: "))


def test_specific_resistance_of_a_vehicle_needs_its_own_weight(saved_xml):
    driving = """<drivingResistance><daviesFormula constantFactorA="2" massDependent="true"/></drivingResistance>"""
    start, end = STOCK_2.index("<trainResistance>"), STOCK_2.index("</trainResistance>") + 18
    text = (STOCK_2[:start] + STOCK_2[end:]).replace("</engine>", f"</engine>{driving}")
    text = text.replace('tareWeight="40"/>', f'tareWeight="40">{driving}</vehicle>')
    assert load_train(saved_xml(text, "#ic")).davis_a_n == pytest.approx(2 * 460 * 9.81)
    bare = text.replace('bruttoWeight="50" tareWeight="40"', "").replace(
        "<formation ", '<formation bruttoWeight="460" '
    )
    assert refusal(load_train, saved_xml(bare, "#ic")).endswith(
        "daviesFormula: is in N/kN, and its vehicle has neither bruttoWeight nor tareWeight (t)"
    )


def test_a_train_without_load_says_so(saved_xml):
    empty = load_train(saved_xml(STOCK_2.replace('bruttoWeight="50" ', "")))
    assert empty.mass_kg == 400_000.0
    assert any(note.startswith("tareWeight counts where there is no bruttoWeight") for note in empty.notes)
    assert not any("tareWeight counts" in note for note in load_train(saved_xml(STOCK_2)).notes)


def test_of_several_ways_to_brake_the_weakest_counts_and_says_so(saved_xml):
    several = '<trainBrakes meanDeceleration="1.1"/><trainBrakes meanDeceleration="0.7"/>'
    train = load_train(saved_xml(STOCK_32.replace('<trainBrakes meanDeceleration="0.7"/>', several)))
    assert train.braking_rates == (BrakingRate(0.0, 0.7),)
    assert "full braking is trainBrakes@meanDeceleration, 0.7 m/s², the least of 2" in train.notes


def test_a_vehicle_alone_brakes_as_its_own_brakes_say(saved_xml):
    boxed = '<brakes><vehicleBrakes meanDeceleration="0.9"/></brakes><drivingResistance>'
    assert load_train(saved_xml(STOCK_3.replace("<drivingResistance>", boxed))).braking_rates == (
        BrakingRate(0.0, 0.9),
    )


def test_davis_formula_and_acceleration_as_the_schema_of_2_4_has_them(saved_xml):
    start, end = STOCK_2.index("<trainResistance>"), STOCK_2.index("</trainResistance>") + 18
    given = """<trainResistance tunnelFactor="1.1" daviesFactorA="1.5" daviesFactorB="0.005" daviesFactorC="0.0002"
                 daviesMassDependent="true"/>"""
    text = (STOCK_2[:start] + given + STOCK_2[end:]).replace("maxAcceleration", "trainMaxAcceleration")
    train = load_train(saved_xml(text))
    assert train == load_train(saved_xml(STOCK_2))
    assert train.max_acceleration_mps2 == 0.6
    assert "not used: trainBrakes@brakeType, trainResistance@tunnelFactor" in train.notes[-1]
    either = text.replace('daviesMassDependent="true"', "").replace('"1.5"', '"60"')
    assert refusal(load_train, saved_xml(either)).endswith(
        "trainResistance@daviesMassDependent: missing attribute: 60 may be N or N/kN"
    )


FAMILY = STOCK_2.replace(
    '<vehicle id="coach"', '<vehicle id="two" name="Two" vehicleFamilyRef="loco" bruttoWeight="84"/><vehicle id="coach"'
).replace('vehicleRef="loco" vehicleCount="2"', 'vehicleRef="two" vehicleCount="2"')


def test_a_vehicle_is_as_its_family_in_what_it_does_not_say(saved_xml):
    one, two = load_train(saved_xml(STOCK_2, "#ic")), load_train(saved_xml(FAMILY, "#ic"))
    assert (two.traction, two.length_m, two.max_speed_mps) == (one.traction, one.length_m, one.max_speed_mps)
    assert two.mass_kg == one.mass_kg + 8e3
    assert two.rotating_mass_factor == pytest.approx(1.0 + 2 * 0.2 * 84.0 / 468.0)
    assert "vehicle two is as loco in what it does not say" in two.notes
    newer = load_train(saved_xml(FAMILY.replace("vehicleFamilyRef", "basedOnTemplate"), "#ic"))
    assert newer == two


@pytest.mark.parametrize(
    ("family", "message"),
    [
        ("gone", "vehicle[2]@vehicleFamilyRef: no vehicle 'gone' in this file"),
        ("two", "vehicle[2]@vehicleFamilyRef: is its own family, by way of others or not: 'two'"),
    ],
)
def test_a_family_that_is_none_is_refused(saved_xml, family, message):
    text = FAMILY.replace('vehicleFamilyRef="loco"', f'vehicleFamilyRef="{family}"')
    assert refusal(load_train, saved_xml(text, "#ic")).endswith(message)
