"""Random windows between stops on random lines: against all paths of a grid, and against a bound that knows them."""

import numpy as np
import pytest

from benchmarks.windows.case import Case
from benchmarks.windows.study import judged

#: On the second a second before the point would cost nothing, and the program took without end.
FEW, MORE = (0, 1, 2), range(20, 27)
#: What a timetable is met to, s.
MET_S = 0.1
#: Half of the fronts are nearer to their bounds than this, %.
NEAR_PCT = 0.1


def check(seeds):
    rows = [judged(seed) for seed in seeds]
    found = [row for row in rows if not row["refused"]]
    assert found
    assert all("it is missed by" in row["refused"] and not row["grid_keeps"] for row in rows if row["refused"])
    assert all(row["missed_s"] <= MET_S for row in found)
    assert all(row["above_grid_pct"] <= 0.1 for row in found if row["above_grid_pct"] is not None)
    assert not any(row["not_ok"] or row["below_bound"] for row in found)
    assert np.median([row["median_gap_pct"] for row in found if row["median_gap_pct"] is not None]) < NEAR_PCT


def test_random_windows():
    check(FEW)


def test_the_thriftiest_journey_is_one_point():
    """For each arrival it is solved anew, and its times differ by how well they are met."""
    journey = Case(21).journey()
    assert any("the front ends with the thriftiest journey" in text for text in journey.warnings)
    assert (np.diff(journey.front.time_s) > MET_S).all()


def test_the_thriftiest_journey_runs_on_until_that_saves_nothing():
    """In one piece it may run longer than its parts at the speeds that they share: these end at 170.7 s."""
    journey = Case(335).journey()
    assert any("the front ends with the thriftiest journey, 175.9" in text for text in journey.warnings)
    assert journey.found.multiplier_j_per_s[-1, -1] == pytest.approx(0.0, abs=1.0)


def test_late_windows_are_kept():
    """Nothing is saved by running so long: a second costs less than nothing."""
    rows = [judged(seed, late=True) for seed in (2, 12)]
    assert not any(row["refused"] or row["not_ok"] or row["below_bound"] for row in rows)
    assert all(row["missed_s"] <= MET_S and row["above_grid_pct"] <= 0.1 for row in rows)


@pytest.mark.slow
def test_more_random_windows():
    check(MORE)
