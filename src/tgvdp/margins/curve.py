"""Squared speeds over the distance: curves of constant acceleration between their rows, and driving along the line."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.line.cells import Cells
from tgvdp.model.track import POWERED
from tgvdp.physics.cell import Cell, Rows
from tgvdp.physics.forces import KernelTrain
from tgvdp.physics.march import march
from tgvdp.physics.motion import land

_Floats = NDArray[np.float64]

#: Rows of one march at most.
_ROOM = 32768
#: Relative difference below which speeds are the same.
_SAME = 1e-9
#: A share of a cell's length within which its forces are those at its begin.
_NEAR = 1e-6


class Curve(NamedTuple):
    """Increasing positions from the origin of a trip, m, and squared speeds, m²/s², linear in between, (n,)."""

    x_m: _Floats
    w: _Floats

    def at(self, x_m: float) -> float:
        """Squared speed at a position, m²/s²."""
        return float(np.interp(x_m, self.x_m, self.w))

    @property
    def duration_s(self) -> float:
        """Time along the curve, s."""
        v = np.sqrt(self.w)
        return float(np.sum(2.0 * np.diff(self.x_m) / (v[:-1] + v[1:])))

    def between(self, from_m: float, to_m: float) -> "Curve":
        """The curve from one position to another, which become its ends."""
        inside = (self.x_m > from_m) & (self.x_m < to_m)
        x_m = np.concatenate(([from_m], self.x_m[inside], [to_m]))
        return Curve(x_m, np.interp(x_m, self.x_m, self.w))

    def scaled(self, ratio: float) -> "Curve":
        """The curve with all speeds divided by a ratio."""
        return Curve(self.x_m, self.w / ratio**2)

    def upper(self, other: "Curve") -> "Curve":
        """Of this curve and one over a part of it, the faster."""
        part = self.between(float(other.x_m[0]), float(other.x_m[-1]))
        x_m = _with_crossings(part, other)
        faster = Curve(x_m, np.maximum(np.interp(x_m, *part), np.interp(x_m, *other)))
        return self.replaced(faster)

    def replaced(self, part: "Curve") -> "Curve":
        """The curve with a part of it replaced."""
        before, after = self.x_m < part.x_m[0], self.x_m > part.x_m[-1]
        return Curve(*(np.concatenate((own[before], new, own[after])) for own, new in zip(self, part, strict=True)))

    def until(self, at_m: float, other: "Curve") -> "Curve":
        """The curve as far as a position, where another one goes on."""
        before, after = self.x_m < at_m, other.x_m > at_m
        joint = Curve(np.array([at_m]), np.array([self.at(at_m)]))
        return Curve(
            *(np.concatenate((own[before], at, new[after])) for own, at, new in zip(self, joint, other, strict=True))
        )

    def first_meeting_m(self, other: "Curve") -> float | None:
        """Where this curve, which begins below another one, first is as fast as that, m; None where it never is."""
        x_m = np.union1d(self.x_m, other.between(float(self.x_m[0]), float(self.x_m[-1])).x_m)
        above = np.interp(x_m, *self) - np.interp(x_m, *other)
        below = np.flatnonzero(above < -_SAME * float(other.w.max()))
        if not len(below):
            return None
        met = below[0] + np.flatnonzero(above[below[0] :] >= 0.0)
        return float(_zero(x_m, above, met[0] - 1)) if len(met) else None


def mirrored(curve: Curve, length_m: float) -> Curve:
    """A curve as it is met from the other end of a stretch."""
    return Curve(length_m - curve.x_m[::-1], curve.w[::-1])


def blended(first: Curve, second: Curve, share: float) -> Curve:
    """A share of the way from one curve to another, both of the same stretch."""
    x_m = np.union1d(first.x_m, second.x_m)
    before, after = np.interp(x_m, *first), np.interp(x_m, *second)
    return Curve(x_m, before + share * (after - before))


def _with_crossings(first: Curve, second: Curve) -> _Floats:
    """Positions of the rows of two curves and of where they cross, m."""
    x_m = np.union1d(first.x_m, second.x_m)
    above = np.interp(x_m, *first) - np.interp(x_m, *second)
    return np.union1d(x_m, _zero(x_m, above, np.flatnonzero(above[:-1] * above[1:] < 0.0)))


def _zero(x_m: _Floats, above: _Floats, before: NDArray[np.int64]) -> _Floats:
    """Where differences are 0 after given rows, m."""
    share = above[before] / (above[before] - above[before + 1])
    return np.asarray(x_m[before] + share * (x_m[before + 1] - x_m[before]))


class Driver(NamedTuple):
    """A train on its line."""

    train: KernelTrain
    cells: Cells

    def forwards(self, regime: int, from_m: float, w: float, under: Curve) -> Curve:
        """Drive under a regime from a position until the end, a stand, or a curve is met again from below."""
        return self._driven(regime, 1.0, from_m, w, 0.0, under)[0]

    def backwards(self, regime: int, to_m: float, w: float, least_w: float, under: Curve) -> tuple[Curve, bool]:
        """Drive to a position as `forwards`, seen from its end, at no less than some v²; whether that was reached."""
        return self._driven(regime, -1.0, to_m, w, least_w, under)

    def _driven(self, regime: int, sign: float, x: float, w: float, least_w: float, under: Curve) -> tuple[Curve, bool]:
        station_m = self.cells.station_m
        top_w = float(under.w.max()) * (1.0 + _SAME)
        dark = self.train._replace(traction=self.train.no_effort, braking=self.train.no_effort)
        scratch = Rows(*np.empty((2, _ROOM)))
        xs, ws = [np.array([x])], [np.array([w])]
        held = False
        while (x < station_m[-1]) if sign > 0.0 else (x > station_m[0]):
            k = int(np.searchsorted(station_m, x, side="right" if sign > 0.0 else "left")) - 1
            k = min(max(k, 0), len(self.cells.length_m) - 1)
            end = float(station_m[k + 1] if sign > 0.0 else station_m[k])
            cell = self._cell(k, abs(end - x))
            here = self.train if self.cells.supply[k] == POWERED else dark
            rises = land(here, regime, sign, cell, _NEAR * cell.length_m, w) > w
            if not rises and w <= least_w * (1.0 + _SAME):
                held, x = True, end
                xs.append(np.array([x]))
                ws.append(np.array([w]))
            else:
                done, w, n = march(here, regime, sign, cell, cell.length_m, w, top_w if rises else least_w, scratch, 0)
                xs.append(x + sign * scratch.x[:n])
                ws.append(scratch.w[:n].copy())
                x = end if done >= cell.length_m else x + sign * done
            if w <= 0.0 or self._is_over(x, w, under):
                break
        x_m, speeds = np.concatenate(xs), np.concatenate(ws)
        order = slice(None, None, -1) if sign < 0.0 else slice(None)
        return Curve(x_m[order], speeds[order]), held

    def _cell(self, k: int, length_m: float) -> Cell:
        """A cell, as long as is left of it."""
        own = self.cells
        ends = float(own.station_m[k]), float(own.station_m[k + 1])
        return Cell(*ends, length_m, float(own.grade_n[k]), float(own.air[k]), float(own.limit_w[k]))

    def _is_over(self, x_m: float, w: float, under: Curve) -> bool:
        """Whether a curve is left upwards."""
        return w >= under.at(x_m) * (1.0 + _SAME)
