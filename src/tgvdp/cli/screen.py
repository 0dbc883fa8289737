"""What people see of a search: a line of progress, and a short table."""

import contextlib
import math
import sys
import textwrap
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import click

ROWS = 12
#: Numbers that are smaller than so many decimals show are written with an exponent.
_MOST_DECIMALS = 4
#: Time between two looks at the clock while kernels are compiled, s.
_TICK_S = 1.0
#: Columns of a terminal that text takes.
_WIDTH = 80
_CLEAR_LINE = "\r\x1b[K"


class Screen:
    """A line of progress on stderr, at a terminal only."""

    def __init__(self, *, quiet: bool) -> None:
        self._quiet = quiet
        self._live = not quiet and sys.stderr.isatty()
        self._text = ""
        self._waits = 0  # compilations that go on
        self._waiting_since: float | None = None
        self._said: set[str] = set()
        self._lock = threading.Lock()
        self._done = threading.Event()

    def progress(self, text: str) -> None:
        """Say what is being done, in place of what was being done before."""
        self._text = text
        self._show()

    @contextlib.contextmanager
    def timing(self, what: str) -> Iterator[None]:
        """Say for how long something has been going on, while it is."""
        if not self._live:
            yield
            return
        started = time.perf_counter()
        ended = threading.Event()

        def tick() -> None:
            while not ended.wait(_TICK_S):
                self.progress(f"{what}: {time.perf_counter() - started:.0f} s")

        threading.Thread(target=tick, daemon=True).start()
        try:
            yield
        finally:
            ended.set()

    @contextlib.contextmanager
    def compiling(self) -> Iterator[None]:
        """Say that kernels are compiled, while they are, and for how long it has been: once, for they are kept."""
        if not self._live:
            yield
            return
        from tgvdp.api.warm import watch

        with watch(self._wait):
            yield

    @contextlib.contextmanager
    def waiting(self) -> Iterator[None]:
        """Say the same while kernels are compiled elsewhere."""
        self._wait(True)
        try:
            yield
        finally:
            self._wait(False)

    def _wait(self, on: bool) -> None:
        self._waits += 1 if on else -1
        if self._live and on and self._waiting_since is None:
            self._waiting_since = time.perf_counter()
            threading.Thread(target=self._tick, daemon=True).start()
        self._show()

    def _tick(self) -> None:
        while not self._done.wait(_TICK_S):
            self._show()

    def _show(self) -> None:
        with self._lock:
            if self._live and not self._done.is_set():
                text = self._text
                if self._waits and self._waiting_since is not None:
                    text = f"compiling, once: {time.perf_counter() - self._waiting_since:.0f} s"
                click.echo(f"{_CLEAR_LINE}{text} …", err=True, nl=False)

    def note(self, text: str) -> None:
        """Say something that stays, on stderr, once: several trains share a line."""
        if not self._quiet and text not in self._said:
            self._said.add(text)
            with self._lock:
                click.echo(f"{_CLEAR_LINE * self._live}tgvdp: note: {text}", err=True)

    def __enter__(self) -> "Screen":
        return self

    def __exit__(self, *_: object) -> None:
        """Leave no line behind, whatever follows: a table, or an error."""
        with self._lock:
            self._done.set()
            if self._live:
                click.echo(_CLEAR_LINE, err=True, nl=False)


def front_table(content: Mapping[str, Any]) -> str:
    """A dozen rows of the front at most, its two ends included, of an object of schema tgvdp.search/1."""
    front = content["front"]
    rows = [front[index] for index in spread(len(front), ROWS)]
    columns = [
        column("margin", "%", 8, [f"{point['margin_pct']:.2f}" for point in rows]),
        column("time", "", 9, [duration(point["time_s"]) for point in rows]),
        column("delay", "s", 7, aligned([point["delay_s"] for point in rows], 4)),
        column("energy", "kWh", 8, aligned([point["energy_kwh"] for point in rows], 5)),
        column("saved", "%", 6, [f"{point['saved_pct']:.2f}" for point in rows]),
    ]
    # Figures that no point has get no column: prices of the methods on a grid, gaps without a certificate.
    if any(point["price_kwh_per_min"] is not None for point in rows):  # the fastest run has none
        columns.append(column("price", "kWh/min", 7, aligned([point["price_kwh_per_min"] for point in rows], 4)))
    if any(point["gap_pct"] is not None for point in rows):  # none where the time was up
        gaps_kwh = [
            None if point["lower_bound_kwh"] is None else point["energy_kwh"] - point["lower_bound_kwh"]
            for point in rows
        ]
        gaps_pct = ["–" if point["gap_pct"] is None else f"{point['gap_pct']:.3f}" for point in rows]
        columns += [column("gap", "%", 6, gaps_pct), column("gap", "kWh", 6, aligned(gaps_kwh, 3))]
    lines = ["  ".join(cells) for cells in zip(*columns, strict=True)]
    fastest = content["fastest"]
    lines.append(
        f"fastest run {duration(fastest['time_s'])}, {fastest['energy_kwh']:.5g} kWh;"
        f" {len(front)} {'point' if len(front) == 1 else 'points'} on the front"
    )
    if (stepped_s := fastest["stepped_time_s"]) is not None:
        lines.append(
            f"  by the explicit steps of the convention {stepped_s:.2f} s, converged {fastest['time_s']:.2f} s"
        )
    return "\n".join(lines)


