"""What people see of a search: a line of progress, and a short table."""

import sys
from collections.abc import Mapping, Sequence
from typing import Any

import click

ROWS = 12
_CLEAR_LINE = "\r\x1b[K"


class Screen:
    """A line of progress on stderr, at a terminal only."""

    def __init__(self, *, quiet: bool) -> None:
        self._live = not quiet and sys.stderr.isatty()

    def progress(self, text: str) -> None:
        """Say what is being done, in place of what was being done before."""
        if self._live:
            click.echo(f"{_CLEAR_LINE}{text} …", err=True, nl=False)

    def __enter__(self) -> "Screen":
        return self

    def __exit__(self, *_: object) -> None:
        """Leave no line behind, whatever follows: a table, or an error."""
        if self._live:
            click.echo(_CLEAR_LINE, err=True, nl=False)


def front_table(content: Mapping[str, Any]) -> str:
    """A dozen rows of the front at most, its two ends included, of an object of schema tgvdp.search/1."""
    front = content["front"]
    # Figures that no point has get no column: prices of the methods on a grid, gaps without a certificate.
    priced, certified = (any(point[name] is not None for point in front) for name in ("price_kwh_per_min", "gap_pct"))
    head = f"{'margin':>8}  {'time':>12}  {'delay':>10}  {'energy':>14}  {'saved':>8}"
    lines = [head + "   kWh/min" * priced + f"  {'bound':>14}  {'gap':>8}" * certified]
    for index in spread(len(front), ROWS):
        point = front[index]
        row = (
            f"{point['margin_pct']:6.2f} %  {duration(point['time_s']):>12}  {point['delay_s']:8.5g} s"
            f"  {point['energy_kwh']:10.5g} kWh  {point['saved_pct']:6.2f} %"
        )
        if priced:
            price = point["price_kwh_per_min"]
            row += f"  {'–' if price is None else format(price, '.4g'):>8}"  # the fastest run has no price
        if certified:
            bound, gap = point["lower_bound_kwh"], point["gap_pct"]  # none where the time was up
            row += f"  {'–':>14}  {'–':>8}" if gap is None else f"  {bound:10.5g} kWh  {gap:6.3f} %"
        lines.append(row)
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


_MODELS = {"wheel": "at the wheel", "pantograph": "at the pantograph"}


def energy_table(content: Mapping[str, Any]) -> str:
    """Where the energy of three runs goes, of an object of schema tgvdp.search/1; empty where that says nothing."""
    model = content["energy"]
    front = content["front"]
    runs = {"fastest run": content["fastest"]["balance"]}
    runs |= {f"{front[i]['margin_pct']:.2f} %": front[i]["balance"] for i in spread(len(front), 3)[1:]}
    telling = any(abs(one["pantograph_kwh"] - one["wheel_kwh"]) > 1e-9 * abs(one["wheel_kwh"]) for one in runs.values())
    if not telling:
        return ""
    heads = [name.removesuffix("_kwh").replace("_", " ") for name in next(iter(runs.values()))]
    lines = [f"energy {_MODELS.get(model['model']) or 'by map ' + model['map']}; where it goes, kWh:"]
    lines.append(f"{'':>12}" + "".join(f"  {head:>14}" for head in heads))
    for name, balance in runs.items():
        lines.append(f"{name:>12}" + "".join(f"  {value:14.5g}" for value in balance.values()))
    faults = model.get("violations", ())
    if faults:
        worst = faults[0]
        lines.append(
            f"the map breaks the conservation of energy at {len(faults)} of its nodes, worst at"
            f" {worst['speed_kmh']:.4g} km/h and demand {worst['demand']:g}: it draws {worst['drawn_kw']:.4g} kW,"
            f" where the wheel leaves no less than {worst['at_least_kw']:.4g} kW"
        )
    return "\n".join(lines)


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
