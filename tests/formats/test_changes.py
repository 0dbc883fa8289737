"""Fields set by their names in the native format: only they change, in their units, and slips are named."""

import math
from dataclasses import replace
from hashlib import sha256

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tgvdp.errors import InputError
from tgvdp.formats import load_track, load_train
from tgvdp.formats.native.changes import changed, fields
from tgvdp.model import catalog

TRAIN, TRACK = load_train("tgv"), load_track("lgv-100km")


@pytest.mark.parametrize("train", [load_train(name) for name in catalog.names("train")], ids=lambda train: train.name)
@given(mass_t=st.floats(1.0, 9e3))
def test_one_field_changes_and_nothing_else(train, mass_t):
    heavy, track, *_ = changed(train, TRACK, [f"train.mass_t={mass_t!r}"])
    assert heavy.mass_kg == mass_t * 1000.0
    assert replace(heavy, mass_kg=train.mass_kg) == train
    assert track is TRACK


def test_units_rows_tables_and_texts():
    train, track, *_ = changed(
        TRAIN,
        TRACK,
        [
            "train.max_speed_kmh = 180",
            "train.name=The heavy one",
            "train.adhesion.adhesive_mass_t=136",
            "track.speed_limits[1].speed_kmh=72",
            "track.stops_m=[0, 5e3, 1e5]",
            "train.braking_rates=[{ from_kmh = 0, deceleration_mps2 = 0.6 }]",
        ],
    )
    assert (train.max_speed_mps, train.name, train.adhesion.adhesive_mass_kg) == (50.0, "The heavy one", 136e3)
    assert track.speed_limits[1].speed_mps == 20.0
    assert track.speed_limits[2:] == TRACK.speed_limits[2:]
    assert track.stops_m == (0.0, 5000.0, 100_000.0)
    assert train.braking_rates == ((0.0, 0.6),)
    assert (train.traction, track.gradients) == (TRAIN.traction, TRACK.gradients)


def test_changes_leave_no_trace_for_later_ones():
    fields = ("train.adhesion.adhesive_mass_t=136", "track.speed_limits[1].speed_kmh=72", "train.mass_t=110%")
    assert changed(TRAIN, TRACK, fields) == changed(TRAIN, TRACK, fields)
    assert changed(TRAIN, TRACK, ["train.mass_t=100%", "track.speed_limits[0].speed_kmh=100%"])[:2] == (TRAIN, TRACK)


@pytest.mark.parametrize(
    ("assignment", "part"),
    [
        ("train.mas_t=2", "train.mas_t: unknown field 'mas_t', did you mean 'mass_t'? (known: mass_t, traction, "),
        ("train.zzz=2", "unknown field 'zzz' (known: mass_t, "),
        ("trian.mass_t=2", "trian: must be train or track, got 'trian', did you mean 'train'?"),
        ("train.mass_t=-2", "train.mass_t: must be a number > 0.0, got -2"),
        ("train.mass_t=2 t", "train.mass_t: must be a number, got '2 t'"),
        ("train.mass_t=nan", "train.mass_t"),
        ("train.mass_t=inf", "train.mass_t: must be a number within ±1e+12, got inf"),
        ("track.speed_limits[0].speed_kmh=1e400", "speed_limits[0].speed_kmh: must be a number within ±1e+12, got inf"),
        ("train.mass_t", "must be train.FIELD=VALUE or track.FIELD=VALUE, got 'train.mass_t'"),
        ("=5", "must be train.FIELD=VALUE"),
        ("train..mass_t=5", "must be train.FIELD=VALUE"),
        ("train.mass_t.x=5", "train.mass_t: holds no fields"),
        ("train.mass_t[0]=5", "train.mass_t: holds no rows"),
        ("train.adhesion.adhesiv_mass_t=5", "train.adhesion: unknown field 'adhesiv_mass_t', did you mean"),
        ("track.speed_limits[99].speed_kmh=5", "track.speed_limits: has rows [0] to ["),
        ("track.length_m=5", "track lgv-100km: speed_limits[1].position must be below the line's length 5 m"),
    ],
)
def test_slips_are_named(assignment, part):
    with pytest.raises(InputError) as error:
        changed(TRAIN, TRACK, [assignment])
    assert str(error.value).startswith("--set: ")
    assert part in str(error.value)


def test_a_share_is_of_what_is_there():
    train, track, *_ = changed(TRAIN, TRACK, ["train.mass_t=110%", "track.speed_limits[1].speed_kmh=50 %"])
    assert train.mass_kg == pytest.approx(1.1 * TRAIN.mass_kg, rel=1e-15)
    assert track.speed_limits[1].speed_mps == pytest.approx(0.5 * TRACK.speed_limits[1].speed_mps, rel=1e-15)
    with pytest.raises(InputError, match=r"--set: train.max_deceleration_mps2: there is no number of which 50% could"):
        changed(replace(TRAIN, max_deceleration_mps2=math.inf), TRACK, ["train.max_deceleration_mps2=50%"])


def test_fields_for_completion():
    assert {"train.mass_t", "train.auxiliary_power_kw", "track.length_m"} <= set(fields())


def test_tables_that_a_field_is_read_from_are_told_with_their_notes(saved):
    table = saved("speed [km/h],effort [kN]\n50,150\n100,200\n", "effort.csv")
    made = changed(TRAIN, TRACK, [f'train.traction={{file="{table}"}}'])
    assert made.train.traction.effort_n(0.0) == 150e3
    assert made.fingerprint == {
        "beside": {"effort.csv": sha256(table.read_bytes()).hexdigest()},
        "notes": ["effort.csv: effort below 50 km/h is taken to be as large as there"],
    }
    assert changed(TRAIN, TRACK, ["train.mass_t=110%"]).fingerprint == {}


def test_tables_of_one_name_are_told_apart_by_their_folders(saved, tmp_path):
    names, digests = {"traction": "old/dc/effort.csv", "braking": "new/dc/effort.csv"}, {}
    for force_kn, name in enumerate(names.values(), start=150):
        (tmp_path / name).parent.mkdir(parents=True)
        table = saved(f"speed [km/h],effort [kN]\n0,{force_kn}\n100,90\n", name)
        digests[name] = sha256(table.read_bytes()).hexdigest()
    made = changed(TRAIN, TRACK, [f'train.{field}={{file="{tmp_path / name}"}}' for field, name in names.items()])
    assert made.fingerprint == {"beside": digests}
    again = changed(TRAIN, TRACK, made.settled)
    assert (again.train, again.track, again.inputs) == (made.train, made.track, {})
