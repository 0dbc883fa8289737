"""Speed profiles: what a run looks like, row by row.

Between two rows the acceleration is constant, so v² is linear in position; limit and current are constant because
every break of the line is a row, and resistance and drag are exact means.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import NumericalError
from tgvdp.memory import ask_for
from tgvdp.model.trip import Trip
from tgvdp.runs.measure import Columns, measured
from tgvdp.units import KILO, joule_to_kwh

#: Driving regimes of a profile, by their number (`physics.codes`); holding by brakes is cruising, too.
REGIMES = ("traction", "cruising", "coasting", "braking")

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


@dataclass(frozen=True, eq=False, repr=False)
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

    def __repr__(self) -> str:
        ends_km = f"{self.position_m[0] / KILO:.6g} to {self.position_m[-1] / KILO:.6g} km"
        taken = f"{self.duration_s:.1f} s, {joule_to_kwh(self.total_energy_j):.2f} kWh"
        return f"<Profile: {ends_km} in {taken}, {len(self.position_m)} rows>"

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
    n = len(x_m)
    ask_for(_ROW_B * n, f"a profile of {n:,} rows")
    columns = Columns.of(n)
    totals = measured(trip, np.ascontiguousarray(x_m), np.ascontiguousarray(w), np.array([0, n]), columns)
    time_s, energy_j, wheel, braking, drawn, returned, auxiliary = totals[0].tolist()
    if not (math.isfinite(time_s) and math.isfinite(energy_j)):
        raise NumericalError("the time or the energy of a run is no number")
    regime = columns.regime
    if known is not None:
        regime[:-1] = np.where(known >= 0, known, regime[:-1])
        regime[-1] = regime[-2]
    balance = EnergyBalance(wheel, drawn - returned + auxiliary, returned, auxiliary, braking - returned)
    return Profile(trip.origin_m + x_m, np.sqrt(w), columns.time, columns.force, columns.energy, regime, balance)


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
