"""Results in Python and notebooks: pictures, data frames, folders."""

import sys

import numpy as np
import pytest

import tgvdp
from tests.helpers.journey_case import LINE, METRO
from tgvdp.errors import InputError, MissingExtraError
from tgvdp.report.tables import FRONT_COLUMNS


@pytest.fixture(scope="module")
def result():
    return tgvdp.search("tgv", "flat-100km", destination_m=5000.0, points=5)


def test_pictures_by_name(result):
    for name in ("front", "profile", "speed_time", "effort", "price"):
        assert result.plot(name)._repr_png_().startswith(b"\x89PNG")
    assert "bound" in str(
        [text.get_text() for text in result.plot(certificate=result.certify()).axes[0].get_legend().texts]
    )
    (run,) = result.plot_run(2).legends[0].get_texts()
    assert "% time" in run.get_text()
    with pytest.raises(InputError, match="no picture 'pie'"):
        result.plot("pie")


def test_the_point_without_delay_is_the_fastest_run(result):
    assert result.profile(0) is result.fastest.profile
    assert [result.row_count(index) for index in range(5)] == [
        len(result.profile(index).position_m) for index in range(5)
    ]
    alone = tgvdp.search("tgv", "flat-100km", destination_m=5000.0, at_margin=(0.0,)).certify()
    assert alone.complete and alone.gap_pct.tolist() == [0.0]
    assert alone.at(alone.fastest_s) == alone.fastest_j


def test_notebooks_show_a_picture_and_a_table(result):
    page = result._repr_html_()
    assert "data:image/png;base64," in page
    assert page.count("<tr>") == 1 + len(result.front)
    assert "Energy at the wheel (kWh)" in page
    assert len(page) < 100_000


def test_notebooks_show_a_journey_likewise():
    journey = tgvdp.journey(METRO, LINE, points=4)
    page = journey._repr_html_()
    assert "<b>metro on metro line, 6 km</b>: 4 sections, 4 points" in page
    assert "data:image/png;base64," in page
    assert page.count("<tr>") == 1 + len(journey.front)
    assert f'<td style="text-align:right">{journey.front.energy_j[0] / 3.6e6:.3f}' in page
    assert len(page) < 100_000


def test_frames_hold_the_front_and_its_runs(result):
    pytest.importorskip("pandas")
    frame = result.to_pandas()
    assert list(frame.columns) == list(FRONT_COLUMNS[1:7])
    assert frame["time_s"].to_numpy() == pytest.approx(result.front.time_s)
    assert frame["energy_kwh"].to_numpy() == pytest.approx(result.front.energy_j / 3.6e6)
    assert frame["margin_pct"].iloc[0] == 0.0
    run = result.profile_to_pandas(2)
    assert np.array_equal(run["position_m"], result.profile(2).position_m)
    assert run["regime"].tolist() == result.profile(2).regime_names
    assert result.profile_to_pandas(2, every_m=1000.0)["position_m"].tolist() == [
        0.0,
        1000.0,
        2000.0,
        3000.0,
        4000.0,
        5000.0,
    ]


def test_frames_name_the_extra_that_they_need(result, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    for frame in (result.to_pandas, lambda: result.profile_to_pandas(0)):
        with pytest.raises(MissingExtraError, match=r"pandas: pip install 'tgvdp\[tables\]'"):
            frame()


def test_save_writes_the_folder_of_the_command(result, tmp_path):
    names = result.save(tmp_path / "a", certify=False, pictures=["svg"], every_m=500.0)
    assert (
        {path.name for path in (tmp_path / "a").iterdir()} == set(names) >= {"result.json", "front.svg", "profiles.csv"}
    )
    assert len((tmp_path / "a" / "profiles.csv").read_text().splitlines()) == 1 + 6 * 11
