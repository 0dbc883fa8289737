"""Arguments of another kind than is asked for: one line of the project's own error, and before any work is done."""

import math

import pytest

import tgvdp
from tests.helpers.journey_case import LINE, METRO
from tgvdp.errors import InputError

TRAIN = tgvdp.Train(mass_kg=1e5, traction=tgvdp.EffortCurve.from_caps(1e5, 1e6), friction_brake_n=1e5)
TRACK = tgvdp.Track(length_m=1000.0, speed_limits=((0.0, 20.0),))
ENDS = {"origin_m": 0.0, "destination_m": 1000.0}
NO_NUMBERS = (None, "a", [], {}, True, 1 + 2j, object())


@pytest.fixture(scope="module")
def result():
    return tgvdp.search("tgv", "flat-100km", destination_m=2000.0, points=3)


def refused(said, call, *arguments, **named):
    with pytest.raises(InputError) as error:
        call(*arguments, **named)
    assert said in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("value", NO_NUMBERS)
def test_questions_to_a_front(result, value):
    """Each was a TypeError."""
    refused("front: delay must be a number, got", result.front.at_delay, value, 1.0)
    refused("front: saving must be a number, got", result.front.at_saving, value, 1.0)
    refused("front: reference time must be a number, got", result.front.hypervolume, value, 1.0)
    refused("front: reference energy must be finite, got nan", result.front.hypervolume, 1.0, math.nan)


def test_fronts_of_what_is_no_number():
    refused("front: time_s must be numbers, got 'soon'", tgvdp.ParetoFront.of, "soon", [1.0])
    refused("front: energy_j must be numbers, got [{}]", tgvdp.ParetoFront.of, [1.0], [{}])


@pytest.mark.parametrize(
    ("field", "value", "said"),
    [
        ("train", "tgv", "trip: train must be of class Train, got 'tgv'"),
        ("track", "flat-100km", "trip: track must be of class Track, got 'flat-100km'"),
        ("energy", "wheel", "trip: energy must be of class EnergyModel, got 'wheel'"),
        ("convention", "osrd", "trip: convention must be of class Convention, got 'osrd'"),
    ],
)
def test_parts_of_a_trip(field, value, said):
    """A name for a train was an AttributeError somewhere later."""
    refused(said, tgvdp.Trip, **{"train": TRAIN, "track": TRACK, **ENDS, field: value})


@pytest.mark.parametrize("pieces", [None, 3.0, "abc", [1.0], ["abc"], [None]])
def test_pieces_of_an_effort_curve(pieces):
    refused("effort curve: pieces", tgvdp.EffortCurve, pieces)


@pytest.mark.parametrize("path", [None, 3, [], b"run.csv"])
def test_paths_of_records(path):
    refused("expected the path of a recorded run, got", tgvdp.load_run, path)


def test_the_order_of_a_replay(result):
    refused("replay: the order is replay(trip, profile), got <Profile", tgvdp.replay, result.profile(0), result.trip)


def test_pictures(result):
    for picture in ("pie", None, [], 3):
        refused("plot: there is no picture", result.plot, picture)
    refused("plot: certificate must be one of result.certify(), got True", result.plot, certificate=True)


def test_folders_are_refused_before_anything_is_computed(result, tmp_path, monkeypatch):
    """A certificate may take minutes."""
    monkeypatch.setattr(tgvdp.SearchResult, "certify", pytest.fail)
    monkeypatch.setattr(tgvdp.JourneyResult, "verify", pytest.fail)
    (tmp_path / "file").touch()
    for folder, said in (
        (None, "must be a path, got None"),
        ("", "an empty text"),
        (tmp_path / "file", "not a folder"),
    ):
        refused(said, result.save, folder)
        refused(said, tgvdp.journey(METRO, LINE, points=2).save, folder)
