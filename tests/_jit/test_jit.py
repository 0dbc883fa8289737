"""Kernels and how they are compiled: types, entries, waiting, the clock, and Ctrl-C."""

import inspect
import signal
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from numba.core import config
from numba.core.caching import NullCache

from tgvdp import _jit
from tgvdp._jit import cache
from tgvdp._jit.steps import shortened
from tgvdp._jit.watch import is_compiled, is_missing, leave_to_another, watch
from tgvdp.methods.budget import SearchBudget


def uncached(kernel):
    """The kernel, compiled by every run of the tests: what an earlier run compiled may lie in the cache."""
    if is_compiled():
        kernel._cache = NullCache()
    return kernel


@_jit.leaf
def _power(x, n):
    return x**n


@uncached
@_jit.kernel
def _with_constants(x, n):
    return _power(x, 1) + _power(x, 2) + _power(x, n) + _power(x=x, n=3)


@pytest.mark.skipif(not is_compiled(), reason="nothing is compiled")
def test_constants_do_not_multiply_kernels():
    assert _with_constants(2.0, 4) == 2.0 + 4.0 + 16.0 + 8.0
    if shortened():
        assert len(_power.linked.signatures) == 1


@pytest.mark.skipif(not is_compiled(), reason="nothing is compiled")
def test_entries_tell_numbers_of_another_kind():
    @_jit.entry
    def half(x):
        return x / 2

    assert [half(3.0), half(3.0), half(3), half(5.0)] == [1.5, 1.5, 1.5, 2.5]
    assert [half(3), half(True), half(np.float64(5.0)), half(5.0)] == [1.5, 0.5, 2.5, 2.5]


@pytest.mark.skipif(not is_compiled() or bool(config.BOUNDSCHECK), reason="all calls go the long way")
def test_entries_know_the_machine_code_while_there_is_one():
    @_jit.entry
    def total(rows, x):
        return rows[0].sum() + x

    known = inspect.getclosurevars(total).nonlocals["known"]
    assert total((np.ones(3),), 1.0) == 4.0
    assert list(known) == [(tuple, float)]
    assert total((np.ones(4),), 2.0) == 6.0
    assert total((np.ones(4),), 2) == 6.0  # another set of types, and other machine code
    assert not known


@pytest.mark.skipif(not is_compiled(), reason="nothing is compiled")
def test_what_another_process_compiles_is_waited_for_once(monkeypatch, tmp_path):
    monkeypatch.setattr(cache, "key_folder", lambda: tmp_path)

    @_jit.entry
    def late(x):
        return x[0]

    assert is_missing(late)
    waits, took_s = [], 0.5
    leave_to_another(late, lambda: waits.append(time.sleep(took_s)))
    working_s = _jit.working_s()
    assert late(np.ones(3)) == late(np.ones(3)) == 1.0
    assert len(waits) == 1
    assert _jit.working_s() - working_s < took_s  # as compilation, waiting is no work


def test_threads_wait_for_another_process_together(monkeypatch, tmp_path):
    """One of two compiled what the other one waited for."""
    monkeypatch.setattr(cache, "key_folder", lambda: tmp_path)

    @_jit.entry
    def late(x):
        return x[0]

    done = threading.Event()
    began_early = []
    leave_to_another(late, lambda: (time.sleep(0.3), done.set()))
    with ThreadPoolExecutor(2) as pool, watch(lambda begins: began_early.append(begins and not done.is_set())):
        assert list(pool.map(late, [np.ones(3), np.full(3, 2.0)])) == [1.0, 2.0]
    assert began_early
    assert not any(began_early)


def test_compilation_is_no_part_of_the_working_time():
    @uncached
    @_jit.kernel
    def slow_to_compile(x):
        return x[0]

    started_s, working_s = time.perf_counter(), _jit.working_s()
    clock = SearchBudget(time_limit_s=1e-3).start()
    with watch() as compiled:
        assert slow_to_compile(np.ones(3)) == 1.0
    worked_s, took_s = _jit.working_s() - working_s, time.perf_counter() - started_s
    assert [one.kernel.rpartition(".")[2] for one in compiled] == ["slow_to_compile"]
    assert compiled[0].elapsed_s <= took_s - worked_s
    assert worked_s < 0.5 * took_s
    assert clock.elapsed_s < time.perf_counter() - started_s - 0.5 * took_s


def test_interrupt_during_compilation_comes_right_after_it():
    hold = _jit._InterruptHold()
    steps = []
    with pytest.raises(KeyboardInterrupt), hold:
        with hold:
            steps.append("callee begins")
            signal.raise_signal(signal.SIGINT)
            steps.append("callee ends")
        steps.append("caller ends")
    assert steps == ["callee begins", "callee ends"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_handler_that_goes_on_lets_the_compilation_go_on():
    hold = _jit._InterruptHold()
    seen = []
    before = signal.signal(signal.SIGINT, lambda *_: seen.append("interrupt"))
    try:
        with hold:
            with hold:
                signal.raise_signal(signal.SIGINT)
            seen.append("caller")
            signal.raise_signal(signal.SIGINT)
            seen.append("caller ends")
    finally:
        signal.signal(signal.SIGINT, before)
    assert seen == ["interrupt", "caller", "caller ends", "interrupt"]


def test_threads_leave_signals_alone():
    hold = _jit._InterruptHold()

    def work():
        with hold:
            handlers.append(signal.getsignal(signal.SIGINT))

    handlers = []
    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert handlers == [signal.getsignal(signal.SIGINT)]
