"""The shortened steps of compilation give what numba's own give, to the bit."""

import math
import os
import re
import subprocess
import sys

import numpy as np
import pytest

from tgvdp import load_train
from tgvdp._jit import leaf, loop, part
from tgvdp._jit.steps import shortened
from tgvdp._jit.watch import is_compiled
from tgvdp.errors import InputError
from tgvdp.physics.cell import Cell, room_for_rows
from tgvdp.physics.codes import TRACTION
from tgvdp.physics.forces import kernel_train
from tgvdp.physics.march import march

PROGRAM = """
import numpy as np
from tgvdp import load_train, replay
from tgvdp.certificate.line import BoundingProblem
from tgvdp.model.track import Gradient, SpeedLimit, Track
from tgvdp.model.trip import Trip
from tgvdp.runs.profile import profile_of

track = Track(length_m=5e3, speed_limits=(SpeedLimit(0.0, 30.0),), gradients=(Gradient(0.0, 2.0), Gradient(2e3, -7.0)))
trip = Trip(train=load_train("alstom-emu"), track=track, origin_m=0.0, destination_m=5e3)
x_m = np.array([0.0, 300.0, 700.0, 2000.0, 3500.0, 4300.0, 5000.0])
profile = profile_of(trip, x_m, np.array([0.0, 180.0, 400.0, 420.0, 400.0, 250.0, 0.0]))
verdict = replay(trip, profile)
rows = profile.position_m, profile.speed_mps**2
bounds = [BoundingProblem(trip).line(*rows, 3e4, gain_j=gain_j) for gain_j in (np.inf, 1e3)]
numbers = (profile.duration_s, *profile.balance, *vars(verdict).values(), *bounds)
print(*(float(number).hex() for number in numbers))
"""


def numbers(pipeline):
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        env=os.environ | {"TGVDP_PIPELINE": pipeline},
        capture_output=True,
        text=True,
        timeout=600,
        check=True,
    )
    return done.stdout.split()


@pytest.mark.slow
@pytest.mark.skipif(not is_compiled() or not shortened(), reason="compiled by numba's own steps alone")
def test_shortened_steps_change_no_bit():
    short = numbers("short")
    assert len(short) > 10
    assert short == numbers("plain")
    assert short == numbers("plain")  # loaded from the cache now, beside the runtime that their machine code calls


@pytest.mark.skipif(not is_compiled() or not shortened(), reason="compiled by numba's own steps alone")
def test_what_a_kernel_calls_is_its_own():
    from tgvdp._jit.pipeline import compiled_and_linked

    def twice(train, cell, rows):
        on, back = (
            march(train, TRACTION, 1.0, cell, 9.0, 4.0, 9.0, rows, 0),
            march(train, TRACTION, -1.0, cell, 9.0, 4.0, 1.0, rows, 0),
        )
        return on[1] - back[1]

    kernel, _ = compiled_and_linked(twice)
    cell = Cell(0.0, 9.0, 9.0, 0.0, 1.0, math.inf)
    assert kernel(kernel_train(load_train("alstom-emu")), cell, room_for_rows(100, "test")) > 0.0
    (code,) = kernel.inspect_llvm().values()
    assert "define internal" in code
    assert "linkonce_odr" not in code


@part
def _squared(x):
    return x * x


@leaf
def _squared_twice(x):
    return _squared(_squared(x))


@pytest.mark.skipif(not is_compiled() or not shortened(), reason="compiled by numba's own steps alone")
def test_what_a_leaf_calls_is_no_leaf_itself(monkeypatch):
    """numba hands on what a caller is compiled with: all that leaves call was inlined, eleven times over."""
    from tgvdp._jit import optimise
    from tgvdp._jit.pipeline import compiled_and_linked

    monkeypatch.setattr(optimise, "_SMALL", 0)  # small functions are inlined as well

    def of_both(x):
        return _squared_twice(x) + _squared(x)

    kernel, _ = compiled_and_linked(of_both)
    assert kernel(2.0) == 20.0
    assert not _is_inlined(_squared)
    assert _is_inlined(_squared_twice)


@part
def _halved_twice(x):
    return 0.5 * (0.5 * x)


@part
def _quartered(x):
    return _halved_twice(x)


@leaf
def _added(x):
    return x + _halved_twice(x)


@pytest.mark.skipif(not is_compiled() or not shortened(), reason="compiled by numba's own steps alone")
def test_what_is_called_from_one_place_alone_is_inlined(monkeypatch):
    from tgvdp._jit import optimise
    from tgvdp._jit.pipeline import compiled_and_linked

    monkeypatch.setattr(optimise, "_SMALL", 0)  # small functions are inlined as well

    def once(x):
        return _quartered(x)

    def twice(x):
        return _added(x) + _added(2.0 * x)  # what a leaf calls is called from wherever that is

    for function, calls in ((once, 0), (twice, 1)):
        kernel, _ = compiled_and_linked(function)
        assert kernel(4.0) == function(4.0)
        (code,) = kernel.inspect_llvm().values()
        assert len(re.findall(r"^define internal .*_halved_twice", code, flags=re.MULTILINE)) == calls
        assert not re.search(r"^define internal .*_quartered", code, flags=re.MULTILINE)


@loop
def _square_all(x, y):
    for i in range(x.shape[0]):
        y[i] = math.sqrt(_squared_twice(x[i])) / 3.0


@pytest.mark.skipif(not is_compiled() or not shortened(), reason="compiled by numba's own steps alone")
@pytest.mark.parametrize("count", [0, 1, 7, 64])
def test_a_loop_runs_in_vector_registers(count):
    from tgvdp._jit.pipeline import compiled_and_linked

    def of_all(x, y):
        _square_all(x, y)
        return x.shape[0]

    kernel, _ = compiled_and_linked(of_all)
    x, y = np.linspace(-2.0, 3.0, count + 2)[:count], np.full(count + 1, -7.0)
    assert kernel(x, y[:count]) == count
    assert y[:count].tolist() == [math.sqrt((one * one) * (one * one)) / 3.0 for one in x.tolist()]
    assert y[count] == -7.0
    (code,) = kernel.inspect_llvm().values()
    assert re.search(r"fdiv <\d+ x double>", code)


def _is_inlined(function):
    """Whether LLVM is told to inline a function wherever it is called."""
    (result,) = function.linked.overloads.values()
    (code,) = (one for one in result.library._final_module.functions if one.name == result.fndesc.llvm_func_name)
    return any(b"alwaysinline" in attributes for attributes in code.attributes)


def test_unknown_steps_are_refused(monkeypatch):
    monkeypatch.setenv("TGVDP_PIPELINE", "fast")
    shortened.cache_clear()
    try:
        with pytest.raises(InputError, match=r"TGVDP_PIPELINE: must be 'short' or 'plain', got 'fast'"):
            shortened()
    finally:
        shortened.cache_clear()


@pytest.mark.parametrize(
    ("version", "short"), [("0.68.1", True), ("0.62.0", True), ("0.61.2", False), ("1.0.0", False)]
)
def test_only_tested_versions_use_the_shortened_steps(monkeypatch, version, short):
    monkeypatch.delenv("TGVDP_PIPELINE", raising=False)
    monkeypatch.setattr("numba.__version__", version)
    shortened.cache_clear()
    try:
        assert shortened() is short
    finally:
        shortened.cache_clear()
