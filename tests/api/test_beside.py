"""A first search has a second process compile half of what it calls."""

import functools
import threading

import pytest

from tgvdp import cores, second_process
from tgvdp._jit.watch import is_compiled
from tgvdp.api import beside, late
from tgvdp.methods.costate.interpolate import drive
from tgvdp.options.search import SearchOptions
from tgvdp.runs.bends import cut_runs
from tgvdp.runs.measure import measure_runs

pytestmark = pytest.mark.skipif(not is_compiled(), reason="nothing is compiled")


@pytest.fixture
def cold(monkeypatch):
    monkeypatch.setattr(beside, "_is_first", lambda: True)
    monkeypatch.setattr(beside, "is_missing", lambda kernel: True)
    monkeypatch.setattr(cores, "usable_cores", lambda: 2)
    monkeypatch.setattr(second_process, "is_of_use", lambda draws: not draws)


def left():
    return [kernel._cache.wait_for_it for kernel in (measure_runs, cut_runs, drive)]


NOTHING = [None] * 3


def test_half_of_what_a_search_calls_is_left_to_another_process_until_the_search_ends(cold, monkeypatch):
    """Who waits for it compiles the other half."""
    here = []
    for name in ("solving", "pruning"):
        monkeypatch.setattr(late, name, functools.partial(here.append, name))
    with beside.compiling_beside(SearchOptions()):
        for wait, done in zip(left(), ([], ["solving"], ["solving", "pruning"]), strict=True):
            wait()
            assert here == done
    assert left() == NOTHING


def test_a_search_that_fails_takes_it_back(cold):
    with pytest.raises(ZeroDivisionError), beside.compiling_beside(SearchOptions()):
        assert None not in left()
        _ = 1 / 0
    assert left() == NOTHING


def test_only_what_a_search_calls_is_compiled(cold, monkeypatch):
    monkeypatch.setattr(late, "pruning", pytest.fail)
    with beside.compiling_beside(SearchOptions(min_phase_s=0.0)):
        left()[2]()
    with beside.compiling_beside(SearchOptions(method="exact")):
        assert left() == NOTHING


def test_without_another_core_none_is_started(cold):
    with cores.on_one_core(), beside.compiling_beside(SearchOptions()):
        assert left() == NOTHING


def test_where_no_second_process_is_of_use_all_is_compiled_here(cold, monkeypatch):
    monkeypatch.setattr(second_process, "is_of_use", lambda draws: False)
    with beside.compiling_beside(SearchOptions()):
        assert left() == NOTHING


def test_what_is_there_is_compiled_by_nobody(cold, monkeypatch):
    monkeypatch.setattr(beside, "is_missing", lambda kernel: False)
    with beside.compiling_beside(SearchOptions()):
        assert left() == NOTHING


def test_only_the_first_search_of_a_process_asks(monkeypatch):
    monkeypatch.setattr(beside, "_unasked", threading.Lock())
    assert [beside._is_first() for _ in range(3)] == [True, False, False]
