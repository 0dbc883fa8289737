"""Numbers beyond sense: where arithmetic fails, the input is asked whether its figures lie in their usual ranges.

Unusual is not wrong, so that nothing is refused for its figures alone. But where a search overflows, asks for more
memory than there is, or loses its way, the figures outside their ranges are the likeliest reason, and are named.
"""

import contextlib
from collections.abc import Iterator

import numpy as np

from tgvdp.errors import BudgetExceededError, InputError, NumericalError
from tgvdp.formats.review.plausibility import check_text, check_track, check_train
from tgvdp.memory import limited_memory
from tgvdp.model.trip import Trip

#: Figures that an error names, at most.
_NAMED = 3


@contextlib.contextmanager
def sensible_numbers(trip: Trip, max_memory_b: float | None = None) -> Iterator[None]:
    """Compute something of a trip; no overflow and no division by zero passes in silence, nor any hunger for memory.

    Parameters
    ----------
    trip : Trip
    max_memory_b : float, optional
        See `tgvdp.memory.limited_memory`.

    Raises
    ------
    InputError
        When the arithmetic fails and figures of the trip lie outside their usual ranges.
    NumericalError
        When it fails although none does.
    BudgetExceededError
        When there is not enough memory.
    """
    try:
        with np.errstate(over="raise", divide="raise", invalid="raise"), limited_memory(max_memory_b):
            yield
    except (NumericalError, ArithmeticError, MemoryError) as error:
        reason = str(error) or type(error).__name__
        owners = (
            (f"train {trip.train.name}", check_train(trip.train)),
            (f"track {trip.track.name}", check_track(trip.track)),
        )
        unusual = [f"{owner}: {check_text(check)}" for owner, checks in owners for check in checks if not check.ok]
        if not unusual and isinstance(error, MemoryError):
            raise BudgetExceededError(f"this takes more memory than there is: {reason}") from error
        if not unusual:
            raise NumericalError(f"{reason}; please report") from error
        more = f"; and {len(unusual) - _NAMED} more" if len(unusual) > _NAMED else ""
        raise InputError(f"cannot be computed: {'; '.join(unusual[:_NAMED])}{more} ({reason})") from error
