"""Paths of OSRD as lines: units, boundaries with and without the ends, what may be absent, what is refused."""

import pytest

from tests.helpers.format_case import changed, write_json
from tests.helpers.osrd_case import OSRD_PATH
from tgvdp.errors import InputError
from tgvdp.formats import describe_file, load_track, load_train
from tgvdp.formats.review.plausibility import review_file
from tgvdp.model.track import Curve, Gradient, NeutralSection, Place, SpeedLimit

INF = float("inf")


def track_of(tmp_path, tree, **options):
    return load_track(write_json(tmp_path / "path.json", tree), **options)


def test_operational_points_that_have_names_are_places(tmp_path):
    points = [{"id": "a", "position": 0, "extensions": {"identifier": {"name": "Aston", "uic": 1}}},
              {"id": "b", "position": 5_000_000, "extensions": {"sncf": None}}]  # fmt: skip
    track = track_of(tmp_path, changed(OSRD_PATH, ["path_properties", "operational_points"], points))
    assert track.places == (Place(0.0, "Aston"),)


def test_line_in_si(tmp_path):
    track = track_of(tmp_path, OSRD_PATH)
    assert (track.name, track.length_m) == ("A to C", 10_000.0)
    assert track.speed_limits == (SpeedLimit(0.0, 20.0), SpeedLimit(1000.0, 40.0), SpeedLimit(7000.0, 30.0))
    assert track.gradients == (Gradient(0.0, 0.0), Gradient(2000.0, 12.5), Gradient(6000.0, -4.0))
    assert track.curves == (Curve(0.0, INF, INF), Curve(3000.0, -800.0, -800.0), Curve(3500.0, INF, INF))
    assert track.neutral_sections == (NeutralSection(4000.0, 200.0, False), NeutralSection(4200.0, 300.0, True))
    assert track.stops_m == (0.0, 5000.0, 10_000.0)  # the junction is passed
    assert track.notes == (
        "limits are OSRD's most restrictive speed profile: the simulated train's top speed and length are in it",
        "electrified with 1500V, 25000V: the train's mode is not chosen by it",
    )


def test_boundaries_may_hold_the_ends_and_values_bare_speeds(tmp_path):
    ends = changed(OSRD_PATH, ("mrsp",), {"boundaries": [0, 1_000_000, 7_000_000, 10_000_000], "values": [20, 40, 30]})
    assert track_of(tmp_path, ends) == track_of(tmp_path, OSRD_PATH)


def test_whole_answers_say_length_and_limits(tmp_path):
    bare = {"path_properties": {}, "name": "x"}
    mrsp = OSRD_PATH["mrsp"]
    simulated = {"status": "success", "mrsp": mrsp, "base": {}, "final_output": {"positions": [0, 10_000_000]}}
    found = {"status": "success", "length": 10_000_000, "blocks": [], "path_item_positions": [0, 10_000_000]}
    expected = track_of(tmp_path, bare | {"mrsp": mrsp, "length": 10_000_000})
    assert track_of(tmp_path, bare | {"simulation": simulated}) == expected
    assert track_of(tmp_path, bare | {"mrsp": mrsp, "pathfinding": found}) == expected
    assert expected.notes[-1] == "not in the file: slopes, curves, electrifications"
    assert (expected.gradients, expected.curves, expected.stops_m) == ((), (), (0.0, 10_000.0))


def test_equal_neighbours_are_one_row(tmp_path):
    tree = changed(OSRD_PATH, ("path_properties", "slopes"), {"boundaries": [1, 2], "values": [3, 3, 4]})
    assert track_of(tmp_path, tree).gradients == (Gradient(0.0, 3.0), Gradient(0.002, 4.0))


