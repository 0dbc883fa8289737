"""The lower hull of known runs in the plane of time and energy: no line of a certificate passes above it."""

import numpy as np
from numpy.typing import NDArray

_Floats = NDArray[np.float64]


def lower_hull(runs: _Floats, time_s: _Floats) -> _Floats:
    """Lower hull of running times and energies of runs, (n, 2), at given times; later ones need no more."""
    hull: list[tuple[float, float]] = []
    for t, e in sorted((float(run[0]), float(run[1])) for run in runs):
        if hull and e >= hull[-1][1]:
            continue
        while len(hull) > 1 and _rises(hull[-2], hull[-1], (t, e)):
            hull.pop()
        hull.append((t, e))
    return np.asarray(np.interp(time_s, *np.array(hull).T))


def _rises(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> bool:
    """Whether b lies on or above the line from a to c."""
    return (b[1] - a[1]) * (c[0] - a[0]) >= (c[1] - a[1]) * (b[0] - a[0])
