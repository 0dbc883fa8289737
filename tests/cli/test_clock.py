"""The time limit of a whole command: what its parts may take, and reading that ends by it."""

import math
import re
import signal
import time
from itertools import pairwise

import pytest

from tgvdp.cli import main
from tgvdp.cli.clock import left_s, preparing_within, search_s
from tgvdp.cli.search_case import Case, resolved
from tgvdp.errors import BudgetExceededError
from tgvdp.formats import load_train
from tgvdp.methods.budget import SearchBudget
from tgvdp.model.track import Track
from tgvdp.options.search import SearchOptions

GIVEN_UP = r"leaves no time to search: files and line have taken (\S+) s so far"


def taken_s(error):
    """What an error says that files and line have taken, s."""
    return float(re.search(GIVEN_UP, str(error))[1])


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no alarms on this system")
def test_reading_ends_by_the_clock_and_leaves_no_alarm():
    before = signal.getsignal(signal.SIGALRM)
    with pytest.raises(BudgetExceededError, match=f"of 0.01 s {GIVEN_UP}") as up, preparing_within(0.01):
        while True:
            pass
    assert taken_s(up.value) >= 0.3
    assert signal.getsignal(signal.SIGALRM) is before
    assert signal.getitimer(signal.ITIMER_REAL)[0] == 0.0


def test_reading_without_a_limit_is_left_alone():
    with preparing_within(None):
        assert not hasattr(signal, "setitimer") or signal.getitimer(signal.ITIMER_REAL)[0] == 0.0


def test_parts_leave_time_to_those_after_them():
    clock = SearchBudget(time_limit_s=8.0).start()
    assert search_s(clock, 3) == pytest.approx(5.0, abs=0.1)
    assert left_s(clock, 1) == pytest.approx(7.0, abs=0.1)
    late = SearchBudget(time_limit_s=8.0).start(elapsed_s=9.0)
    assert 0.0 < left_s(late) < 0.01
    assert search_s(late, 3) == 2.0  # a search is what the command is for


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no alarms on this system")
def test_a_line_of_many_transitions_ends_by_the_time_limit():
    radius_m = [math.inf if index % 2 else 500.0 + index % 7 for index in range(20_001)]
    curves = tuple((5.0 * index, *ends) for index, ends in enumerate(pairwise(radius_m)))
    track = Track(length_m=1e5, speed_limits=((0.0, 40.0),), curves=curves)
    case = Case(load_train("tgv"), track, None, {}, {}, {}, ())
    with pytest.raises(BudgetExceededError, match=f"of 1 s {GIVEN_UP}") as up:
        resolved(case, SearchOptions(curves="roeckl", time_limit_s=1.0), elapsed_s=1.0)
    assert taken_s(up.value) >= 1.3


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no alarms on this system")
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_an_alarm_that_a_finalizer_swallows_comes_again():
    class Slow:
        def __del__(self):
            time.sleep(5.0)

    def reading():
        slow = Slow()
        del slow
        time.sleep(60.0)

    with pytest.raises(BudgetExceededError, match=GIVEN_UP), preparing_within(0.2):
        reading()


def test_a_yaml_file_of_many_rows_ends_by_the_time_limit(tmp_path, capsys):
    rows = "\n".join(f"        - [{20 * index}, {index % 9}, 0]" for index in range(20_000))
    path = tmp_path / "long.yaml"
    path.write_text(f"paths:\n  - name: long\n    characteristic_sections:\n{rows}\n", encoding="utf-8")
    assert main(["search", "--track", str(path), "--time-limit", "0.2", "--out", str(tmp_path / "out")]) == 5
    err = capsys.readouterr().err
    assert re.fullmatch(f"tgvdp: error: the time limit of 0.2 s {GIVEN_UP}\n", err)
    assert taken_s(err) >= 0.3
    assert not (tmp_path / "out").exists()
