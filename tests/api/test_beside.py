"""A first search has a second process compile what it calls late."""

import threading

import pytest

from tgvdp import cores, second_process
from tgvdp._jit.watch import is_compiled
from tgvdp.api import beside
from tgvdp.methods.costate.interpolate import drive
from tgvdp.methods.phases.prune import prune_runs
from tgvdp.options.search import SearchOptions

pytestmark = pytest.mark.skipif(not is_compiled(), reason="nothing is compiled")


@pytest.fixture
def cold(monkeypatch):
    monkeypatch.setattr(beside, "_is_first", lambda: True)
    monkeypatch.setattr(beside, "is_missing", lambda kernel: True)
    monkeypatch.setattr(cores, "usable_cores", lambda: 2)
    monkeypatch.setattr(second_process, "is_of_use", lambda draws: not draws)


def left():
    return [kernel._cache.wait_for_it for kernel in (drive, prune_runs)]


def test_what_a_search_calls_late_is_left_to_another_process_until_the_search_ends(cold):
    with beside.compiling_beside(SearchOptions()):
        for wait in left():
            assert wait() is not None  # the kernels that it compiled over there, if any
    assert left() == [None, None]


def test_a_search_that_fails_takes_it_back(cold):
    with pytest.raises(ZeroDivisionError), beside.compiling_beside(SearchOptions()):
        assert None not in left()
        _ = 1 / 0
    assert left() == [None, None]


def test_only_what_a_search_calls_is_left(cold):
    with beside.compiling_beside(SearchOptions(min_phase_s=0.0)):
        assert left()[0] is not None
        assert left()[1] is None
    with beside.compiling_beside(SearchOptions(method="exact")):
        assert left() == [None, None]


def test_without_another_core_none_is_started(cold):
    with cores.on_one_core(), beside.compiling_beside(SearchOptions()):
        assert left() == [None, None]


def test_where_no_second_process_is_of_use_all_is_compiled_here(cold, monkeypatch):
    monkeypatch.setattr(second_process, "is_of_use", lambda draws: False)
    with beside.compiling_beside(SearchOptions()):
        assert left() == [None, None]


def test_what_is_there_is_compiled_by_nobody(cold, monkeypatch):
    monkeypatch.setattr(beside, "is_missing", lambda kernel: False)
    with beside.compiling_beside(SearchOptions()):
        assert left() == [None, None]


def test_only_the_first_search_of_a_process_asks(monkeypatch):
    monkeypatch.setattr(beside, "_unasked", threading.Lock())
    assert [beside._is_first() for _ in range(3)] == [True, False, False]
