"""Extremals of one trip: at a multiplier, and at a running time."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.methods.extremal.command import AT, BOUND, COMMAND_COLUMNS, HOLDS_FROM
from tgvdp.methods.extremal.commands import extract
from tgvdp.methods.extremal.course import course_of, held_speeds
from tgvdp.methods.extremal.follow import follow_run
from tgvdp.methods.extremal.lift import lift
from tgvdp.methods.extremal.newton import newton
from tgvdp.methods.extremal.rows import Rows
from tgvdp.methods.extremal.structure import amend, coast_before_brakes, cross, shorten
from tgvdp.methods.extremal.thin import thin
from tgvdp.methods.extremal.work import MOST_COMMANDS, work_of
from tgvdp.model.trip import Trip
from tgvdp.physics.energy import energy_tables

Floats = NDArray[np.float64]

_ROUNDS = 3
#: Runs to rest at a multiplier, and to a running time, at most.
_MOST_TO_REST = 24
_MOST_TO_MEET = 10
#: Durations, as shares of the running time but no more than so many seconds: of phases that are absorbed when commands
#: are told from a run, or dropped, and of contradictions of the costate and holds by the brakes that count.
_SHARE = 2e-3
_ABSORBED_S, _DROPPED_S, _NOTED_S, _HELD_S = 1.5, 1.0, 0.3, 5.0
_SAME_END = 1e-6
#: Share of w around a run within which commands follow it.
_BAND = 0.04


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


def unbound(commands: Floats) -> Floats:
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
        size = len(self.work.whole.x)
        self.kept = np.empty(size), np.empty(size), np.empty(size, dtype=np.int8), np.empty(2 * size, dtype=np.int64)
        self.rows = 0
        self.runs = 0

    def _seconds(self, most_s: float) -> float:
        """A short duration, by the fastest running time."""
        return min(most_s, _SHARE * most_s * float(self.course.duration.sum()))

    def _hold(self, price: float) -> float:
        per_unit = price / self.unit_j
        held_speeds(self.train, self.course.air, self.course.returned, per_unit, self.levels)
        return per_unit

    def commands_of(self, x_m: Floats, w: Floats, price: float, short_s: float = _ABSORBED_S) -> Floats | None:
        """Commands of a run that was found otherwise, and such as keep to it."""
        self._hold(price)
        if len(x_m) > len(self.cell):
            self.cell = np.zeros(2 * len(x_m), dtype=np.int64)
        count = extract(
            self.train, self.course, self.levels, x_m, w, len(x_m), self._seconds(short_s), self.cell, self.phases,
            self.commands,
        )  # fmt: skip
        if count <= 0:
            return None
        count, runs = follow_run(
            self.train, self.course, self.levels, x_m, w, len(x_m), _BAND, self.start_w, self.work, self.commands, count
        )
        self.runs += runs
        return self.commands[:count].copy()

    def _found(self, count: int, price: float, n: int, happened: int, rests: bool) -> Extremal | None:
        self.rows = n
        whole = self.work.whole
        if whole.w[n - 1] < self.course.w[-1] * (1.0 - _SAME_END):
            return None  # too slow for the end speed
        return Extremal(
            self.commands[:count].copy(), price, float(whole.time[n - 1]), float(whole.energy[n - 1]) * self.unit_j,
            rests, self.work.events[:happened].copy(),
        )  # fmt: skip

    def rest(self, commands: Floats, price: float, most_runs: int = _MOST_TO_REST) -> Extremal | None:
        """Newton's steps from commands at a multiplier; 1 run drives them as they are."""
        return self._newton(commands, price, math.inf, math.inf, 0.0, most_runs)[0]

    def _newton(
        self, commands: Floats, price: float, target_s: float, next_s: float, tolerance_s: float, most_runs: int
    ) -> tuple[Extremal | None, int, float]:
        """What `newton` finds; the number of commands, and the price that is foreseen for the next running time."""
        count = len(commands)
        self.commands[:count] = commands
        n, happened, count, per_unit, next_unit, runs, rests = newton(
            self.train, self.course, self.levels, self.commands, count, self.start_w, price / self.unit_j, target_s,
            next_s, tolerance_s, self._seconds(_DROPPED_S), most_runs, self.work,
        )  # fmt: skip
        self.runs += runs
        if n <= 0:
            return None, count, price
        return self._found(count, per_unit * self.unit_j, n, happened, rests), count, next_unit * self.unit_j

    def drive(self, commands: Floats, price: float) -> Extremal | None:
        """The run of commands as they are, and its sweep."""
        return self.rest(commands, price, 1)

    def at_price(self, commands: Floats, price: float) -> Extremal | None:
        """Come to rest at a multiplier, and command what had to happen without a command."""
        best = self.rest(commands, price)
        for _ in range(_ROUNDS):
            if best is None or not len(best.events):
                break
            given = self._with_events(best)
            if given is None:
                break
            found = self.rest(given, price)
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
            commands.insert(at, [regime, x, math.inf if w > 0.0 else x, 0.0, -1.0])
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
        allowance = 5e-10 * abs(better.cost_j(price)) + max(bias, 0.0)
        if mixed is None or mixed.cost_j(price) > better.cost_j(price) + allowance:
            return self._again(better)
        found = self.rest(mixed.commands, price)
        return found if found is not None else self._again(better)

    def _again(self, found: Extremal) -> Extremal:
        """Make the last run that of an extremal."""
        self.drive(found.commands, found.price)
        return found

    def settle(self, candidates: list[Floats], price: float, most_j: float) -> Extremal | None:
        """Descend from each of some commands, take the best stretches, and add and drop phases as long as that pays.

        None if the best of them costs more than ``most_j``.
        """
        best: Extremal | None = None
        rows = self.work.whole, 0
        for candidate in candidates:
            found = self.at_price(unbound(candidate), price)
            if found is None:
                continue
            best = found if best is None else self.best_of(best, rows, found, price)
            rows = self.run()
        if best is None or best.cost_j(price) > most_j:
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

    def shorter(self, found: Extremal, least_s: float = _DROPPED_S) -> Floats | None:
        """Commands of the run that was found last without its phases that are too short; None if there are none."""
        self.commands[: len(found.commands)] = found.commands
        size = shorten(
            self.commands, len(found.commands), self.work.whole, self.rows, self.work.starts, self._seconds(least_s),
            self.out,
        )  # fmt: skip
        return self.out[:size].copy() if size < len(found.commands) else None

    def kept_rows(self) -> tuple[Floats, Floats, NDArray[np.int8], float]:
        """Rows of the run that was found last: positions, squared speeds, the regime along each but the last.

        And the largest share by which one passes its effort limit.
        """
        size, excess = thin(self.train, self.course, self.work.whole, self.rows, *self.kept)
        x_m, w, regime, _ = self.kept
        return x_m[:size].copy(), w[:size].copy(), regime[: size - 1].copy(), excess

    def meet(
        self, commands: Floats, price: float, target_s: float, next_s: float, tolerance_s: float
    ) -> tuple[Extremal | None, Floats, float]:
        """The extremal of a running time from commands and a multiplier near it; those foreseen for the next time."""
        found, count, next_price = self._newton(commands, price, target_s, next_s, tolerance_s, _MOST_TO_MEET)
        return found, self.work.trial[:count].copy(), next_price