def column(head: str, unit: str, width: int, cells: Sequence[str]) -> list[str]:
    """Cells of one width, right-aligned below their head and unit."""
    texts = [head, unit, *cells]
    width = max(width, *map(len, texts))
    return [f"{text:>{width}}" for text in texts]


def aligned(values: Sequence[float | None], digits: int) -> list[str]:
    """Numbers with the same number of decimals, so many digits in the largest; a dash for None."""
    largest = max((abs(value) for value in values if value is not None), default=0.0)
    exponent = math.floor(math.log10(largest)) if largest > 0.0 else 0
    if exponent < -_MOST_DECIMALS:  # a toy
        return ["–" if value is None else f"{value:.{digits - 1}e}" for value in values]
    decimals = min(max(digits - 1 - exponent, 0), _MOST_DECIMALS + digits)
    return ["–" if value is None else f"{value:.{decimals}f}" for value in values]


def power_and_cost(content: Mapping[str, Any]) -> str:
    """Peak power at the wheel, and by the tariff cost and CO2, of the fastest and of the thriftiest run."""
    first, last = content["fastest"], content["front"][-1]
    figures = [("peak power at the wheel", "peak_power_kw", "kW"), ("cost", "cost_eur", "€"), ("CO2", "co2_kg", "kg")]
    parts = [
        f"{name} {' → '.join(aligned([first[field], last[field]], 5))} {unit}"
        for name, field, unit in figures
        if field in first
    ]
    return "fastest → thriftiest run: " + "; ".join(parts)


_MODELS = {"wheel": "at the wheel", "pantograph": "at the pantograph"}


def energy_table(content: Mapping[str, Any]) -> str:
    """Where the energy of three runs goes, of an object of schema tgvdp.search/1; empty where that says nothing."""
    model = content["energy"]
    front = content["front"]
    runs = {"fastest run": content["fastest"]["balance"]}
    summed_up = [point for point in front if point["balance"]["wheel_kwh"] is not None]
    shown = sorted({len(summed_up) // 2, len(summed_up) - 1}) if summed_up else ()
    runs |= {f"{summed_up[i]['margin_pct']:.2f} %": summed_up[i]["balance"] for i in shown}
    telling = any(abs(one["pantograph_kwh"] - one["wheel_kwh"]) > 1e-9 * abs(one["wheel_kwh"]) for one in runs.values())
    if not telling:
        return ""
    heads = [name.removesuffix("_kwh").replace("_", " ") for name in next(iter(runs.values()))]
    lines = [f"energy {_MODELS.get(model['model']) or 'by map ' + model['map']}; where it goes, kWh:"]
    table = [value for balance in runs.values() for value in balance.values()]
    cells = iter(aligned(table, 5))
    columns = [column("", "", 11, list(runs))[1:]]
    rows = [[next(cells) for _ in heads] for _ in runs]
    columns += [column("", head, 9, [row[index] for row in rows])[1:] for index, head in enumerate(heads)]
    lines += ["  ".join(line) for line in zip(*columns, strict=True)]
    faults = model.get("violations", ())
    if faults:
        worst = faults[0]
        lines.append(
            f"the map breaks the conservation of energy at {len(faults)} of its nodes, worst at"
            f" {worst['speed_kmh']:.4g} km/h and demand {worst['demand']:g}: it draws {worst['drawn_kw']:.4g} kW,"
            f" where the wheel leaves no less than {worst['at_least_kw']:.4g} kW"
        )
    return "\n".join(lines)


def advice_line(content: Mapping[str, Any]) -> str:
    """What a driver does in the middle run of an object of schema tgvdp.search/1."""
    told = [run for run in content["front"] if run["advice"] is not None]
    if not told:
        return wrapped(f"how to drive the fastest run: {content['fastest']['advice']}")
    run = told[len(told) // 2]
    return wrapped(f"how to drive at {run['margin_pct']:.2f} %: {run['advice']}")


def wrapped(text: str, indent: str = "") -> str:
    """A text in lines of a terminal, indented but for the first."""
    return textwrap.fill(text, _WIDTH, initial_indent=indent, subsequent_indent=f"{indent}  ")


def spread(count: int, most: int) -> Sequence[int]:
    """At most ``most`` indices of ``range(count)``, evenly spread, first and last included."""
    if count <= most:
        return range(count)
    return [round(i * (count - 1) / (most - 1)) for i in range(most)]


def duration(time_s: float) -> str:
    """A duration as people write it: ``0.71 s``, ``2:05.3``, ``1:07:09.0``."""
    if time_s < 60.0:
        return f"{time_s:.3g} s"
    tenths = round(10.0 * time_s)
    minutes, rest = divmod(tenths, 600)
    hours, minutes = divmod(minutes, 60)
    clock = f"{minutes:02d}:{rest / 10:04.1f}" if hours else f"{minutes}:{rest / 10:04.1f}"
    return f"{hours}:{clock}" if hours else clock
