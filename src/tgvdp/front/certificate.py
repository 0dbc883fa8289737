"""Certificate."""
from dataclasses import dataclass
import numpy as np
from tgvdp.constants import GRAVITY_MPS2
from tgvdp.front import bounds, costates
from tgvdp.line.cells import cells_of
from tgvdp.physics.forces import kernel_train

@dataclass(frozen=True)
class Bound:
    lower_bound_j: float
    gap_pct: float

def _run(trip, profile, price):
    train = kernel_train(trip.train)
    x = profile.position_m - trip.origin_m
    w = profile.speed_mps**2
    # the profile's own rounding must not move the trip's ends
    longest = trip.distance_m / costates._CELLS_PER_TRIP
    count = costates.count_cells(x, w, longest)
    nx, nw, row = np.empty(count+1), np.empty(count+1), np.empty(count, np.int64)
    n = costates.cut_rows(x, w, longest, nx, nw, row)
    assert n == count, (n, count)
    c = cells_of(trip)
    i = np.searchsorted(c.station_m, 0.5*(x[:-1]+x[1:]), side='right') - 1
    i = np.clip(i, 0, len(c.length_m)-1)[row]
    grade, air, cap = c.grade_n[i], c.air[i], c.limit_w[i]
    length = np.diff(nx)
    effort = profile.force_n[row]
    size = 2*max(len(train.traction), len(train.braking))+2
    pull, brake = np.empty((size,6)), np.empty((size,6))
    label = np.empty(count, np.int8); source = np.zeros((count,3)); growth=np.zeros((count,3))
    price = price/train.inertia_kg
    costates.label_cells(train, length, grade, air, cap, nw, effort, price, pull, brake, label, source, growth)
    costates.tidy_labels(length, nw, cap, label, source, growth)
    left, right = np.zeros(count), np.zeros(count)
    costates.integrate_costates(length, nw, cap, effort/train.inertia_kg, price, label, source, growth, left, right, np.empty(count+1), np.empty(count+1))
    bound = np.empty(count)
    total, error = bounds.bound_kernel(train, length, grade, air, cap, price, nw[0], nw[-1], left, right, pull, brake, bound)
    return dict(locals())

def certify(trip, profile, price_j_per_s):
    r = _run(trip, profile, price_j_per_s)
    m = trip.train.inertia_kg
    lb = m*(r['total']-r['error']) - price_j_per_s*profile.duration_s
    e = profile.total_energy_j
    return Bound(lb, 100*(e-lb)/e)
