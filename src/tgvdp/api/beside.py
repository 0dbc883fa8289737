"""A second process that compiles what ends a search, while this one compiles what it begins with.

On two cores somebody waits a quarter to a third less for a first front. Nothing depends on it: where it is of no use,
or fails, all is compiled here.
"""

import contextlib
import threading
from collections.abc import Iterator

from tgvdp._jit.watch import is_missing, leave_to_another, take_back
from tgvdp.cores import shares
from tgvdp.methods.phases.prune import prune_runs
from tgvdp.options.search import SearchOptions
from tgvdp.second_process import SecondProcess

#: Free until a search has asked: never released.
_unasked = threading.Lock()


def ends_late(options: SearchOptions) -> bool:
    """Whether a search ends with what ``api.warm.pruning`` calls."""
    return options.method == "front" and options.min_phase_s > 0.0


@contextlib.contextmanager
def compiling_beside(options: SearchOptions) -> Iterator[None]:
    """Have a second process compile what ends a search, where that is missing and this one may use another core.

    Parameters
    ----------
    options : SearchOptions
        Of the search.
    """
    if not (ends_late(options) and shares(2.0, 1.0) > 1 and _is_cold()):
        yield
        return
    with SecondProcess(draws=False) as second:
        done = second.promise("tgvdp.api.warm:ending")
        if second.is_there:
            leave_to_another(prune_runs, done)
        try:
            yield
        finally:
            take_back(prune_runs)


def _is_cold() -> bool:
    """Whether it is missing: the first search of a process asks, and no other, for after one it is there."""
    return _unasked.acquire(blocking=False) and is_missing(prune_runs)
