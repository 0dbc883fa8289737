"""The referee: drive the train again by the force law of a profile and compare.

Nothing of the search is used: no arc, no cells, no mean forces. The line is looked up in the track itself, and the
equation of motion is integrated with a fourth-order Runge–Kutta scheme in sub-steps that are graded towards the ends
of each row, as short as its stiffness asks for, and end where the effort limit has a break:

    dw/ds = 2·(F(v) − R(v) − G)/m_eff

What the train does along a row follows from its mean effort (`referee.law`).

Each row starts from the claimed speed. Carried from row to row instead, an error of 10⁻⁶ in v² where a train begins to
brake would grow to 10⁻³ of its top speed at the stop, which a driver corrects in passing. But nothing is given away:
what the claimed speed at the end of a row is off in kinetic energy counts in full as an error of energy.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tgvdp.constants import (
    REPLAY_EFFORT_PCT,
    REPLAY_ENERGY_PCT,
    REPLAY_OVERSPEED_RTOL,
    REPLAY_SPEED_RTOL,
    REPLAY_TIME_PCT,
)
from tgvdp.errors import InputError
from tgvdp.memory import ask_for
from tgvdp.model.trip import Trip
from tgvdp.physics.energy import energy_tables
from tgvdp.physics.forces import KernelTrain, kernel_train
from tgvdp.referee.drive import replay_rows
from tgvdp.referee.line import breaks_seen, limits_seen, see_line, supply_seen

if TYPE_CHECKING:
    from tgvdp.runs.profile import Profile

#: Where two sides of a break are one position, relative to it.
_SAME_POSITION = 1e-12
#: Sub-steps between two looks at the clock: a tenth of a second; usual runs have some thousand.
_SUB_STEPS_AT_ONCE = 200_000
#: Memory of a row, B: its columns, and what they are compared with.
_ROW_B = 80.0


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
    ok : bool or None
        Whether all are within the tolerances of `tgvdp.constants`, every break of the line is a row, and the run goes
        from origin to destination with the speeds asked for. None where there was no time for a replay.
    """

    time_error_pct: float
    energy_error_pct: float
    overspeed_mps: float
    effort_excess_pct: float
    speed_error_mps: float
    ok: bool | None


#: Of a run that was not replayed.
NOT_REPLAYED = Verdict(np.nan, np.nan, np.nan, np.nan, np.nan, None)


def _largest(differences: NDArray[np.float64]) -> float:
    return float(differences[np.argmax(np.abs(differences))])


def _covers(trip: Trip, profile: "Profile") -> bool:
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


def _overspeed(trip: Trip, profile: "Profile") -> float:
    """Largest excess over the limit, m/s; v² is linear along a row, so its ends are enough."""
    x = profile.position_m
    limit = limits_seen(trip, 0.5 * (x[:-1] + x[1:]))
    fastest = np.maximum(profile.speed_mps[:-1], profile.speed_mps[1:])
    return max(0.0, float(np.max(fastest - limit)))


def replay(trip: Trip, profile: "Profile", expired: Callable[[], bool] = bool) -> Verdict:
    """Drive a profile again and compare with what it claims.

    Parameters
    ----------
    trip : Trip
    profile : Profile
    expired : callable, optional
        Whether the time for it is up.

    Returns
    -------
    Verdict
        `NOT_REPLAYED` where the time was up before the end. Errors are infinite where there is nothing to compare: a
        row of no length, or effort where there can be none.

    Raises
    ------
    InputError
        When the trip is none.
    """
    if not isinstance(trip, Trip):
        raise InputError(f"replay: the order is replay(trip, profile), got {trip!r:.60} as the trip")
    train: KernelTrain = kernel_train(trip.train)
    x = profile.position_m
    numbers = (x, profile.speed_mps, profile.force_n, profile.time_s, profile.energy_j)
    if not (all(np.isfinite(column).all() for column in numbers) and (np.diff(x) > 0.0).all()):
        return Verdict(np.inf, np.inf, np.inf, np.inf, np.inf, False)
    ask_for(_ROW_B * len(x), f"a replay of {len(x):,} rows")
    time, energy = np.empty(len(x)), np.empty(len(x))
    tables = energy_tables(trip.train, trip.energy)
    supply = supply_seen(trip, 0.5 * (x[:-1] + x[1:]))
    line, row, excess, speed_error = see_line(trip), 0, -1.0, 0.0
    while row < len(x) - 1:
        if row and expired():
            return NOT_REPLAYED
        row, *found = replay_rows(
            train, tables, line, supply, x, profile.speed_mps, profile.force_n, time, energy, row, _SUB_STEPS_AT_ONCE
        )
        excess, speed_error = max(excess, found[0]), max(speed_error, found[1])
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
