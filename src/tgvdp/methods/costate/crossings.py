"""Where the costate polyline crosses its levels: the switching speeds of a policy at a station."""

from tgvdp._jit import part
from tgvdp.methods.costate.blend import LINES
from tgvdp.methods.costate.brake_jumps import begun_costate
from tgvdp.methods.costate.polyline import insert


@part
def crossing(level, line, n, first):
    """Where the polyline crosses a level, from ``first`` on: first index above it, and w there.

    Its two ends are vertical walls.
    """
    w, p = line
    i = first
    while i < n and p[i] < level:
        i += 1
    if i == first:
        return i, w[i]
    if i == n:
        return n, w[n - 1]
    share = (level - p[i - 1]) / (p[i] - p[i - 1])
    return i, w[i - 1] + share * (w[i] - w[i - 1])


@part
def braking_points(train, returned, step, line, n, drives, rises, policy):
    """Make the squared speeds at which dynamic braking begins points of the polyline, and enter them in the policy.

    Where the brake ``rises`` with speed it may be in two: in an interval, and from a speed above that on. Its lower end
    may be where the brake begins, and p jumps. Returns the number of points, the indices of the ends of the interval,
    which are one where there is none, and that from which on runs brake.
    """
    level = -0.5 * returned
    brakes_w = train.brakes_from_mps * train.brakes_from_mps
    above = drives
    while above < n - 1 and line.w[above] < brakes_w:
        above += 1
    early, e = crossing(level, line, n, above)
    late = early + 1
    while rises and late < n and line.p[late] >= level:
        late += 1
    jumps = rises and early == above and line.w[above] == brakes_w
    e_p = level
    if jumps:  # to less than at the wall, if that is there
        e_p = min(max(begun_costate(train, step, line.p[early - 1]), level), line.p[early])
    n = insert(line, n, early, e, e_p)
    if not rises or late >= n - 1:
        policy[2] = e
        return n, early, early, early
    late += 1
    share = (level - line.p[late - 1]) / (line.p[late] - line.p[late - 1])
    g = line.w[late - 1] + share * (line.w[late] - line.w[late - 1])
    n = insert(line, n, late, g, level)
    coasts, b = crossing(level, line, n, late + 1)
    n = insert(line, n, coasts, b, level)
    policy[2], policy[LINES], policy[LINES + 1] = b, e, g
    return n, early, late, coasts
