"""Pictures of journeys."""

import pytest

import tgvdp
from tests.helpers.journey_case import LINE, METRO
from tgvdp.errors import InputError


@pytest.fixture(scope="module")
def journey():
    return tgvdp.journey(METRO, LINE, points=6)


@pytest.mark.parametrize(
    ("picture", "texts"),
    [
        ("front", ("What does the split of the supplement cost?", "Dearer by (%)")),
        ("time_distance", ("When is the train where?", "Time on the journey's clock (s)")),
        ("profile", ("How to drive?", "Speed (km/h)")),
        ("allocation", ("Who gets the time?", "Supplement (s)")),
        ("price", ("Where would one more minute save most?", "Energy saved per minute (kWh/min)")),
    ],
)
def test_pictures_say_what_they_show(journey, picture, texts):
    figure = journey.plot(picture)
    shown = {text for axes in figure.axes for text in (axes.get_title(loc="left"), axes.get_ylabel())}
    assert set(texts) <= shown


def test_a_picture_of_one_point(journey):
    axes = journey.plot("allocation", 5).axes[0]
    heights = [patch.get_height() for patch in axes.patches[:4]]
    fastest_s = [section.fastest.duration_s for section in journey.sections]
    assert heights == pytest.approx(list(journey.section_time_s[5] - fastest_s))


def test_the_fastest_journey_alone_has_pictures():
    alone = tgvdp.journey(METRO, LINE, at_margin=(0.0,))
    for picture in ("front", "time_distance", "profile", "allocation", "price"):
        alone.plot(picture)


def test_an_unknown_picture(journey):
    with pytest.raises(InputError, match="there is no picture 'map'; there are front, time_distance"):
        journey.plot("map")


def test_files_from_python(journey, tmp_path):
    assert "allocation.csv" in journey.save(tmp_path / "out")
