"""Running times that somebody asks for: points of the front, and how long it is."""

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InfeasibleError
from tgvdp.options.search import SearchOptions

#: A point may miss its running time by this much, s, or by this share of the fastest running time on short trips ...
_MET_S, _MET_SHARE = 0.025, 1e-5
#: ... or by this share of the step between two of them.
_MET_STEP = 0.03
#: Who asks for the fastest running time as it is printed gets the fastest run, s, and as a share on short trips.
_PRINTED_S, _PRINTED_SHARE = 0.05, 1e-3
#: Two running times that are nearer, relative to the fastest one, are one.
_SAME_TIME = 1e-7


def margin_of(fastest_s: float, max_margin: float, max_time_s: float | None) -> float:
    """Largest supplement, as a share of the fastest running time."""
    if max_time_s is None:
        return max_margin
    if max_time_s < fastest_s:
        raise InfeasibleError(f"no run takes {max_time_s:.6g} s or less: the fastest one takes {fastest_s:.6g} s")
    return max_time_s / fastest_s - 1.0


def met_to_s(fastest_s: float) -> float:
    """How well running times have to be met that are not close to each other, s."""
    return min(_MET_S, _MET_SHARE * fastest_s)


def asked_targets(fastest_s: float, options: SearchOptions) -> tuple[NDArray[np.float64], float]:
    """Increasing running times that options ask for, s, and how well they have to be met, s.

    Raises
    ------
    InfeasibleError
        When one is shorter than the fastest run.
    """
    near_s = min(_PRINTED_S, _PRINTED_SHARE * fastest_s)
    asked_s = np.array([*options.at_s, *(fastest_s * (1.0 + margin) for margin in options.at_margin)])
    if asked_s.min() < fastest_s - near_s:
        told = f"no run takes {asked_s.min():.7g} s, the fastest one takes {fastest_s:.7g} s"
        raise InfeasibleError(f"{options.owner}: {told}")
    sorted_s = np.unique(np.where(asked_s <= fastest_s + near_s, fastest_s, asked_s))
    target_s = sorted_s[np.diff(sorted_s, prepend=-np.inf) > _SAME_TIME * fastest_s]
    step_s = float(np.diff(target_s).min(initial=np.inf))
    return target_s, min(met_to_s(fastest_s), _MET_STEP * step_s)
