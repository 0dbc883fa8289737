"""One declaration per option: the signature, the command line, the run table and the checks agree with it."""

import inspect
import pickle

import click
import pytest

import tgvdp
from tgvdp.cli.search import command
from tgvdp.constants import METHODS
from tgvdp.errors import ArgumentError, InputError
from tgvdp.formats.native.specs import RunSpec
from tgvdp.options.option import Option
from tgvdp.options.search import BY_FIELD, OPTIONS, SearchOptions, arguments_of, excluded_by
from tgvdp.options.texts import parse_quantity

DECLARED = {one.argument: one for one in OPTIONS}


def test_the_signature_of_search_is_the_declaration():
    parameters = list(inspect.signature(tgvdp.search).parameters.values())
    assert [one.name for one in parameters[:2]] == ["train", "track"]
    assert {one.name: one.default for one in parameters[2:]} == {one.argument: one.default for one in OPTIONS}
    assert [one.name for one in parameters[2:]] == list(SearchOptions().as_dict())
    assert all(one.kind is inspect.Parameter.KEYWORD_ONLY for one in parameters[2:])


def test_every_argument_reaches_the_options(monkeypatch):
    seen = []
    monkeypatch.setattr("tgvdp.api.run.run_search", lambda train, track, options: seen.append(options))
    train, track = tgvdp.load_train("tgv"), tgvdp.load_track("flat-100km")
    for one in OPTIONS:
        value = other_than_default(one)
        method = {} if one.argument == "method" else {"method": one.methods[0]}
        tgvdp.search(train, track, **(method | {one.argument: value}))
        assert getattr(seen[-1], one.argument) == value


def other_than_default(one):
    """A legal value that is not the default."""
    if one.choices:
        return one.choices[-1]
    if one.kind is bool:
        return not one.default
    if one.rows is not None:
        return ((1.0, 2.0, 3.0),)
    return (0.5,) if one.kind is tuple else 7 if one.kind is int else 7.5


def test_the_command_line_offers_every_option_by_its_name_in_files():
    offered = {one.name: one for one in command.params if isinstance(one, click.Option)}
    assert set(BY_FIELD) <= set(offered)
    for field, one in BY_FIELD.items():
        assert offered[field].opts == [one.flag]
        assert offered[field].heading == one.heading
        assert offered[field].default in (None, click.core.UNSET if hasattr(click.core, "UNSET") else None)
        assert one.help or one.summary


def test_the_run_table_has_every_option():
    assert RunSpec.__struct_fields__ == tuple(BY_FIELD)


@pytest.mark.parametrize("one", [one for one in OPTIONS if one.above is not None or one.at_least is not None])
def test_ranges_end_where_the_declaration_says(one):
    edge = one.at_least if one.above is None else one.above
    inside, outside = (edge + 1, edge - 1) if one.above is None else (edge + 1, edge)
    for value, legal in ((inside, True), (outside, False), (edge, one.above is None)):
        (argument,) = one.arguments(value).values() if one.read is None else (value,)
        argument = (argument,) if one.kind is tuple else argument
        if legal:
            one.check(argument)
            continue
        with pytest.raises(InputError, match=f"search: {one.argument} must be"):
            one.check(argument)


@pytest.mark.parametrize(
    ("argument", "value"),
    [
        ("points", 5.5),
        ("points", "5"),
        ("points", True),
        ("method", "guess"),
        ("method", None),
        ("dominance", 1),
        ("origin_m", None),
        ("origin_m", float("inf")),
        ("at_s", {1.0: 2.0}),
        ("max_margin", float("nan")),
    ],
)
def test_values_of_another_kind_are_refused(argument, value):
    with pytest.raises(InputError, match=f"search: {argument} must be"):
        SearchOptions(**{argument: value})


@pytest.mark.parametrize(
    ("values", "argument", "reason"),
    [
        ({"points": 1}, "points", "must be at least 2, got 1"),
        ({"method": "guess"}, "method", "must be one of front, exact, best-first, got 'guess'"),
        ({"at_s": (5.0,), "points": 7}, "points", "has no effect beside at_s"),
        ({"method": "exact", "paths": 7}, "paths", "belongs to method best-first, it has no effect on exact"),
        ({"at_s": (5.0,), "points": 7, "max_margin": 0.5}, "max_margin", "has no effect beside at_s, nor has points"),
        ({"points": 7, "speeds": 9, "paths": 3, "segment_m": 50.0}, "paths",
         "belongs to method best-first, it has no effect on front, nor have segment_m, speeds"),
        ({"speed_restrictions": ((1.0, 2.0),)}, "speed_restrictions[0]",
         "must be (from_m, to_m, speed_mps), got 2 values"),
    ],
)  # fmt: skip
def test_errors_hold_the_argument_and_the_reason_also_in_another_process(values, argument, reason):
    with pytest.raises(ArgumentError) as caught:
        SearchOptions(**values)
    error = pickle.loads(pickle.dumps(caught.value))
    assert (error.owner, error.argument, error.reason) == ("search", argument, reason)
    assert str(error) == f"search: {argument} {reason}"


def test_values_are_kept_as_their_kind():
    options = SearchOptions(points=5.0, origin_m=3, time_limit_s=float("inf"), at_s=())
    assert (options.points, type(options.points), type(options.origin_m)) == (5, int, float)


@pytest.mark.parametrize("one", [one for one in OPTIONS if one.methods != METHODS])
def test_an_option_belongs_to_its_methods(one):
    for method in METHODS:
        asked = {"method": method, one.argument: other_than_default(one)}
        if method in one.methods:
            SearchOptions(**asked)
        else:
            with pytest.raises(InputError, match=f"{one.argument} belongs to method"):
                SearchOptions(**asked)


def test_exclusions():
    assert [other.field for other in excluded_by(BY_FIELD["at"])] == ["points", "max_margin_pct"]
    with pytest.raises(InputError, match="search: max_margin has no effect beside at_s"):
        SearchOptions(at_s=(5.0,), points=7, max_margin=0.5)


def test_values_of_people_become_arguments():
    values = {"from_m": 10.0, "end_speed_kmh": 90.0, "max_margin_pct": 7.0, "at": "5%,30s", "tunnels": True}
    assert arguments_of(values) == {
        "origin_m": 10.0,
        "end_speed_mps": 25.0,
        "max_margin": 0.07,
        "at_margin": (0.05,),
        "at_s": (30.0,),
        "tunnels": True,
    }


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("20km", "m", 20_000.0),
        ("41.5 km", "m", 41_500.0),
        ("-1e2m", "m", -100.0),
        ("12", "m", 12.0),
        ("10m/s", "km/h", 36.0),
        ("5%", "%", 5.0),
        ("2min", "s", 120.0),
        ("0.5h", "s", 1800.0),
    ],
)
def test_quantities(text, unit, value):
    assert parse_quantity(text, unit) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["", "km", "12 s", "12 KM", "1 2 km", "0x10", "1e", "km12", "12km/h"])
def test_what_is_no_length(text):
    with pytest.raises(InputError, match="must be a number of m"):
        parse_quantity(text, "m")


def test_names_follow_the_unit():
    one = Option(argument="wind_mps", name="head-wind", unit="km/h", kind=float, default=0.0, help="Wind.")
    assert (one.flag, one.field, one.arguments(36.0)) == ("--head-wind", "head_wind_kmh", {"wind_mps": 10.0})
    assert one.summary == "Wind.  [default: 0]"
