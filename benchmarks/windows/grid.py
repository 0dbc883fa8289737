"""All paths of an explicit grid that keep windows of time on their way: labels of time and energy, no multipliers."""

import numpy as np

#: Labels of one node whose times lie in the same step of this length, s, are one: the cheaper of them, as it is.
STEP_S = 0.05


def least_energy_j(grid, windows, arrival_s):
    """Least energy of the paths of a grid that are in windows and arrive by some times, J; infinite where none does.

    Parameters
    ----------
    grid : Grid
    windows : dict of int to (float, float)
        Earliest and latest time, s, by the number of a station.
    arrival_s : (n,) float64
    """
    incoming, graph = grid.incoming, grid.graph
    labels = [(np.zeros(1), np.zeros(1))]
    for station in range(1, len(grid.station_m)):
        first_s, last_s = windows.get(station, (-np.inf, np.inf))
        before = graph.layer_ptr[station - 1]
        following = []
        for node in range(graph.layer_ptr[station], graph.layer_ptr[station + 1]):
            arcs = range(incoming.arc_ptr[node], incoming.arc_ptr[node + 1])
            own = [labels[incoming.arc_from[arc] - before] for arc in arcs]
            time_s = np.concatenate([one[0] + incoming.duration_s[arc] for one, arc in zip(own, arcs, strict=True)])
            energy_j = np.concatenate([one[1] + incoming.energy_j[arc] for one, arc in zip(own, arcs, strict=True)])
            kept = (time_s >= first_s) & (time_s <= last_s) & (time_s <= arrival_s.max())
            following.append(_cheapest(time_s[kept], energy_j[kept] + grid.floor_j[station - 1]))
        labels = following
    time_s, energy_j = labels[0]
    return np.array([energy_j[time_s <= own_s].min(initial=np.inf) for own_s in arrival_s])


def _cheapest(time_s, energy_j):
    """Of all labels in one step of time the cheapest: a later or dearer one may still be the one that is in time."""
    order = np.lexsort((energy_j, np.floor(time_s / STEP_S)))
    first = np.diff(np.floor(time_s / STEP_S)[order], prepend=-np.inf) > 0.0
    return time_s[order[first]], energy_j[order[first]]
