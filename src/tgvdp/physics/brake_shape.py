"""At which speeds the effort of a dynamic brake begins, jumps, and rises."""

from itertools import pairwise, zip_longest

from tgvdp.model.effort import EffortCurve

#: An effort that changes by this share at one speed jumps there.
JUMPS = 0.02


def last_jump_mps(brake: EffortCurve, *, rises: bool) -> float:
    """Highest speed at which the effort rises, or drops, at once; 0 if it does at none."""
    jumps_mps = []
    for before, after in pairwise(brake.pieces):
        efforts_n = before.effort_n(after.from_mps), after.effort_n(after.from_mps)
        less_n, more_n = efforts_n if rises else efforts_n[::-1]
        if more_n > (1.0 + JUMPS) * less_n:
            jumps_mps.append(after.from_mps)
    return max(jumps_mps, default=0.0)


def begins_mps(brake: EffortCurve) -> float:
    """Speed at which the first piece begins that has an effort."""
    for piece, end in zip_longest(brake.pieces, brake.pieces[1:]):
        if piece.effort_n(piece.from_mps) > 0.0 or (end is not None and piece.effort_n(end.from_mps) > 0.0):
            return float(piece.from_mps)
    return 0.0


def ramps_to_mps(brake: EffortCurve) -> float:
    """Highest speed at which a piece of the curve ends that rises; 0 if none does."""
    ends_mps = [
        after.from_mps
        for piece, after in pairwise(brake.pieces)
        if piece.effort_n(after.from_mps) > (1.0 + JUMPS) * piece.effort_n(piece.from_mps)
    ]
    return max(ends_mps, default=0.0)
