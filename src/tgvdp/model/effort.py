"""Effort curves: the largest force at the wheel as a function of speed.

A curve is a chain of pieces, each valid from its own speed up to the next piece's:

    F(v) = power/v + c0 + c1·v + c2·v² + c3·v³          (N, v in m/s)

That one form holds a force cap and a power cap (two pieces), tables that are linear between points, with jumps, and
the polynomials of the demand formulation (`formulations.problem.alstom`), and it integrates in closed form over a
segment of constant acceleration.
"""

import math
from bisect import bisect_right
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InputError
from tgvdp.model.checks import require_number, require_rows

_OWNER = "effort curve"

#: Rounding of a curve that meets 0 N at a break must not count as negative effort.
_ROUNDING = 1e-9

#: A coefficient so much smaller than another one has no effect at any speed.
_NEGLIGIBLE = 1e-60


class EffortPoint(NamedTuple):
    """One row of an effort table."""

    speed_mps: float
    effort_n: float


class EffortPiece(NamedTuple):
    """One piece of an effort curve: ``power_w / v + c0_n + c1·v + c2·v² + c3·v³`` from ``from_mps`` on."""

    from_mps: float
    power_w: float = 0.0
    c0_n: float = 0.0
    c1: float = 0.0
    c2: float = 0.0
    c3: float = 0.0

    def effort_n(self, speed_mps: float) -> float:
        """Effort at a speed, N (infinite at standstill when the piece carries a power term)."""
        v = speed_mps
        hyperbolic = 0.0 if self.power_w == 0.0 else (self.power_w / v if v > 0.0 else math.inf)
        return hyperbolic + self.c0_n + v * (self.c1 + v * (self.c2 + v * self.c3))

    def is_negative_at(self, speed_mps: float) -> bool:
        """Whether the effort at a speed is below 0 N by more than rounding."""
        effort_n = self.effort_n(speed_mps)
        return effort_n < 0.0 and effort_n < -_ROUNDING * EffortPiece(*map(abs, self)).effort_n(speed_mps)

    def extremes_mps(self, from_mps: float, to_mps: float) -> list[float]:
        """Speeds strictly inside an interval at which the effort has an extreme."""
        # dF/dv · v² = −P + c1·v² + 2·c2·v³ + 3·c3·v⁴; power alone and a constant have none.
        if self.c1 == self.c2 == self.c3 == 0.0:
            return []
        slope = [3.0 * self.c3, 2.0 * self.c2, self.c1, 0.0, -self.power_w]
        # np.roots divides by the leading coefficient: next to nothing there would overflow.
        least = _NEGLIGIBLE * max(map(abs, slope))
        roots = np.roots([value if abs(value) > least else 0.0 for value in slope])
        return [float(root.real) for root in roots if from_mps < root.real < to_mps]