def test_without_limits_a_line_speed_runs(tmp_path):
    tree = changed(OSRD_PATH, ("mrsp",), ...)
    with pytest.raises(InputError, match=r"path\.json: no speed limits: missing field 'mrsp'; --line-speed KMH"):
        track_of(tmp_path, tree)
    track = track_of(tmp_path, tree, line_speed_mps=25.0)
    assert track.speed_limits == (SpeedLimit(0.0, 25.0),)
    assert track.notes[0] == "no mrsp: limit is the line speed asked for, 90 km/h"


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("length",), ..., "missing field 'length' (mm), and neither pathfinding nor simulation gives it"),
        (("path_properties",), ..., "missing field 'path_properties'"),
        (("lenght",), 1, "unknown field 'lenght', did you mean 'length'?"),
        (("mrsp", "boundaries"), [1], "mrsp: must hold one value more than boundaries, got 3 and 1"),
        (("mrsp", "boundaries"), [0, 1, 2, 9_000_000], "mrsp.boundaries: must reach from 0 to 10000000 mm, got 9"),
        (("mrsp", "boundaries"), [2000, 1000], "mrsp.boundaries must increase, got 1000 mm after 2000 mm"),
        (("mrsp", "boundaries"), [2000, 10_000_000], "mrsp.boundaries must lie before the path's end, 10000000 mm"),
        (("mrsp", "values", 0, "speed"), 0, "mrsp.values[0].speed: must be a number in m/s > 0.0, got 0 m/s"),
        (("mrsp", "boundaries", 0), -1, "mrsp.boundaries[0]: must be a number in mm >= 0.0, got -1 mm"),
        (("length",), -1, "length: must be a number in mm > 0.0, got -1 mm"),
        (("path_properties", "slopes", "values", 1), "steep",
         "path_properties.slopes.values[1]: must be a number in ‰, got 'steep'"),
        (("simulation",), {"status": "pathfinding_failed"}, "simulation.status: must be 'success', got 'pathfinding_f"),
        (("simulation",), {"mrsp": {"boundaries": [], "values": [{"speed": 9}]}},
         "mrsp and simulation.mrsp differ: keep one of the two"),
        (("pathfinding",), {"length": 9_000_000},
         "length is 10000000 mm, and pathfinding.length 9000000 mm: answers about different paths?"),
        (("simulation",), {"final_output": {"positions": [0, 9]}},
         "length is 10000000 mm, and the end of simulation.final_output.positions 9 mm: answers about"),
        (("path_properties", "electrifications", "values", 1, "type"), "neutral",
         "path_properties.electrifications: type must be one of electrification, neutral_section, non_electr"),
        (("path_properties", "electrifications", "values", 1), {"type": "neutral_section", "lower_pantographs": True},
         "path_properties.electrifications.values[1]: unknown field 'lower_pantographs', did you mean"),
        (("path_properties", "operational_points"), [{"position": 0}, {"position": 1_000_000_000}],
         "path_properties.operational_points[1].position must not lie behind the path's end, 10000000 mm, got 10"),
        (("path_properties",), {"slope": {"boundaries": [], "values": [5.0]}},
         "path_properties: unknown field 'slope', did you mean 'slopes'?"),
    ],
    ids=lambda value: str(value)[:40],
)  # fmt: skip
def test_bad_files(tmp_path, path, value, message):
    file = write_json(tmp_path / "path.json", changed(OSRD_PATH, path, value))
    with pytest.raises(InputError) as caught:
        load_track(file)
    assert str(caught.value).startswith(f"{file}: {message}")


def test_it_is_described_and_reviewed_as_a_line_and_is_no_train(tmp_path):
    file = write_json(tmp_path / "path.json", OSRD_PATH)
    described = describe_file(file)
    assert (described.kind, described.format) == ("track", "OSRD path")
    assert "speed limits 3, 72 to 144 km/h" in described.headline
    assert "neutral 2, together 500 m" in described.headline
    assert [review.kind for review in review_file(file)] == ["track"]
    with pytest.raises(InputError, match="holds an OSRD path track, not a train"):
        load_train(file)


def test_an_infrastructure_is_named_as_such(tmp_path):
    file = write_json(tmp_path / "infra.json", {"version": "3.4", "track_sections": [], "routes": [], "switches": []})
    with pytest.raises(InputError, match=r"infra\.json: is an OSRD infrastructure, of which no line is read: ask OSRD"):
        load_track(file)
