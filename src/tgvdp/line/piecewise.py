"""Functions of the position along a line: quadratic pieces, exact integrals, and their mean over a train's length."""

from collections.abc import Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: Values that differ by less than this share of the largest are equal but for rounding.
_SAME_VALUE = 1e-9


def as_table(rows: Sequence[tuple[float, ...]]) -> Floats:
    """Rows as an array, (n, columns) float64, in a tenth of the time that numpy takes by itself for named tuples."""
    return np.fromiter(chain.from_iterable(rows), np.float64).reshape(len(rows), -1)


class Piecewise(NamedTuple):
    """A function of the position, quadratic between n + 1 knots and free to jump at them; arrays are float64.

    Attributes
    ----------
    knot_m : (n + 1,)
        Increasing positions.
    coefficient : (n, 3)
        Piece i is ``c0 + c1·u + c2·u²`` with u counted from its left knot.
    integral : (n + 1,)
        Integral from the first knot up to each knot.
    """

    knot_m: Floats
    coefficient: Floats
    integral: Floats

    @classmethod
    def of(cls, knot_m: Floats, left: Floats, middle: Floats, right: Floats) -> "Piecewise":
        """Build the function from the values of each piece at its left end, its middle and its right end, (n,) each."""
        h = np.diff(knot_m)
        slope = (4.0 * (middle - left) - (right - left)) / h
        bend = 2.0 * ((left - middle) + (right - middle)) / (h * h)
        integral = np.concatenate(([0.0], np.cumsum(h / 6.0 * (left + 4.0 * middle + right))))
        return cls(knot_m, np.column_stack((left, slope, bend)), integral)

    @classmethod
    def constant(cls, value: float, length_m: float) -> "Piecewise":
        """Build a function that has one value from 0 to a length."""
        return cls(np.array([0.0, length_m]), np.array([[value, 0.0, 0.0]]), np.array([0.0, value * length_m]))

    @property
    def is_even(self) -> bool:
        """Whether it is constant within each piece."""
        return not self.coefficient[:, 1:].any()

    def piece_at(self, x_m: Floats) -> NDArray[np.int64]:
        """Piece that holds each position, at a knot the one that starts there; beyond the ends the nearest."""
        return np.asarray(np.searchsorted(self.knot_m[1:-1], x_m, side="right"))

    def on(self, piece: NDArray[np.int64], x_m: Floats) -> Floats:
        """Values of given pieces at given positions."""
        u = x_m - self.knot_m[piece]
        c0, c1, c2 = self.coefficient[piece].T
        return np.asarray(c0 + u * (c1 + u * c2))

    def integral_to(self, x_m: Floats) -> Floats:
        """Integral from the first knot."""
        piece = self.piece_at(x_m)
        u = x_m - self.knot_m[piece]
        c0, c1, c2 = self.coefficient[piece].T
        return np.asarray(self.integral[piece] + u * (c0 + u * (c1 / 2.0 + u * c2 / 3.0)))

    def mean(self, from_m: Floats, to_m: Floats) -> Floats:
        """Mean between positions; exact."""
        return np.asarray((self.integral_to(to_m) - self.integral_to(from_m)) / (to_m - from_m))

    def ends(self) -> tuple[Floats, Floats, Floats]:
        """Values of each piece at its left end, its middle and its right end."""
        if self.is_even:
            return (self.coefficient[:, 0],) * 3
        h = np.diff(self.knot_m)
        c0, c1, c2 = self.coefficient.T
        return c0, c0 + 0.5 * h * (c1 + 0.5 * h * c2), c0 + h * (c1 + h * c2)

    def scaled(self, factor: float) -> "Piecewise":
        """The function times a factor."""
        return Piecewise(self.knot_m, factor * self.coefficient, factor * self.integral)

    def plus(self, other: "Piecewise") -> "Piecewise":
        """The sum of two functions with the same ends."""
        knot_m = np.union1d(self.knot_m, other.knot_m)
        left_m, right_m = knot_m[:-1], knot_m[1:]
        middle_m = 0.5 * (left_m + right_m)
        mine, theirs = self.piece_at(middle_m), other.piece_at(middle_m)
        return Piecewise.of(
            knot_m, *(self.on(mine, at_m) + other.on(theirs, at_m) for at_m in (left_m, middle_m, right_m))
        )

    def between(self, from_m: float, to_m: float) -> "Piecewise":
        """The function on a part of its range, with positions from there on."""
        first = int(self.knot_m[1:-1].searchsorted(from_m, side="right"))
        last = int(self.knot_m[1:-1].searchsorted(to_m, side="left")) + 1
        knot_m = np.concatenate(([0.0], self.knot_m[first + 1 : last] - from_m, [to_m - from_m]))
        coefficient = self.coefficient[first:last].copy()
        u = from_m - self.knot_m[first]
        c0, c1, c2 = coefficient[0].tolist()
        coefficient[0] = c0 + u * (c1 + u * c2), c1 + 2.0 * u * c2, c2
        h = np.diff(knot_m)
        c0, c1, c2 = coefficient.T
        integral = np.concatenate(([0.0], np.cumsum(h * (c0 + h * (c1 / 2.0 + h * c2 / 3.0)))))
        return Piecewise(knot_m, coefficient, integral)

    def mean_behind(self, length_m: float) -> "Piecewise":
        """Mean over the last ``length_m`` before each position: a train of that length whose head is there.

        The function must be linear between its knots. Before the first it is taken to hold its first value.
        """
        held = self.coefficient[:1] * np.array([1.0, 0.0, 0.0])
        back = Piecewise(
            np.concatenate(([self.knot_m[0] - length_m], self.knot_m)),
            np.concatenate((held, self.coefficient)),
            np.concatenate(([0.0], self.integral + held[0, 0] * length_m)),
        )
        shifted = self.knot_m + length_m
        knot_m = np.union1d(self.knot_m, shifted[shifted < self.knot_m[-1]])

        def mean(x_m: Floats) -> Floats:
            return back.mean(x_m - length_m, x_m)

        return Piecewise.of(knot_m, mean(knot_m[:-1]), mean(0.5 * (knot_m[:-1] + knot_m[1:])), mean(knot_m[1:]))

    def steps(self, least: float, most: int, area: float) -> Floats:
        """Positions between which the function changes by about a step at most, and less over long distances.

        Knots where it jumps, and both ends of the stretches where it is constant, are always among them.

        Parameters
        ----------
        least : float
            The step, in the unit of the function, above 0; a larger one where the range of the function holds more ...
        most : int
            ... than so many.
        area : float
            Largest product of the change within a step and its length, in that unit times m, above 0.
        """
        left, middle, right = ends = np.array(self.ends())
        step = max(least, float(ends.max() - ends.min()) / most)
        noise = _SAME_VALUE * max(float(np.abs(ends[::2]).max()), step)
        change = np.abs(middle - left) + np.abs(right - middle)
        flat = change <= noise
        fixed = np.ones(len(self.knot_m), dtype=bool)
        fixed[1:-1] = (flat[:-1] != flat[1:]) | (np.abs(left[1:] - right[:-1]) > noise)
        if flat.all():
            return self.knot_m[fixed]
        along = np.concatenate(([0.0], np.cumsum(np.where(flat, 0.0, change))))
        at = np.flatnonzero(fixed)
        span_m, range_ = np.diff(self.knot_m[at]), np.diff(along[at])
        parts = np.maximum(range_ / step, np.sqrt(range_ * span_m / area))
        count = np.maximum(np.ceil(parts), 1.0).astype(np.int64)
        positions = [self.knot_m[at]]
        for i in np.flatnonzero(count > 1):
            span = slice(at[i], at[i + 1] + 1)
            levels = along[at[i]] + (along[at[i + 1]] - along[at[i]]) * np.arange(1, count[i]) / count[i]
            positions.append(np.interp(levels, along[span], self.knot_m[span]))
        return np.unique(np.concatenate(positions))

    def roots(self) -> Floats:
        """Positions inside the pieces at which the function is 0."""
        c0, c1, c2 = self.coefficient.T
        discriminant = c1 * c1 - 4.0 * c2 * c0
        q = -0.5 * (c1 + np.copysign(np.sqrt(np.maximum(discriminant, 0.0)), c1))
        found = [self.knot_m[:0]]
        for above, below in ((q, c2), (c0, q)):
            u = np.divide(above, below, out=np.full_like(c0, np.nan), where=(below != 0.0) & (discriminant >= 0.0))
            inside = (u > 0.0) & (u < np.diff(self.knot_m))
            found.append(self.knot_m[:-1][inside] + u[inside])
        return np.concatenate(found)
