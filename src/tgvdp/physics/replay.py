"""The referee: drive the train again by the force law of a profile and compare.

Nothing of the search is used: no arc, no cells, no mean forces. The line is looked up in the track itself, and the
equation of motion is integrated with a fourth-order Runge–Kutta scheme in sub-steps that are graded towards the ends
of each row and as short as its stiffness asks for:

    dw/ds = 2·(F(v) − R(v) − G)/m_eff

What the train does along a row follows from its mean effort (`physics.replay_law`).

Each row starts from the claimed speed. Carried from row to row instead, an error of 10⁻⁶ in v² where a train begins to
brake would grow to 10⁻³ of its top speed at the stop, which a driver corrects in passing. But nothing is given away:
what the claimed speed at the end of a row is off in kinetic energy counts in full as an error of energy.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel
from tgvdp.constants import (
    REPLAY_EFFORT_PCT,
    REPLAY_ENERGY_PCT,
    REPLAY_OVERSPEED_RTOL,
    REPLAY_SPEED_RTOL,
    REPLAY_TIME_PCT,
)
from tgvdp.model.trip import Trip
from tgvdp.physics.energy import energy_tables
from tgvdp.physics.forces import KernelTrain, effort_at, kernel_train, unpowered
from tgvdp.physics.profile import Profile
from tgvdp.physics.replay_law import commanded, drawn_per_metre, map_power_at, mean_limit, slope_at, sub_steps
from tgvdp.physics.replay_line import breaks_seen, limits_seen, met, see_line, supply_seen
from tgvdp.physics.resolved import LOWERED, POWERED

#: Where two sides of a break are one position, relative to it.
_SAME_POSITION = 1e-12
#: The line at the end of a row is looked up this share of the row inside it.
_INSIDE = 1e-6
#: An effort below this share of the starting effort counts as none.
_NO_EFFORT = 1e-4


@dataclass(frozen=True)
class Verdict:
    """What the referee found.

    Attributes
    ----------
    time_error_pct, energy_error_pct : float
        Claimed minus replayed, where they differ most along the run, in percent of the replayed running time, and of
        the replayed energy (by the trip's energy model) or of the kinetic energy at top speed if that is more.
    overspeed_mps : float
        Largest excess of the profile's speed over the limit, m/s.
    effort_excess_pct : float
        Largest excess of a row's mean effort over the mean effort limit along the row, or of its acceleration over
        the comfort limit, in percent.
    speed_error_mps : float
        Largest difference between claimed and replayed speed at the end of a row, m/s.
    ok : bool
        Whether all are within the tolerances of `tgvdp.constants`, every break of the line is a row, and the run goes
        from origin to destination with the speeds asked for.
    """

    time_error_pct: float
    energy_error_pct: float
    overspeed_mps: float
    effort_excess_pct: float
    speed_error_mps: float
    ok: bool


@kernel
def _replay_kernel(train, tables, line, supply, x, speed, force, time, energy):
    """Replay all rows; cumulative time and energy in place; returns effort excess and speed error."""
    excess = -1.0
    speed_error = 0.0
    by_map = tables.speed_mps.shape[0] > 0
    dark = unpowered(train)
    time[0] = 0.0
    energy[0] = 0.0
    for i in range(x.shape[0] - 1):
        d = x[i + 1] - x[i]
        w0 = speed[i] * speed[i]
        w1 = speed[i + 1] * speed[i + 1]
        here = train if supply[i] == POWERED else dark
        limit = mean_limit(here, line, force[i] < 0.0, np.inf, x[i], d, w0, w1)
        lever = abs(force[i]) / limit if limit > 0.0 else 0.0
        if limit == 0.0:  # no current, or no brake: what counts as no effort is a share of the starting effort
            share = abs(force[i]) / effort_at(train.traction, 0.0)
            if share > _NO_EFFORT:
                return np.inf, np.inf
        acceleration = 0.5 * (w1 - w0) / d
        if force[i] < 0.0 and train.rates.shape[0] > 0:  # next to nothing is left to brakes where the load slows enough
            excess = max(excess, (-force[i] - limit) / effort_at(train.rates, 0.5 * (speed[i] + speed[i + 1])))
        else:
            excess = max(excess, lever - 1.0)
        excess = max(excess, acceleration / train.max_acceleration - 1.0, -acceleration / train.max_deceleration - 1.0)
        nudge = 1e-9 * abs(speed[i + 1] - speed[i])
        lo = min(speed[i], speed[i + 1]) + nudge
        hi = max(speed[i], speed[i + 1]) - nudge
        command = commanded(here, line, force[i], limit, x[i], d, w0, w1)
        law = (here, command, lever, lo, hi)
        inside_m = _INSIDE * d  # a break at the end of a row belongs to the next one
        after_met = met(line, x[i] + inside_m)
        w = w0
        seconds = 0.0
        drawn = 0.0
        done = 0.0
        count = sub_steps(*law, *met(line, x[i] + 0.5 * d), d, max(w0, w1))
        for j in range(count):
            u = (j + 1.0) / count
            end = d * u * u * (3.0 - 2.0 * u)
            h = end - done
            before_met = after_met
            middle_met = met(line, x[i] + done + 0.5 * h)
            after_met = met(line, x[i] + min(end, d - inside_m))
            k1, f1 = slope_at(*law, *before_met, w)
            k2, f2 = slope_at(*law, *middle_met, w + 0.5 * h * k1)
            k3, f3 = slope_at(*law, *middle_met, w + 0.5 * h * k2)
            k4, f4 = slope_at(*law, *after_met, w + h * k3)
            after = w + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
            v0 = np.sqrt(max(w, 0.0))
            v1 = np.sqrt(max(after, 0.0))
            step = 0.0
            if after > 0.0:
                step = 2.0 * h / (v0 + v1)
            elif w > 0.0:  # it stops within this sub-step; a w below 0 is the energy that it lacks
                step = 2.0 * h * w / (w - after) / v0
            seconds += step
            if by_map:  # the speed is nearly linear in time, the power has no part that is singular at standstill
                pull = (here, tables, command, lever, lo, hi)
                powers = map_power_at(*pull, *before_met, v0) + 4.0 * map_power_at(*pull, *middle_met, 0.5 * (v0 + v1))
                drawn += step / 6.0 * (powers + map_power_at(*pull, *after_met, v1))
            else:
                ends = drawn_per_metre(here, tables, f1, lo, hi, w) + drawn_per_metre(
                    here, tables, f4, lo, hi, w + h * k3
                )
                inner = drawn_per_metre(here, tables, f2, lo, hi, w + 0.5 * h * k1)
                inner += drawn_per_metre(here, tables, f3, lo, hi, w + 0.5 * h * k2)
                drawn += h / 6.0 * (ends + 2.0 * inner)
            w = after
            done = end
        time[i + 1] = time[i] + seconds
        drawn = 0.0 if supply[i] == LOWERED else drawn + tables.auxiliary_w * seconds
        energy[i + 1] = energy[i] + drawn + 0.5 * train.inertia_kg * abs(w1 - w)
        speed_error = max(speed_error, abs(np.sqrt(max(w, 0.0)) - speed[i + 1]))
    return excess, speed_error


def _largest(differences: NDArray[np.float64]) -> float:
    return float(differences[np.argmax(np.abs(differences))])


def _covers(trip: Trip, profile: Profile) -> bool:
    """Whether the rows go forward from origin to destination, and a row ends at every break of the line."""
    x = profile.position_m
    same = _SAME_POSITION * max(trip.destination_m, 1e-300)
    top = float(profile.speed_mps.max())
    ends = np.abs((x[0] - trip.origin_m, x[-1] - trip.destination_m))
    speeds = np.abs((profile.speed_mps[0] - trip.start_speed_mps, profile.speed_mps[-1] - trip.end_speed_mps))
    if not ((np.diff(x) > 0.0).all() and (ends <= same).all() and (speeds <= REPLAY_OVERSPEED_RTOL * top).all()):
        return False
    breaks = breaks_seen(trip)
    after = np.searchsorted(x, breaks).clip(1, len(x) - 1)
    return bool((np.minimum(np.abs(x[after - 1] - breaks), np.abs(x[after] - breaks)) <= same).all())


def _overspeed(trip: Trip, profile: Profile) -> float:
    """Largest excess over the limit, m/s; v² is linear along a row, so its ends are enough."""
    x = profile.position_m
    limit = limits_seen(trip, 0.5 * (x[:-1] + x[1:]))
    fastest = np.maximum(profile.speed_mps[:-1], profile.speed_mps[1:])
    return max(0.0, float(np.max(fastest - limit)))


def replay(trip: Trip, profile: Profile) -> Verdict:
    """Drive a profile again and compare with what it claims.

    Parameters
    ----------
    trip : Trip
    profile : Profile

    Returns
    -------
    Verdict
        Errors are infinite where there is nothing to compare: a row of no length, or effort where there can be none.
    """
    train: KernelTrain = kernel_train(trip.train)
    x = profile.position_m
    numbers = (x, profile.speed_mps, profile.force_n, profile.time_s, profile.energy_j)
    if not (all(np.isfinite(column).all() for column in numbers) and (np.diff(x) > 0.0).all()):
        return Verdict(np.inf, np.inf, _overspeed(trip, profile), np.inf, np.inf, False)
    time, energy = np.empty(len(x)), np.empty(len(x))
    tables = energy_tables(trip.train, trip.energy)
    supply = supply_seen(trip, 0.5 * (x[:-1] + x[1:]))
    excess, speed_error = _replay_kernel(
        train, tables, see_line(trip), supply, x, profile.speed_mps, profile.force_n, time, energy
    )
    overspeed = _overspeed(trip, profile)
    excess_pct = max(0.0, 100.0 * excess)
    if not np.isfinite(speed_error):
        return Verdict(np.inf, np.inf, overspeed, excess_pct, np.inf, False)
    top = float(profile.speed_mps.max())
    kinetic = 0.5 * trip.train.inertia_kg * top**2
    time_error = 100.0 * _largest(profile.time_s - time) / time[-1]
    energy_error = 100.0 * _largest(profile.energy_j - energy) / max(abs(energy[-1]), kinetic)
    ok = (
        abs(time_error) <= REPLAY_TIME_PCT
        and abs(energy_error) <= REPLAY_ENERGY_PCT
        and overspeed <= REPLAY_OVERSPEED_RTOL * top
        and excess_pct <= REPLAY_EFFORT_PCT
        and speed_error <= REPLAY_SPEED_RTOL * top
        and _covers(trip, profile)
    )
    return Verdict(float(time_error), float(energy_error), overspeed, excess_pct, float(speed_error), bool(ok))
