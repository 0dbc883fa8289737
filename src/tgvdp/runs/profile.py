"""Speed profiles: what a run looks like, row by row.

Between two rows the acceleration is constant, so v² is linear in position; limit and current are constant because
every break of the line is a row, and resistance and drag are exact means.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp._jit import kernel, leaf
from tgvdp.errors import NumericalError
from tgvdp.line.resolved import resolve
from tgvdp.memory import ask_for
from tgvdp.model.energy import PANTOGRAPH
from tgvdp.model.track import LOWERED, POWERED
from tgvdp.model.trip import Trip
from tgvdp.physics.arc import duration_and_work
from tgvdp.physics.codes import BRAKING, COASTING, HOLDING, TRACTION
from tgvdp.physics.energy import arc_energy, energy_tables
from tgvdp.physics.forces import KernelTrain, kernel_train, mean_brake, mean_effort, mean_resistance, unpowered

#: Driving regimes of a profile, by their number (`physics.codes`); holding by brakes is cruising, too.
REGIMES = ("traction", "cruising", "coasting", "braking")

#: An effort below this share of the starting effort counts as none (coasting).
_COASTING_SHARE = 1e-4
#: An acceleration below this share of what the starting effort gives counts as none (cruising).
_CRUISING_SHARE = 0.03
#: Memory of a row, B: its columns, and as many on the way to them.
_ROW_B = 120.0


class EnergyBalance(NamedTuple):
    """Where the energy of a run goes, J.

    Attributes
    ----------
    wheel_j : float
        Traction work at the wheel.
    pantograph_j : float
        Drawn from the line less what is returned, auxiliaries included: by the trip's map, or by the train's
        efficiencies when the trip has none.
    regenerated_j : float
        Returned to the line.
    auxiliary_j : float
        Drawn by everything but traction.
    braking_losses_j : float
        Work of all brakes less what is returned: turned into heat.
    """

    wheel_j: float
    pantograph_j: float
    regenerated_j: float
    auxiliary_j: float
    braking_losses_j: float


@dataclass(frozen=True, eq=False)
class Profile:
    """A run as rows; all arrays have shape (n,) and are read-only.

    Attributes
    ----------
    position_m : float64
        Position on the track, m.
    speed_mps : float64
        Speed, m/s.
    time_s : float64
        Time since departure, s.
    force_n : float64
        Mean effort at the wheel between this row and the next, N; positive traction, negative braking; the last is 0.
    energy_j : float64
        Energy since departure by the trip's energy model, J.
    regime : int8
        Index into `REGIMES` of the regime between this row and the next; the last repeats.
    balance : EnergyBalance
    """

    position_m: NDArray[np.float64]
    speed_mps: NDArray[np.float64]
    time_s: NDArray[np.float64]
    force_n: NDArray[np.float64]
    energy_j: NDArray[np.float64]
    regime: NDArray[np.int8]
    balance: EnergyBalance

    def __post_init__(self) -> None:
        for column in vars(self).values():
            if isinstance(column, np.ndarray):
                column.setflags(write=False)

    def __reduce__(self) -> tuple[type["Profile"], tuple[Any, ...]]:
        """Pickle so that the copy is read-only, too."""
        return Profile, tuple(getattr(self, column.name) for column in fields(self))

    @property
    def duration_s(self) -> float:
        """Running time, s."""
        return float(self.time_s[-1])

    @property
    def total_energy_j(self) -> float:
        """Energy of the whole run by the trip's energy model, J."""
        return float(self.energy_j[-1])

    @property
    def regime_names(self) -> list[str]:
        """Regime of each row by name."""
        return [REGIMES[code] for code in self.regime]


@leaf
def drawn_on(train, tables, at_wheel, supply, d, duration, work, w0, w1):
    """Energy of a row by the trip's model, and what is drawn and returned by the tables, auxiliaries included, J."""
    row = 0.0 if supply == LOWERED else arc_energy(train, tables, d, duration, work, w0, w1)
    return max(work, 0.0) if at_wheel else row, row


