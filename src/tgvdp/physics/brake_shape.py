"""At which speeds the effort of a dynamic brake begins, jumps, and rises; any effort may jump."""

from collections.abc import Iterator
from itertools import pairwise, zip_longest

from tgvdp.model.effort import EffortCurve

#: An effort that changes by this share at one speed jumps there.
JUMPS = 0.02


def jumps(curve: EffortCurve) -> Iterator[tuple[float, float, float]]:
    """Speeds at which an effort jumps, m/s, and the efforts just below and above, N."""
    for piece, after in pairwise(curve.pieces):
        below_n, above_n = piece.effort_n(after.from_mps), after.effort_n(after.from_mps)
        if max(below_n, above_n) > (1.0 + JUMPS) * min(below_n, above_n):
            yield after.from_mps, below_n, above_n


def last_jump_mps(brake: EffortCurve, *, rises: bool) -> float:
    """Highest speed at which the effort rises, or drops, at once; 0 if it does at none."""
    return max((speed for speed, below_n, above_n in jumps(brake) if (above_n > below_n) == rises), default=0.0)


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
