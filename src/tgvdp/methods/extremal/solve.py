"""Extremals of one trip: at a multiplier, and at a running time."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.methods.extremal.commands import extract
from tgvdp.methods.extremal.course import course_of, held_speeds, worst_excess
from tgvdp.methods.extremal.newton import MOST_COMMANDS, descend, work_of
from tgvdp.methods.extremal.simulate import AT, BOUND, COMMAND_COLUMNS, ENVELOPE, HOLDS_FROM, Rows, simulate
from tgvdp.methods.extremal.structure import amend, coast_before_brakes, cross, shorten
from tgvdp.methods.extremal.sweep import ACTIVE, lift
from tgvdp.model.trip import Trip
from tgvdp.physics.energy import energy_tables

Floats = NDArray[np.float64]

_MOST_ROUNDS = 2
_ROUNDS = 3
#: Durations, as shares of the running time but no more than so many seconds: of phases that are absorbed when commands
#: are told from a run, or dropped, and of contradictions of the costate and holds by the brakes that count.
_SHARE = 2e-3
_ABSORBED_S, _DROPPED_S, _NOTED_S, _HELD_S = 1.5, 1.0, 0.3, 5.0
_SAME_END = 1e-6
#: Rows shorter than this share of the distance are none.
_SLIVER = 1e-9
#: ... and rows shorter than this share of the one before, at an effort that differs by less than this share.
_SHORT_ROW = 0.05
_SAME_EFFORT = 0.01


class Extremal(NamedTuple):
    """Commands at a multiplier: time, energy without auxiliaries in J, λ in J/s with them, rows and events."""

    commands: Floats
    price: float
    time_s: float
    energy_j: float
    rests: bool
    events: Floats

    def cost_j(self, price: float) -> float:
        """Cost E + λT at a multiplier, J."""
        return self.energy_j + price * self.time_s


def _unbound(commands: Floats) -> Floats:
    """Commands for another multiplier, at which no switch is known to be bound."""
    free = commands.copy()
    free[:, BOUND] = 0.0
    return free


@dataclass
class Solver:
    """Room and constants for the extremals of one trip; energies without auxiliaries, prices with them."""

    trip: Trip

    def __post_init__(self) -> None:
        self.train, self.course = course_of(self.trip)
        self.tables = energy_tables(self.trip.train, self.trip.energy)
        self.unit_j = self.tables.traction * self.trip.train.inertia_kg
        self.work = work_of(max(20000, 40 * len(self.course.x_m)))
        self.levels = np.empty((len(self.course.grade), 3))
        self.commands = np.zeros((MOST_COMMANDS, COMMAND_COLUMNS))
        self.start_w = self.trip.start_speed_mps**2
        self.cell = np.zeros(20000, dtype=np.int64)
        self.phases = np.zeros((2000, 5))
        self.out = np.zeros((MOST_COMMANDS, COMMAND_COLUMNS))
        self.rows = 0
        self.runs = 0
        self.excess = 0.0

    def _seconds(self, most_s: float) -> float:
        """A short duration, by the fastest running time."""
        return min(most_s, _SHARE * most_s * float(self.course.duration.sum()))

    def _hold(self, price: float) -> float:
        per_unit = price / self.unit_j
        held_speeds(self.train, self.course.air, self.course.returned, per_unit, self.levels)
        return per_unit

    def commands_of(self, x_m: Floats, w: Floats, price: float, short_s: float = _ABSORBED_S) -> Floats | None:
        """Commands of a run that was found otherwise."""
        self._hold(price)
        if len(x_m) > len(self.cell):
            self.cell = np.zeros(2 * len(x_m), dtype=np.int64)
        count = extract(
            self.train,
            self.course,
            self.levels,
            x_m,
            w,
            len(x_m),
            self._seconds(short_s),
            self.cell,
            self.phases,
            self.commands,
        )
        return self.commands[:count].copy() if count > 0 else None

    def drive(self, commands: Floats, price: float) -> Extremal | None:
        """The run of commands as they are."""
        self._hold(price)
        count = len(commands)
        self.commands[:count] = commands
        n, happened = simulate(
            self.train, self.course, self.levels, self.commands, count, self.start_w, self.work.whole,
            self.work.starts, self.work.events,
        )  # fmt: skip
        self.runs += 1
        return self._found(count, price, n, happened, False)

    def _found(self, count: int, price: float, n: int, happened: int, rests: bool) -> Extremal | None:
        if n < 0:
            return None
        self.rows = n
        whole = self.work.whole
        if whole.w[n - 1] < self.course.w[-1] * (1.0 - _SAME_END):
            return None  # too slow for the end speed
        return Extremal(
            self.commands[:count].copy(), price, float(whole.time[n - 1]), float(whole.energy[n - 1]) * self.unit_j,
            rests, self.work.events[:happened].copy(),
        )  # fmt: skip

    def descend(self, commands: Floats, price: float, rounds: int = _MOST_ROUNDS) -> Extremal | None:
        """Descend from commands at a multiplier."""
        per_unit = self._hold(price)
        count = len(commands)
        self.commands[:count] = commands
        n, happened, done, rests = descend(
            self.train, self.course, self.levels, per_unit, self.commands, count, self.start_w, self.work, rounds
        )
        self.runs += done
        return self._found(count, price, n, happened, rests)

    def at_price(self, commands: Floats, price: float) -> Extremal | None:
        """Descend, and command what had to happen without a command."""
        best = self.descend(commands, price)
        for _ in range(_ROUNDS):
            if best is None or not len(best.events):
                break
            given = self._with_events(best)
            if given is None:
                break
            found = self.descend(given, price)
            if found is None or found.cost_j(price) > best.cost_j(price) - 1e-9 * abs(best.cost_j(price)):
                break
            best = found
        return best

    def _with_events(self, found: Extremal) -> Floats | None:
        commands = found.commands.tolist()
        added = False
        for regime, x, w in found.events.tolist():
            if w > 0.0:  # braking begins after as much coasting as takes p from −1/2 to 0
                before = max(row[AT] for row in commands if row[AT] <= x)
                x = max(x - w**1.5 / (found.price / self.unit_j), 0.5 * (before + x))
            at = int(np.searchsorted([row[AT] for row in commands], x, side="right"))
            if len(commands) >= MOST_COMMANDS:
                return None
            commands.insert(at, [regime, x, math.inf if w > 0.0 else x, 0.0])
            added = True
        return np.array(commands) if added else None

    def run(self) -> tuple[Rows, int]:
        """A copy of the run that was found last."""
        n, whole = self.rows, self.work.whole
        return (
            Rows(
                whole.x[:n].copy(), whole.w[:n].copy(), whole.time[:n].copy(), whole.energy[:n].copy(),
                whole.effort[:n].copy(), whole.regime[:n].copy(), whole.cell[:n].copy(),
            ),
            n,
        )  # fmt: skip

    def best_of(
        self, one: Extremal, rows: tuple[Rows, int], other: Extremal, price: float, bias: float = 0.0
    ) -> Extremal:
        """The cheaper of two extremals of a multiplier on each stretch; the last run is that of ``other``.

        Returns one of the two where nothing better comes of it; the last run is that of what is returned.
        """
        per_unit = self._hold(price)
        for commands in (one.commands, other.commands):
            if len(commands) >= MOST_COMMANDS:
                return one
        size, taken = cross(
            self.train, self.course, per_unit, *rows, one.commands, len(one.commands), self.work.whole, self.rows,
            other.commands, len(other.commands), bias / self.unit_j, self.out,
        )  # fmt: skip
        better = other if other.cost_j(price) < one.cost_j(price) + bias else one
        if taken < 0:
            return other
        if taken == 0:
            return self._again(one)
        mixed = self.drive(self.out[:size].copy(), price)
        allowance = 1e-9 * abs(better.cost_j(price)) + max(bias, 0.0)
        if mixed is None or mixed.cost_j(price) > better.cost_j(price) + allowance:
            return self._again(better)
        found = self.descend(mixed.commands, price)
        return found if found is not None else self._again(better)

    def _again(self, found: Extremal) -> Extremal:
        """Make the last run that of an extremal."""
        self.descend(found.commands, found.price, 0)
        return found

    def settle(self, candidates: list[Floats], price: float) -> Extremal | None:
        """Descend from each of some commands, take the best stretches, and add and drop phases as long as that pays."""
        best: Extremal | None = None
        rows = self.work.whole, 0
        for candidate in candidates:
            found = self.at_price(_unbound(candidate), price)
            if found is None:
                continue
            best = found if best is None else self.best_of(best, rows, found, price)
            rows = self.run()
        if best is None:
            return None
        size, added = coast_before_brakes(
            self.course, price / self.unit_j, best.commands, len(best.commands), *rows, self.work.starts,
            self._seconds(_HELD_S), self.out,
        )  # fmt: skip
        trials = [self.out[:size].copy()] if added else []
        held = best.commands.copy()
        held[:, HOLDS_FROM] = held[:, AT]
        if (held[:-1] != best.commands[:-1]).any():
            trials.append(held)
        for commands in trials:
            other = self.at_price(commands, price)
            best = self._again(best) if other is None else self.best_of(best, rows, other, price)
            rows = self.run()
        for share in (1.0, 0.4):
            for _ in range(2):
                rows = self.run()
                lift(
                    self.train, self.course, best.commands, len(best.commands), self.work.whole, self.rows,
                    self.work.starts, self.work.pinned, self.work.found, self.work.p_at,
                )  # fmt: skip
                size, added = amend(
                    self.course, best.commands, len(best.commands), *rows, self.work.starts, self.work.p_at,
                    self._seconds(_NOTED_S), 0.003, share, self.out,
                )  # fmt: skip
                if added == 0:
                    return self.prune(best, price)
                other = self.at_price(self.out[:size].copy(), price)
                if other is None:
                    best = self._again(best)
                    break
                before = best.cost_j(price)
                best = self.best_of(best, rows, other, price)
                if best.cost_j(price) > before - 1e-8 * abs(before):
                    break
        return self.prune(best, price)

    def prune(self, best: Extremal, price: float, short_s: float = _DROPPED_S, loss: float = 1e-6) -> Extremal:
        """Drop phases that are too short, where that costs little."""
        rows = self.run()
        self.commands[: len(best.commands)] = best.commands
        size = shorten(best.commands, len(best.commands), *rows, self.work.starts, self._seconds(short_s), self.out)
        if size == len(best.commands):
            return best
        other = self.at_price(self.out[:size].copy(), price)
        if other is None:
            return self._again(best)
        return self.best_of(best, rows, other, price, loss * abs(best.energy_j))

    def kept_rows(self) -> tuple[Floats, Floats, NDArray[np.int64]]:
        """Rows of the run that was found last: positions, squared speeds, and the regime along each but the last.

        Rows that are too short to drive are left out, but not those at breaks of the line, and rows of the envelope are
        whole.
        """
        whole, n = self.work.whole, self.rows
        x_m = whole.x[:n]
        fixed = np.isin(x_m, self.course.station_m)
        fixed[0] = fixed[-1] = True
        keep = np.ones(n, dtype=np.bool_)
        # Commands that change nothing cut rows of the envelope, whose efforts are right as means alone.
        rides = whole.regime[:n] == ENVELOPE
        keep[1:-1] = ~(rides[1:-1] & rides[2:]) | fixed[1:-1] | np.isin(x_m[1:-1], self.course.x_m)
        last = 0
        for i in np.flatnonzero(keep)[1:].tolist():
            if x_m[i] - x_m[last] < _SLIVER * self.trip.distance_m:
                drop = i if not fixed[i] else last
                keep[drop] = fixed[drop]
            last = i if keep[i] else last
        self._merge(keep, fixed)
        regime = whole.regime[:n][keep]
        self.excess = worst_excess(
            self.train, self.course.grade, self.course.air, whole.cell[:n][keep], x_m[keep], whole.w[:n][keep]
        )
        return x_m[keep], whole.w[:n][keep], regime[1:].copy()

    def _merge(self, keep: NDArray[np.bool_], fixed: NDArray[np.bool_]) -> None:
        """Let short rows be part of those before, at the same effort: they join the envelope within one of its own."""
        x_m, effort = self.work.whole.x, self.work.whole.effort
        nodes = np.flatnonzero(keep)
        for before, node, after in zip(nodes[:-2].tolist(), nodes[1:-1].tolist(), nodes[2:].tolist(), strict=True):
            short = x_m[after] - x_m[node] < _SHORT_ROW * (x_m[node] - x_m[before])
            same = abs(effort[after] - effort[node]) < _SAME_EFFORT * abs(effort[node])
            if short and same and keep[before] and not fixed[node]:
                keep[node] = False

    def meet(
        self, commands: Floats, price: float, slope: float, target_s: float, tolerance_s: float
    ) -> Extremal | None:
        """The extremal of a running time: a bracketed secant on ln λ; ``slope`` is dT/dlnλ."""
        slow = fast = None
        last = None
        found: Extremal | None = None
        commands = _unbound(commands)
        for turn in range(14):
            found = self.at_price(commands, price)
            if found is None:
                return None
            miss = found.time_s - target_s
            if abs(miss) <= tolerance_s:
                return found
            if last is not None and price != last[0]:
                secant = (found.time_s - last[1]) / math.log(price / last[0])
                if secant < 0.0:
                    slope = secant
            last = (price, found.time_s)
            commands = _unbound(found.commands)
            if miss > 0.0:
                slow = (price, miss)
            else:
                fast = (price, miss)
            step = -miss / slope
            step = min(max(step, -0.3), 0.3)
            new = price * math.exp(step)
            if slow and fast:
                lo, hi = math.log(slow[0]), math.log(fast[0])
                if hi <= lo or hi - lo < 1e-9:
                    return self.close(found, target_s, tolerance_s)
                if not lo < math.log(new) < hi or turn > 7:
                    new = math.exp(0.5 * (lo + hi))
            price = new
        return None if found is None else self.close(found, target_s, tolerance_s)

    def close(self, found: Extremal, target_s: float, tolerance_s: float) -> Extremal | None:
        """Meet the time by the last free switch: dE = −λ dT whichever is moved."""
        for i in range(len(found.commands) - 1, 0, -1):
            if self.work.found[i, ACTIVE] == 0.0 or self.work.pinned[i]:
                continue
            commands = found.commands.copy()
            x0, t0 = commands[i, AT], found.time_s
            xa, ta = x0, t0
            commands[i, AT] = x0 + 1e-5 * self.trip.distance_m
            for _ in range(8):
                now = self.drive(commands, found.price)
                if now is None:
                    break
                if abs(now.time_s - target_s) < tolerance_s:
                    return now
                xb, tb = commands[i, AT], now.time_s
                if tb == ta:
                    break
                new = xb + (target_s - tb) * (xb - xa) / (tb - ta)
                if (
                    abs(new - x0) > 0.01 * self.trip.distance_m
                    or new <= commands[i - 1, AT]
                    or (i + 1 < len(commands) and new >= commands[i + 1, AT])
                ):
                    break
                xa, ta = xb, tb
                commands[i, AT] = new
            self.descend(found.commands, found.price, 0)
        return None