@kernel
def measure_rows(train, tables, at_wheel, x, w, grade, air, supply, time, force, energy, regime):
    """Fill time, force, energy, regime of rows (x, w); ``grade``, ``air``, ``supply`` belong to the row that starts.

    Returns the traction work, the braking work, what is drawn and returned by the tables, auxiliaries aside, and what
    these draw, J.
    """
    dark = unpowered(train)
    wheel = 0.0
    braking = 0.0
    drawn = 0.0
    returned = 0.0
    auxiliary = 0.0
    n = x.shape[0]
    start_effort = mean_effort(train.traction, 0.0, 0.0)
    time[0] = 0.0
    energy[0] = 0.0
    for i in range(n - 1):
        d = x[i + 1] - x[i]
        here = train if supply[i] == POWERED else dark
        duration, work, _, _ = duration_and_work(here, d, grade[i], air[i], w[i], w[i + 1])
        effort = work / d
        v0 = np.sqrt(w[i])
        v1 = np.sqrt(w[i + 1])
        acceleration = 0.5 * (w[i + 1] - w[i]) / d
        time[i + 1] = time[i] + duration
        counted, row = drawn_on(here, tables, at_wheel, supply[i], d, duration, work, w[i], w[i + 1])
        energy[i + 1] = energy[i] + counted
        if supply[i] != LOWERED:
            auxiliary += tables.auxiliary_w * duration
            row -= tables.auxiliary_w * duration
        wheel += max(work, 0.0)
        braking += max(-work, 0.0)
        drawn += max(row, 0.0)
        returned += max(-row, 0.0)
        force[i] = effort
        load = mean_resistance(train, air[i], v0, v1) + grade[i]
        limit = mean_effort(here.traction, v0, v1) if effort > 0.0 else mean_brake(here, load, v0, v1)
        if abs(effort) <= _COASTING_SHARE * start_effort:
            regime[i] = COASTING
        elif abs(acceleration) * train.inertia_kg <= _CRUISING_SHARE * start_effort and abs(effort) < 0.95 * limit:
            regime[i] = HOLDING
        else:
            regime[i] = TRACTION if effort > 0.0 else BRAKING
    force[n - 1] = 0.0
    regime[n - 1] = regime[n - 2]
    return wheel, braking, drawn, returned, auxiliary


def drawn_energy_j(trip: Trip, profile: Profile) -> float:
    """Energy of a run by the trip's model before what braking returns, J."""
    returned_j = 0.0 if trip.energy.kind == "wheel" else profile.balance.regenerated_j
    return profile.total_energy_j + returned_j


def profile_of(
    trip: Trip, x_m: NDArray[np.float64], w: NDArray[np.float64], known: NDArray[np.int8] | None = None
) -> Profile:
    """Make a profile from rows.

    Parameters
    ----------
    trip : Trip
    x_m : (n,) float64
        Strictly increasing positions from the origin, m; every break of the line must be among them.
    w : (n,) float64
        Squared speeds, m²/s².
    known : (n − 1,) int8, optional
        Regime of each row where it is known, −1 where its effort shall tell.

    Returns
    -------
    Profile

    Raises
    ------
    NumericalError
        When time or energy are not finite.
    """
    train: KernelTrain = kernel_train(trip.train)
    line = resolve(trip)
    grade_n, air, supply = line.between(x_m)
    n = len(x_m)
    ask_for(_ROW_B * n, f"a profile of {n:,} rows")
    time, force, energy = np.empty(n), np.empty(n), np.empty(n)
    regime = np.empty(n, dtype=np.int8)
    at_wheel = trip.energy.kind == "wheel"
    tables = energy_tables(trip.train, PANTOGRAPH if at_wheel else trip.energy)
    wheel, braking, drawn, returned, auxiliary = measure_rows(
        train, tables, at_wheel, x_m, w, grade_n, air, supply, time, force, energy, regime
    )
    if not (np.isfinite(time[-1]) and np.isfinite(energy[-1])):
        raise NumericalError("the time or the energy of a run is no number")
    if known is not None:
        regime[:-1] = np.where(known >= 0, known, regime[:-1])
        regime[-1] = regime[-2]
    balance = EnergyBalance(wheel, drawn - returned + auxiliary, returned, auxiliary, braking - returned)
    return Profile(trip.origin_m + x_m, np.sqrt(w), time, force, energy, regime, balance)


def joined(profiles: Sequence[Profile], departure_s: NDArray[np.float64]) -> Profile:
    """Profiles one behind the other, each from its departure, s: a stop between two is two rows at its position."""
    starts_j = np.cumsum([0.0, *(one.total_energy_j for one in profiles[:-1])])
    names = ("position_m", "speed_mps", "force_n", "regime")
    return Profile(
        time_s=np.concatenate([one.time_s + start_s for one, start_s in zip(profiles, departure_s, strict=True)]),
        energy_j=np.concatenate([one.energy_j + start_j for one, start_j in zip(profiles, starts_j, strict=True)]),
        balance=EnergyBalance(*np.sum([one.balance for one in profiles], axis=0).tolist()),
        **{name: np.concatenate([getattr(one, name) for one in profiles]) for name in names},
    )
