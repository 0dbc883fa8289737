"""Random layered graphs, toy trips, and slow readable twins of the searches on grids."""

import heapq
import itertools

import numpy as np

from tgvdp.methods.grid.layered import layered_graph
from tgvdp.model.effort import EffortCurve
from tgvdp.model.track import Gradient, SpeedLimit, Track
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip

FAR = 1e12


def random_graph(rng, layers=5, width=3, integer=False, density=0.8):
    """A layered graph whose terminal can be reached; integer costs make ties."""
    sizes = [1, *rng.integers(1, width + 1, size=layers - 2), 1]
    first = np.concatenate(([0], np.cumsum(sizes)))
    arcs = []
    for k in range(layers - 1):
        pairs = list(itertools.product(range(sizes[k]), range(sizes[k + 1])))
        kept = [pair for pair in pairs if rng.random() < density]
        kept = kept if (0, 0) in kept else [(0, 0), *kept]
        arcs += [(first[k] + i, first[k + 1] + j) for i, j in kept]
    costs = rng.integers(0, 4, size=(len(arcs), 2)) if integer else rng.random((len(arcs), 2))
    order = rng.permutation(len(arcs))
    source, target = np.array(arcs)[order].T
    return layered_graph(sizes, source, target, *costs.T.astype(float))


def all_paths(graph):
    """Every path from root to terminal as (time, energy, nodes); costs are added from the root forward."""
    paths = []

    def walk(node, time, energy, nodes):
        if node == graph.n_nodes - 1:
            paths.append((time, energy, nodes))
        for arc in range(graph.arc_ptr[node], graph.arc_ptr[node + 1]):
            child = int(graph.arc_to[arc])
            walk(child, time + graph.duration_s[arc], energy + graph.energy_j[arc], (*nodes, child))

    walk(0, 0.0, 0.0, (0,))
    return paths


def front_of(points):
    """Sorted, strictly non-dominated (time, energy) points."""
    front = []
    for time, energy in sorted(points):
        if not front or energy < front[-1][1]:
            front.append((time, energy))
    return front


def brute_front(graph, max_time_s):
    return front_of((time, energy) for time, energy, _ in all_paths(graph) if time <= max_time_s)


def points_of(paths):
    return list(zip(paths.duration_s.tolist(), paths.energy_j.tolist(), strict=True))


def labels_twin(graph, max_time_s):
    """The layered merge without any data structure: all sums into a node, reduced to their front."""
    fronts = {0: [(0.0, 0.0)]}
    for node in range(graph.n_nodes):
        fronts[node] = front_of(fronts.get(node, []))
        for arc in range(graph.arc_ptr[node], graph.arc_ptr[node + 1]):
            sums = [(time + graph.duration_s[arc], energy + graph.energy_j[arc]) for time, energy in fronts[node]]
            fronts.setdefault(int(graph.arc_to[arc]), []).extend(sums)
    return [point for point in fronts[graph.n_nodes - 1] if point[0] <= max_time_s]


def best_first_twin(graph, max_time_s, weight):
    """Best-first search on energy + weight · time with dominance, all paths: sets instead of chained lists."""
    labels = {node: set() for node in range(graph.n_nodes)}
    heap = [(0.0, 0.0, 0.0, 0)]
    while heap:
        _, time, energy, node = heapq.heappop(heap)
        for arc in range(graph.arc_ptr[node], graph.arc_ptr[node + 1]):
            child = int(graph.arc_to[arc])
            t, e = time + graph.duration_s[arc], energy + graph.energy_j[arc]
            if t > max_time_s or any(a <= t and b <= e for a, b in labels[child]):
                continue
            labels[child] = {(a, b) for a, b in labels[child] if a < t or b < e} | {(t, e)}
            heapq.heappush(heap, (e + weight * t, t, e, child))
    return sorted(labels[graph.n_nodes - 1])


def toy_trip(length_m=2.0, limits=((0.0, 1.0),), gradients=(), mass_kg=1.0, force_n=1.0, power_w=0.5, **trip):
    """A unit-mass train on a 2 m line, unless told otherwise."""
    train = Train(
        mass_kg=mass_kg,
        traction=EffortCurve.from_caps(force_n, power_w),
        friction_brake_n=force_n,
        davis_a_n=0.02 * force_n,
        davis_b_n_per_mps=0.02 * force_n,
        davis_c_n_per_mps2=0.05 * force_n,
        name="toy",
    )
    track = Track(
        length_m=length_m,
        speed_limits=tuple(SpeedLimit(*row) for row in limits),
        gradients=tuple(Gradient(*row) for row in gradients),
    )
    return Trip(train=train, track=track, origin_m=0.0, destination_m=length_m, **trip)
