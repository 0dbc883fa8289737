"""The other direction, temporary speed restrictions, wind: against what they mean at each point of the line."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tgvdp
from tgvdp.errors import InputError
from tgvdp.model.track import Curve, Gradient, NeutralSection, Place, SpeedLimit, SpeedRestriction, Track, Tunnel
from tgvdp.model.variants import named_track, restricted_track, reversed_track, train_in_wind

LENGTH = st.floats(1.0, 1e6)
SHARES = st.lists(st.integers(1, 999), min_size=0, max_size=6, unique=True).map(sorted)


@st.composite
def tracks(draw):
    length_m = draw(LENGTH)

    def rows(make):
        return tuple(make(share / 1000 * length_m) for share in (0, *draw(SHARES)))

    def stretches(make):
        edges = draw(SHARES)
        pairs = zip(edges[::2], edges[1::2], strict=False)
        return tuple(make(a / 1000 * length_m, (b - a) / 1000 * length_m) for a, b in pairs)

    radius = st.sampled_from([math.inf, 300.0, -450.0, 2000.0])
    return Track(
        length_m=length_m,
        speed_limits=rows(lambda x: SpeedLimit(x, draw(st.floats(5.0, 90.0)))),
        gradients=rows(lambda x: Gradient(x, draw(st.floats(-40.0, 40.0)))),
        curves=rows(lambda x: Curve(x, draw(radius), draw(radius))),
        stops_m=tuple(share / 1000 * length_m for share in draw(SHARES)),
        tunnels=stretches(lambda x, length: Tunnel(x, length, 60.0)),
        neutral_sections=stretches(lambda x, length: NeutralSection(x, length, draw(st.booleans()))),
        altitude_m=draw(st.floats(-100.0, 3000.0)),
        name="line",
    )


def numbers(track):
    """All numbers of a track, field by field."""
    return {
        name: np.array(getattr(track, name), dtype=float)
        for name in ("length_m", "altitude_m", "speed_limits", "gradients", "curves", "stops_m", "tunnels",
                     "neutral_sections")
    }  # fmt: skip


@given(tracks())
def test_reversed_twice_is_the_same_line(track):
    once = reversed_track(track)
    twice = reversed_track(once)
    assert (once.name, twice.name) == ("line reversed", "line")
    for name, values in numbers(track).items():
        np.testing.assert_allclose(numbers(twice)[name], values, rtol=1e-9, atol=1e-9 * track.length_m, err_msg=name)


def held(rows, position_m):
    return [row for row in rows if row.position_m <= position_m][-1]


@given(tracks(), st.floats(0.0003, 0.9997))
def test_a_reversed_line_is_the_same_at_every_point(track, share):
    here_m = share * track.length_m
    if any(abs(row[0] - here_m) < 1e-6 * track.length_m for row in (*track.speed_limits, *track.gradients)):
        return
    there_m = track.length_m - here_m
    other = reversed_track(track)
    assert held(other.speed_limits, there_m).speed_mps == held(track.speed_limits, here_m).speed_mps
    assert held(other.gradients, there_m).gradient_permil == -held(track.gradients, here_m).gradient_permil


def test_curves_turn_to_the_other_side_and_stretches_keep_their_length():
    track = Track(
        length_m=1000.0,
        speed_limits=((0.0, 20.0),),
        gradients=((0.0, 10.0), (400.0, 0.0)),
        curves=((0.0, math.inf, 300.0), (200.0, 300.0, 400.0)),
        stops_m=(0.0, 300.0, 1000.0),
        tunnels=((100.0, 50.0, 40.0),),
        neutral_sections=((900.0, 20.0, True),),
        altitude_m=100.0,
    )
    other = reversed_track(track)
    assert other.curves == ((0.0, -400.0, -300.0), (800.0, -300.0, math.inf))
    assert other.tunnels == ((850.0, 50.0, 40.0),)
    assert other.neutral_sections == ((80.0, 20.0, True),)
    assert other.stops_m == (0.0, 700.0, 1000.0)
    assert other.gradients == ((0.0, 0.0), (600.0, -10.0))
    assert other.altitude_m == pytest.approx(104.0)


def test_names_of_others_fill_in_where_a_line_has_none():
    track = replace(tgvdp.load_track("flat-100km"), places=(Place(0.0, "A"), Place(9e3, "C")))
    named = named_track(track, (Place(0.0, "Aston"), Place(5e3, "B"), Place(100e3, "D")))
    assert named.places == ((0.0, "A"), (5e3, "B"), (9e3, "C"), (100e3, "D"))
    assert named_track(track, (Place(0.0, "Aston"), Place(101e3, "E"))) is track


@given(tracks(), st.lists(st.tuples(st.floats(0, 0.9), st.floats(0.01, 0.1), st.floats(1.0, 80.0)), max_size=4))
def test_a_restricted_line_has_the_lowest_of_all_limits_everywhere(track, drawn):
    length_m = track.length_m
    rows = [SpeedRestriction(a * length_m, (a + d) * length_m, v) for a, d, v in drawn]
    lowered = restricted_track(track, rows)
    for x in np.linspace(0.0, length_m, 97)[:-1]:
        expected = min([held(track.speed_limits, x).speed_mps, *(v for a, b, v in rows if a <= x < b)])
        assert held(lowered.speed_limits, x).speed_mps == expected
    assert replace(lowered, speed_limits=track.speed_limits) == track


def test_no_restriction_and_one_above_the_limit_change_nothing():
    track = tgvdp.load_track("lgv-100km")
    assert restricted_track(track, ()) == restricted_track(track, [SpeedRestriction(0.0, 5e4, 200.0)]) == track


@pytest.mark.parametrize(
    ("row", "part"),
    [((5.0, 5.0, 10.0), "to must be above 5 m"), ((-1.0, 5.0, 10.0), "from must be at least 0"),
     ((0.0, 1e6, 10.0), "within the line's 100000 m, got 1000000 m"), ((0.0, 5.0, 0.0), "speed must be above 0 m/s")],
)  # fmt: skip
def test_restrictions_off_the_line_are_refused(row, part):
    with pytest.raises(InputError, match=part):
        restricted_track(tgvdp.load_track("flat-100km"), [SpeedRestriction(*row)])


@pytest.mark.parametrize("wind_mps", [-5.0, 0.0, 3.0, 25.0])
def test_air_meets_the_train_at_the_sum_of_both_speeds(wind_mps):
    train = tgvdp.load_train("tgv")
    blown = train_in_wind(train, wind_mps)
    for v in np.linspace(0.0, 90.0, 19):
        a, b, c = train.davis_a_n, train.davis_b_n_per_mps, train.davis_c_n_per_mps2
        assert blown.resistance_n(v) == pytest.approx(a + b * v + c * (v + wind_mps) ** 2, rel=1e-12)


def test_a_tail_wind_that_davis_coefficients_cannot_hold_is_refused():
    train = tgvdp.load_train("tgv")
    most_mps = train.davis_b_n_per_mps / (2.0 * train.davis_c_n_per_mps2)
    assert train_in_wind(train, -most_mps * (1 - 1e-12)).davis_b_n_per_mps == pytest.approx(0.0, abs=1e-6)
    with pytest.raises(InputError, match=r"tail wind of 36 km/h .* allow 32.35 km/h at most"):
        train_in_wind(train, -10.0)


def test_the_search_runs_on_the_variant():
    train, track = tgvdp.load_train("tgv"), tgvdp.load_track("lgv-100km")
    asked = {"points": 3, "origin_m": 2e4, "destination_m": 4e4}
    rows = [(25e3, 26e3, 30.0)]
    result = tgvdp.search(train, track, reverse=True, speed_restrictions=rows, wind_mps=5.0, **asked)
    line = restricted_track(reversed_track(track), [SpeedRestriction(*rows[0])])
    same = tgvdp.search(train_in_wind(train, 5.0), line, **asked)
    assert (result.front.energy_j == same.front.energy_j).all()
    assert (result.trip.track, result.trip.train) == (line, train_in_wind(train, 5.0))
    assert result.options["reverse"] is True
    plain = tgvdp.search(train, track, **asked)
    for one in ({"reverse": True}, {"speed_restrictions": rows}, {"wind_mps": 5.0}):
        assert tgvdp.search(train, track, **one, **asked).fastest.energy_j != plain.fastest.energy_j


def test_a_level_line_is_the_same_in_both_directions():
    asked = {"points": 4, "destination_m": 20e3}
    there, back = (
        tgvdp.search(
            "alstom-emu", replace(tgvdp.load_track("flat-100km"), length_m=20e3, stops_m=()), reverse=r, **asked
        )
        for r in (False, True)
    )
    np.testing.assert_allclose(there.front.energy_j, back.front.energy_j, rtol=1e-12)


def test_wind_does_not_blow_in_tunnels_that_count():
    track = replace(tgvdp.load_track("flat-100km"), tunnels=((1e3, 500.0, 60.0),))
    with pytest.raises(InputError, match="wind does not blow in the tunnels"):
        tgvdp.search("tgv", track, wind_mps=5.0, tunnels=True)


def test_names_and_paths_stand_for_trains_and_lines(tmp_path):
    asked = {"points": 3, "destination_m": 3000.0}
    named = tgvdp.search("tgv", "flat-100km", **asked)
    made = tgvdp.search(tgvdp.load_train("tgv"), tgvdp.load_track("flat-100km"), **asked)
    assert (named.front.energy_j == made.front.energy_j).all()
    file = tmp_path / "trip.toml"
    file.write_text('train = "tgv"\ntrack = "flat-100km"\n')
    assert tgvdp.search(file, str(file), **asked).trip == named.trip


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (("tvg", "flat-100km"), "unknown train 'tvg', did you mean 'tgv'"),
        (("flat-100km", "tgv"), "'flat-100km' is a track, not a train"),
        (
            (tgvdp.load_track("flat-100km"), tgvdp.load_train("tgv")),
            r"train is a Track: the order is search\(train, track",
        ),
        (("tgv", tgvdp.load_train("tgv")), "track is a Train: the order is"),
        ((5, "flat-100km"), "train must be a Train, a name of the catalog or a path, got 5"),
        (("tgv", None), "track must be a Track, a name of the catalog or a path, got None"),
    ],
)
def test_what_is_no_train_or_line_is_said(arguments, part):
    with pytest.raises(InputError, match=part):
        tgvdp.search(*arguments)
