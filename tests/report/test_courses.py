"""Speed profiles as driving courses."""

import csv
import io

import pytest

from tests.helpers.report_case import PROVENANCE, VERDICT, make_result, railway_trip
from tgvdp.cli.search_options import PICTURE_FORMATS, PROFILE_FORMATS
from tgvdp.report import write_results
from tgvdp.report.courses import COURSE_COLUMNS, driving_course_csv
from tgvdp.report.pictures import PICTURE_FORMATS as DRAWN
from tgvdp.report.profiles import choose_runs
from tgvdp.report.results import TABLE_FORMATS


@pytest.fixture(scope="module")
def result():
    return make_result(railway_trip(), [24.0, 20.0])


def test_driving_course_splits_the_resistance(result):
    rows = list(csv.DictReader(io.StringIO(driving_course_csv(result, choose_runs(result)))))
    assert tuple(rows[0]) == COURSE_COLUMNS
    train, run = result.trip.train, result.fastest.profile
    mine = [row for row in rows if row["id"] == "fastest"]
    assert [float(row["s"]) for row in mine] == pytest.approx(run.position_m)
    assert [float(row["t"]) for row in mine] == pytest.approx(run.time_s)
    assert mine[-1]["driving_mode"] == "standstill"
    weight_n = train.mass_kg * 9.81
    for row in mine[:-1]:
        assert float(row["R_traction"]) == pytest.approx(train.davis_a_n)  # this train has no other term
        permil = 0.0 if float(row["s"]) < 2000 else 10.0 if float(row["s"]) < 3000 else -5.0
        assert float(row["R_path"]) == pytest.approx(weight_n * permil / 1000, abs=1e-6 * weight_n)
        assert (float(row["R_path"]) == 0.0) == (permil == 0.0)  # no rounding where the line is level
        assert float(row["F_R"]) == pytest.approx(float(row["R_path"]) + float(row["R_traction"]), abs=1e-3)


def test_formats_of_the_command_line_are_those_that_are_written(result, tmp_path):
    assert (TABLE_FORMATS, DRAWN) == (PROFILE_FORMATS, PICTURE_FORMATS)
    write_results(result, tmp_path, PROVENANCE, [VERDICT] * 2, profiles="railtoolkit")
    assert (tmp_path / "driving_course.csv").read_text() == driving_course_csv(result, choose_runs(result))
    assert not (tmp_path / "profiles.csv").exists()
