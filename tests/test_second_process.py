"""The second process: it works beside the first, dies with it, and its failures cost time and nothing else."""

import os
import subprocess
import sys
import time
import warnings

import pytest

from tgvdp import second_process
from tgvdp.second_process import SecondProcess


@pytest.fixture
def second(monkeypatch):
    monkeypatch.setattr(second_process, "is_of_use", lambda _: True)
    with SecondProcess() as second:
        yield second
    assert second._process is None


def test_work_is_done_in_another_process(second):
    assert second.promise("os:getpid")() != os.getpid()


def test_answers_may_be_taken_in_any_order(second):
    promises = [second.promise("operator:mul", 10, n) for n in range(3)]
    assert [promise() for promise in reversed(promises)] == [20, 10, 0]


def test_loading_says_nothing(second):
    second.load("json", "csv")
    assert second.promise("os:getpid")() != os.getpid()


def test_long_messages_do_not_block_each_other(second):
    promises = [second.promise("builtins:bytes", bytes(8_000_000)) for _ in range(3)]
    assert [len(promise()) for promise in promises] == [8_000_000] * 3


def test_what_is_printed_there_is_no_answer(second):
    second.promise("builtins:print", "noise")()
    assert second.promise("operator:add", 1, 2)() == 3


def test_error_over_there_shows_here(second):
    with pytest.raises(ZeroDivisionError):
        second.promise("operator:truediv", 1, 0)()
    assert second.promise("operator:add", 1, 2)() == 3


@pytest.mark.parametrize("loss", ["before", "between"])
def test_lost_process_is_replaced_by_this_one(second, loss):
    second.load("time")
    process = second._process
    if loss == "between":
        second.promise("time:sleep", 60)
        promise = second.promise("os:getpid")
    process.kill()
    process.wait()
    if loss == "before":
        promise = second.promise("os:getpid")
    assert promise() == os.getpid()
    assert process.poll() is not None


def test_missing_module_is_an_error_here(second):
    with pytest.raises(ImportError):
        second.promise("no_such_module:function")()


def test_warnings_come_over(second):
    with pytest.warns(UserWarning, match="over there"):
        second.promise("warnings:warn", "over there")()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        second.promise("operator:add", 1, 2)()


def test_leaving_does_not_wait_and_leaves_nothing_behind(monkeypatch):
    monkeypatch.setattr(second_process, "is_of_use", lambda _: True)
    started = time.perf_counter()
    with SecondProcess() as second:
        second.promise("time:sleep", 60)
        process = second._process
    assert time.perf_counter() - started < 20.0
    assert process.returncode is not None
    assert process.stdin.closed
    assert process.stdout.closed


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="looks processes up in /proc")
def test_it_ends_when_the_first_one_is_killed():
    program = (
        "import os, signal\n"
        "from tgvdp import second_process\n"
        "second_process.is_of_use = lambda _: True\n"
        "with second_process.SecondProcess() as second:\n"
        "    print(second.promise('os:getpid')(), flush=True)\n"
        "    second.promise('time:sleep', 60)\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    pid = int(done.stdout)
    deadline = time.monotonic() + 20.0
    while os.path.isdir(f"/proc/{pid}") and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not os.path.isdir(f"/proc/{pid}")


@pytest.mark.parametrize("cores", [1, 4])
@pytest.mark.parametrize("drew", [False, True])
def test_it_is_started_where_it_is_of_use(monkeypatch, cores, drew):
    monkeypatch.setattr(second_process, "usable_cores", lambda: cores)
    monkeypatch.setattr(os, "getloadavg", lambda: (0.5, 0.5, 0.5), raising=False)
    monkeypatch.setattr(second_process, "_DRAWING", "sys" if drew else "no_such_module")
    assert second_process.is_of_use(True) == (cores > 1 and not drew)
    assert second_process.is_of_use(False) == (cores > 1)
    monkeypatch.setattr(os, "getloadavg", lambda: (8.0, 8.0, 8.0), raising=False)
    assert not second_process.is_of_use(False)


@pytest.mark.parametrize("executable", ["", "/usr/bin/uwsgi", None])
def test_where_python_is_embedded_none_is_started(monkeypatch, executable):
    monkeypatch.setattr(second_process, "usable_cores", lambda: 4)
    monkeypatch.setattr(os, "getloadavg", lambda: (0.5, 0.5, 0.5), raising=False)
    assert second_process.is_of_use(False)
    monkeypatch.setattr(sys, "executable", executable)
    assert not second_process.is_of_use(False)


def test_nothing_is_started_before_something_is_asked(monkeypatch):
    monkeypatch.setattr(second_process, "is_of_use", lambda _: True)
    with SecondProcess() as second:
        assert second._process is None
    assert second.promise("os:getpid")() == os.getpid()  # nor after the end


def test_without_one_the_work_is_done_here(monkeypatch):
    monkeypatch.setattr(second_process, "is_of_use", lambda _: False)
    with SecondProcess() as second:
        second.load("json")
        assert second.promise("os:getpid")() == os.getpid()
