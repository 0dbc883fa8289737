"""The built-in trains and lines: names, files, sources, and that they are what they say."""

import itertools
import math
import tomllib

import pytest

from tgvdp.errors import InputError
from tgvdp.formats import describe_file, input_digest, load_energy_map, load_track, load_train
from tgvdp.model import catalog
from tgvdp.model.energy import violations

EVERY = [(kind, name) for kind in catalog.KINDS for name in catalog.names(kind)]


def test_the_catalog_holds_what_the_documentation_names():
    assert catalog.names("train") == ("alstom-emu", "tgv")
    assert catalog.names("track") == ("flat-100km", "lgv-100km")
    assert catalog.names("map") == ("alstom-map",)
    names = [name for _, name in EVERY]
    assert len(set(names)) == len(names)  # a name alone finds its file


@pytest.mark.parametrize(("kind", "name"), EVERY)
def test_every_entry_loads_under_its_name_and_says_where_it_comes_from(kind, name):
    item = {"train": load_train, "track": load_track, "map": load_energy_map}[kind](name)
    assert item.name == name
    assert item.notes
    assert all(note.split(":")[0] in ("source", "assumed", "uncertain", "synthetic") for note in item.notes)
    assert describe_file(name).kind == kind
    assert len(input_digest(name)) == 64


def test_unknown_names_are_refused():
    with pytest.raises(InputError, match="unknown train 'lgv-100km'; built in: alstom-emu, tgv"):
        catalog.path("lgv-100km", "train")


def test_alstom_emu_has_the_documented_assumptions():
    emu = load_train("alstom-emu")
    assert (emu.mass_kg, emu.rotating_mass_factor, emu.davis_a_n) == (300e3, 1.08, 1770.0)
    assert emu.davis_b_n_per_mps == pytest.approx(35.4, rel=1e-12)
    assert emu.davis_c_n_per_mps2 == pytest.approx(6.6, rel=1e-12)
    assert emu.max_speed_mps * 3.6 == pytest.approx(220.0)
    assert emu.friction_brake_n > 0.0  # the electrodynamic brake alone ends at 1.2 N


def test_tgv_has_the_published_figures_and_can_start_on_the_steepest_ramp():
    tgv = load_train("tgv")
    assert tgv.length_m == 200.19
    assert tgv.max_speed_mps * 3.6 == pytest.approx(320.0)
    assert tgv.traction.effort_n(60.0) * 60.0 == pytest.approx(8.8e6)
    assert tgv.resistance_n(300 / 3.6) == pytest.approx(2700 + 33 * 300 + 0.51 * 300**2)
    steepest = max(row.gradient_permil for row in load_track("lgv-100km").gradients)
    assert tgv.traction.effort_n(0.0) > tgv.davis_a_n + tgv.mass_kg * 9.81 * steepest / 1000
    assert any(note.startswith("uncertain") for note in tgv.notes)


def test_tgv_marks_every_figure_in_its_file():
    lines = catalog.path("tgv", "train").read_text(encoding="utf-8").splitlines()
    figures = [line for line in lines if "=" in line and line[0] not in "#[ n" and "name" not in line]
    assert len(figures) >= 12
    assert all("#" in line for line in figures)


def test_lgv_is_a_100_km_high_speed_line_with_ramps_up_to_35_permil():
    line = load_track("lgv-100km")
    slopes = [row.gradient_permil for row in line.gradients]
    assert line.length_m == 100_000.0
    assert max(row.speed_mps for row in line.speed_limits) * 3.6 == pytest.approx(300.0)
    assert (min(slopes), max(slopes)) == (-35.0, 35.0)
    assert line.speed_limits[0].speed_mps < line.speed_limits[-2].speed_mps  # station approaches are slower
    ends = [*(row.position_m for row in line.gradients[1:]), line.length_m]
    lengths = [end_m - row.position_m for row, end_m in zip(line.gradients, ends, strict=True)]
    heights = itertools.accumulate(length_m * slope / 1000 for length_m, slope in zip(lengths, slopes, strict=True))
    altitudes = [line.altitude_m + height for height in heights]
    assert 100.0 < min(altitudes) < max(altitudes) < 500.0
    assert any(note.startswith("synthetic") for note in line.notes)


def test_alstom_map_is_the_seeds_cost_function_and_covers_its_train_but_for_faint_demands():
    power = load_energy_map("alstom-map")
    for i, speed_mps in enumerate(power.speed_mps):
        for j, demand in enumerate(power.demand):
            share = (1 - math.exp(-3.6 * speed_mps / 220)) * math.tanh(100 * abs(demand)) * (1 - math.exp(-abs(demand)))
            cost_w = 9.8e6 * share / ((1 - math.exp(-1)) ** 2 * math.tanh(100))
            assert power.power_w[i][j] == pytest.approx(cost_w if demand >= 0 else -0.6 * cost_w, abs=60.0)
    found = violations(load_train("alstom-emu"), power)
    assert found
    assert all(one.demand < 0.01 and one.power_w < one.bound_w for one in found)


def test_flat_is_the_seeds_trip_within_the_domain_of_the_emus_polynomials():
    line = load_track("flat-100km")
    assert line.length_m == 100_000.0
    assert line.gradients == ()
    assert line.speed_limits[0].speed_mps == load_train("alstom-emu").max_speed_mps


@pytest.mark.parametrize(("kind", "name"), EVERY)
def test_data_files_are_plain_native_toml(kind, name):
    tree = tomllib.loads(catalog.path(name, kind).read_text(encoding="utf-8"))
    assert set(tree) == {"name", kind}
