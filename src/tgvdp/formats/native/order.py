"""Values of the native format that depend on each other, as the file gives them: the model tells them in SI."""

from collections.abc import Sequence

from tgvdp.errors import InputError


def require_rising(place: str, field: str, speeds_kmh: Sequence[float], *, most: int = 1) -> None:
    """Refuse speeds of rows that do not rise from 0 km/h.

    Parameters
    ----------
    place, field : str
        Of the rows, and of the speed in each.
    speeds_kmh : sequence of float
    most : int
        How many rows may have one speed.

    Raises
    ------
    InputError
        When the first one is not 0, or one is lower than the one before it or there too often.
    """
    for index, speed_kmh in enumerate(speeds_kmh):
        where, got = f"{place}[{index}].{field}", f"got {speed_kmh:.12g} km/h"
        if index == 0 and speed_kmh != 0.0:
            raise InputError(f"{where}: must be 0 km/h, {got}")
        if index >= most and speed_kmh == speeds_kmh[index - most]:
            raise InputError(f"{where}: must not be given more than {'twice' if most > 1 else 'once'}, {got}")
        if index and speed_kmh < speeds_kmh[index - 1]:
            raise InputError(f"{where}: must rise, {got} after {speeds_kmh[index - 1]:.12g} km/h")


def require_at_most(place: str, mass_t: float, train_t: float) -> float:
    """Return a part of the mass of a train; raise `InputError` where it is more than the whole."""
    if mass_t > train_t:
        raise InputError(f"{place}: must be at most train.mass_t, {train_t:.12g} t, got {mass_t:.12g} t")
    return mass_t