@dataclass(frozen=True)
class EffortCurve:
    """Largest effort over speed, never negative at the speeds where it is used.

    Parameters
    ----------
    pieces : tuple of EffortPiece
        Ordered by ``from_mps``; the first starts at standstill. The last one is valid for all higher speeds.

    Raises
    ------
    InputError
        When pieces are missing, unordered, not finite, infinite at standstill, or negative below the start of the
        last piece. `Train` looks at the rest, up to its top speed.

    See Also
    --------
    EffortCurve.from_caps, EffortCurve.from_points
    """

    pieces: tuple[EffortPiece, ...]

    def __post_init__(self) -> None:
        rows = []
        pieces: Any = self.pieces
        if isinstance(pieces, str) or not isinstance(pieces, Iterable):
            raise InputError(f"{_OWNER}: pieces must be a list of {EffortPiece._fields}, got {pieces!r:.60}")
        for index, piece in enumerate(pieces):
            if isinstance(piece, str) or not isinstance(piece, Collection):
                raise InputError(f"{_OWNER}: pieces[{index}] must be {EffortPiece._fields}, got {piece!r:.60}")
            if not 1 <= len(piece) <= len(EffortPiece._fields):
                raise InputError(f"{_OWNER}: pieces[{index}] must be {EffortPiece._fields}, got {piece!r:.60}")
            named = zip(EffortPiece._fields, piece, strict=False)
            rows.append(EffortPiece(*(require_number(_OWNER, f"pieces[{index}].{f}", v, "SI") for f, v in named)))
        object.__setattr__(self, "pieces", tuple(rows))
        if not rows or rows[0].from_mps != 0.0:
            raise InputError(f"{_OWNER}: the first piece must start at 0 m/s")
        for before, piece in pairwise(rows):
            if not piece.from_mps > before.from_mps:
                raise InputError(
                    f"{_OWNER}: speeds must increase, got {piece.from_mps:.12g} m/s after {before.from_mps:.12g} m/s"
                )
        if rows[0].power_w != 0.0:
            raise InputError(f"{_OWNER}: a power limit alone is infinite at standstill; give a force limit as well")
        self.require_not_negative(_OWNER, rows[-1].from_mps)

    @classmethod
    def from_caps(cls, force_n: float, power_w: float = math.inf) -> "EffortCurve":
        """Build ``min(force, power / v)``.

        Parameters
        ----------
        force_n : float
            Force cap in N, at least 0.
        power_w : float
            Power cap in W, above 0 unless the force is 0; infinite means none.
        """
        force_n = require_number(_OWNER, "force", force_n, "N", at_least=0.0)
        power_w = require_number(_OWNER, "power", power_w, "W", at_least=0.0, infinite_ok=True)
        if force_n == 0.0 or math.isinf(power_w):
            return cls((EffortPiece(0.0, c0_n=force_n),))
        if power_w == 0.0:
            raise InputError(f"{_OWNER}: power must be above 0 W where force is above 0 N, got 0 W")
        return cls((EffortPiece(0.0, c0_n=force_n), EffortPiece(power_w / force_n, power_w=power_w)))

    @classmethod
    def from_points(cls, points: Iterable[Sequence[float]]) -> "EffortCurve":
        """Build a curve that is linear between points and constant after the last one.

        Parameters
        ----------
        points : iterable of (speed_mps, effort_n)
            Speeds must not decrease and start at 0; a speed given twice is a jump, and none is given more often.
        """
        table: list[tuple[float, float]] = []
        for index, (speed_mps, effort_n) in enumerate(require_rows(_OWNER, "points", points, EffortPoint)):
            v = require_number(_OWNER, f"points[{index}].speed", speed_mps, "m/s", at_least=0.0)
            f = require_number(_OWNER, f"points[{index}].effort", effort_n, "N", at_least=0.0)
            if index and v < table[-1][0]:
                raise InputError(f"{_OWNER}: points[{index}].speed must not decrease, got {v:.12g} m/s")
            if index > 1 and v == table[-2][0]:
                raise InputError(f"{_OWNER}: points[{index}].speed is given a third time, got {v:.12g} m/s")
            table.append((v, f))
        if not table or table[0][0] != 0.0:
            raise InputError(f"{_OWNER}: the first point must be at 0 m/s")
        pieces = []
        for (v0, f0), (v1, f1) in pairwise(table):
            if v1 > v0:
                slope = (f1 - f0) / (v1 - v0)
                pieces.append(EffortPiece(v0, c0_n=f0 - slope * v0, c1=slope))
        pieces.append(EffortPiece(table[-1][0], c0_n=table[-1][1]))
        return cls(tuple(pieces))

    def effort_n(self, speed_mps: float) -> float:
        """Largest effort at a speed, N; at a jump, the value of the piece that starts there."""
        return self._piece_at(speed_mps).effort_n(speed_mps)

    def within(self, cap: "EffortCurve") -> "EffortCurve":
        """The smaller one of two curves at every speed."""
        breaks_mps = sorted({piece.from_mps for curve in (self, cap) for piece in curve.pieces})
        chosen: list[EffortPiece] = []
        for low_mps, high_mps in zip(breaks_mps, [*breaks_mps[1:], math.inf], strict=True):
            one, other = self._piece_at(low_mps), cap._piece_at(low_mps)
            # (F − G)·v is a polynomial: power, c0, c1, c2, c3 are its coefficients from the lowest on.
            terms = [b - a for a, b in zip(one[1:], other[1:], strict=True)][::-1]
            roots = np.roots(terms) if any(terms) else np.empty(0)
            meets_mps = sorted(float(root.real) for root in roots if abs(root.imag) <= _ROUNDING * abs(root))
            edges_mps = [low_mps, *(v for v in meets_mps if low_mps < v < high_mps), high_mps]
            for from_mps, to_mps in pairwise(edges_mps):
                inside_mps = 0.5 * (from_mps + to_mps) if math.isfinite(to_mps) else 2.0 * from_mps + 1.0
                lower = min(one, other, key=lambda piece: piece.effort_n(inside_mps))
                if not chosen or chosen[-1][1:] != lower[1:]:
                    chosen.append(lower._replace(from_mps=from_mps))
        return self if tuple(chosen) == self.pieces else EffortCurve(tuple(chosen))

    def _piece_at(self, speed_mps: float) -> EffortPiece:
        """Piece that holds at a speed; at a break the one that starts there."""
        return self.pieces[bisect_right(self.pieces, speed_mps, key=lambda piece: piece.from_mps) - 1]

    def __reduce__(self) -> tuple[type["EffortCurve"], tuple[Any, ...]]:
        """Pickle without the table: a copy of it could be written, which is another type for the kernels."""
        return EffortCurve, (self.pieces,)

    @cached_property
    def jumps_mps(self) -> tuple[float, ...]:
        """Speeds at which the effort jumps."""
        return tuple(
            piece.from_mps
            for before, piece in pairwise(self.pieces)
            if abs(before.effort_n(piece.from_mps) - piece.effort_n(piece.from_mps))
            > _ROUNDING * abs(before.effort_n(piece.from_mps))
        )

    def largest_n(self, up_to_mps: float) -> float:
        """Largest effort at any speed up to a given one, N."""
        largest_n = 0.0
        ends_mps = [*(piece.from_mps for piece in self.pieces[1:]), up_to_mps]
        for piece, end_mps in zip(self.pieces, ends_mps, strict=True):
            if piece.from_mps <= up_to_mps:
                end_mps = min(end_mps, up_to_mps)
                speeds_mps = (piece.from_mps, *piece.extremes_mps(piece.from_mps, end_mps), end_mps)
                largest_n = max(largest_n, *(piece.effort_n(speed_mps) for speed_mps in speeds_mps))
        return largest_n

    def require_not_negative(self, owner: str, up_to_mps: float) -> None:
        """Raise `InputError` where the effort is negative at some speed from standstill up to a given one."""
        ends_mps = [*(piece.from_mps for piece in self.pieces[1:]), math.inf]
        for piece, end_mps in zip(self.pieces, ends_mps, strict=True):
            top_mps = min(end_mps, up_to_mps)
            if piece.from_mps > top_mps:
                break
            for speed_mps in (piece.from_mps, *piece.extremes_mps(piece.from_mps, top_mps), top_mps):
                if piece.is_negative_at(speed_mps):
                    raise InputError(
                        f"{owner}: effort must be at least 0 N, "
                        f"got {piece.effort_n(speed_mps):.6g} N at {speed_mps:.6g} m/s"
                    )

    @cached_property
    def table(self) -> NDArray[np.float64]:
        """The pieces as rows (from_mps, power_w, c0_n, c1, c2, c3), shape (n, 6), float64, for the kernels."""
        table = np.array(self.pieces, dtype=np.float64)
        table.setflags(write=False)
        return table
