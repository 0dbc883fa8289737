"""What a search is told about its result: nothing that is less than was asked for goes without a word."""

import numpy as np

from tgvdp.api.methods import warnings_of
from tgvdp.methods.costate.front import OptimalRuns


def found(energy_j):
    time_s = 100.0 + np.arange(len(energy_j))
    energy_j = np.array(energy_j)
    return OptimalRuns(time_s, energy_j, np.ones_like(time_s), True, False, {}, [])


def test_runs_that_cost_more_than_a_faster_one_are_named():
    """They are dropped from the front: on a train whose effort has a dip 3 of 30 were, in silence."""
    (warning,) = warnings_of(found([9.0, 5.0, 6.0, 5.5, 4.0]))
    assert warning.startswith("runs that were found for 102 s, 103 s cost more than a faster one")
    (net,) = warnings_of(found([1.0, -5.0, -4.0, -6.0]))
    assert "102 s cost" in net


def test_rounding_errors_are_no_dearer_runs():
    assert warnings_of(found([9.0, 5.0, 5.0001, 4.0])) == ()
    assert warnings_of(found([9.0])) == warnings_of(found([])) == ()
