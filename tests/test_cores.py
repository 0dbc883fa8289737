"""Work side by side: in order, with its errors, on several threads or on one."""

import threading
import time
from contextvars import ContextVar

import pytest

from tgvdp import cores


@pytest.fixture(autouse=True)
def two_cores(monkeypatch):
    monkeypatch.setattr(cores, "usable_cores", lambda: 2)


def thread_of(_):
    time.sleep(0.01)  # long enough for the other thread to begin
    return threading.get_ident()


def test_results_come_in_order_and_from_two_threads():
    assert cores.side_by_side(divmod, range(7, 20), range(1, 14)) == list(map(divmod, range(7, 20), range(1, 14)))
    threads = set(cores.side_by_side(thread_of, range(8)))
    assert len(threads) == 2
    assert threading.get_ident() in threads


def test_who_shares_the_machine_works_on_one_core():
    with cores.on_one_core():
        assert set(cores.side_by_side(thread_of, range(8))) == {threading.get_ident()}
    assert len(set(cores.side_by_side(thread_of, range(8)))) == 2


def test_errors_come_through_the_first_of_them():
    with pytest.raises(ZeroDivisionError):
        cores.side_by_side(divmod, [1, 1], [1, 0])

    def fails(wait_s, error):
        time.sleep(wait_s)
        raise error

    for waits_s in ((0.05, 0.0), (0.0, 0.05)):
        with pytest.raises(KeyError):
            cores.side_by_side(fails, waits_s, (KeyError("first"), ValueError("second")))


def test_what_calls_leave_in_their_context_stays_there():
    left = ContextVar("left", default="nothing")
    cores.side_by_side(left.set, "abc")
    assert left.get() == "nothing"
