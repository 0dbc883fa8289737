"""Where no run is sought: the run of a lesser multiplier is nowhere faster than that of a greater one.

What a second costs more adds to what speed is worth everywhere, and the rest of the cost prefers the speeds at both
ends of a cell to rise together (Topkis 1978, for minima on lattices: here of squared speeds at the stations).
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tgvdp.methods.costate.extremal import Extremal
from tgvdp.methods.costate.mesh import Mesh

#: On meshes of fewer cells it takes as long to tell as it saves.
_MANY_CELLS = 100
#: Runs are sought from below a slower one on, by this share of its highest squared speed: that may be of another mesh.
#: A difference, not a share of each speed: a train that coasts from such a share falls below it before it stops.
_BELOW = 0.2
#: A run that comes nearer to these speeds than this share of the highest one may have been kept from what is below.
_NEAR = 0.1


def least_squared_speeds(
    known_on: Mesh, known: Sequence[Extremal], mesh: Mesh, multipliers: Sequence[float]
) -> NDArray[np.float64] | None:
    """Squared speeds at the stations of a mesh below which the runs of multipliers need not be sought.

    Parameters
    ----------
    known_on : Mesh
    known : sequence of Extremal
        Some of that mesh, in the order of their running times.
    mesh : Mesh
    multipliers : sequence of float
        Of which runs are wanted, J/s.

    Returns
    -------
    (m, K + 1) float64 or None
        m²/s²; 0 for a multiplier below all that are known. None where it is not worth it, and where a dynamic brake may
        brake: on steep descents runs part so fast under it that what lies below one decides for many cells.
    """
    if len(mesh.cells.length_m) < _MANY_CELLS or mesh.tables.regeneration > 0.0 or len(known) < 2:
        return None
    falling = -np.array([one.multiplier for one in known])
    asked = -np.array(multipliers)
    # The last one knows none that is slower: its own run stands for that.
    slower = np.minimum(np.searchsorted(falling, asked, side="right"), len(known) - 1)
    least_w = np.array([known[i].passed[:, 0] for i in slower])
    if mesh is not known_on:
        least_w = np.array([np.interp(mesh.cells.station_m, known_on.cells.station_m, w) for w in least_w])
    least_w -= _BELOW * least_w.max(axis=1, keepdims=True)
    least_w[asked > falling[-1]] = 0.0
    return least_w


def held_up(least_w: NDArray[np.float64], found: Sequence[Extremal]) -> list[int]:
    """Numbers of extremals whose runs are next to where none was sought, and might be slower.

    The slower run that was known may be of a mesh whose cells are too long for a place where trains are best slow, as a
    short tunnel; runs that are held up above it would in turn be known as slower ones.

    Parameters
    ----------
    least_w : (m, K + 1) float64
        From where on they were sought, as `least_squared_speeds` says.
    found : sequence of m Extremal
    """
    passed_w = np.array([one.passed[:, 0] for one in found])
    near_w = least_w + _NEAR * least_w.max(axis=1, keepdims=True)
    return np.flatnonzero((passed_w < near_w).any(axis=1)).tolist()
