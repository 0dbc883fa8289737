"""What a finished sweep says about its network: what a margin saves, where, and on what that depends."""

import contextlib
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.errors import InputError, MissingExtraError
from tgvdp.report.files import require_folder
from tgvdp.report.read_off import TELLING_PCT, Front, Read
from tgvdp.sweeps.tables import SCHEMAS

SCHEMA = "tgvdp.sweep-report/1"
_Floats = NDArray[np.float64]
#: Columns of ``scenarios.parquet`` between which the parameters stand.
_BEFORE, _BEHIND = "to_m", "status"
_PLACES = ("train", "line", "section")
_FIGURES = ("scenario", "fastest_energy_kwh", "asked_margin_pct")
#: Shares of the scenarios below each shown saving, in percent.
SHARES_PCT = (5, 25, 50, 75, 95)
#: Of a margin that fronts were asked for as a running time.
_ROUNDING = 1e-9


class Savings(NamedTuple):
    """What a margin saves, per scenario that is done.

    Attributes
    ----------
    margin_pct : float
    number : (n,) int64
        Of the scenario.
    fastest_kwh, energy_kwh : (n,) float64
        Of the fastest run, and with the margin.
    axes : mapping of str to list
        Train, line, section and parameters of each, by their names, without what does not vary.
    counts : mapping of str to int
        Scenarios of each status, those that are not done, too.
    at_most_above_pct : (n,) float64
        How far above its front ``energy_kwh`` may lie, as it is read off a straight line between two points, %.
    """

    margin_pct: float
    number: NDArray[np.int64]
    fastest_kwh: _Floats
    energy_kwh: _Floats
    axes: Mapping[str, list[Any]]
    counts: Mapping[str, int]
    at_most_above_pct: _Floats

    @property
    def saved_kwh(self) -> _Floats:
        """What is saved, (n,)."""
        return self.fastest_kwh - self.energy_kwh

    @property
    def saved_pct(self) -> _Floats:
        """What is saved of the fastest run's energy, (n,); 0 where that needs none."""
        needed = np.abs(self.fastest_kwh)
        return np.divide(100.0 * self.saved_kwh, needed, out=np.zeros(len(needed)), where=needed > 0.0)


class Level(NamedTuple):
    """Scenarios that have one value on one axis: their saving altogether, and its mean over them."""

    value: Any
    scenarios: int
    fastest_kwh: float
    saved_kwh: float
    saved_pct: float


def read_savings(folder: Path, margin_pct: float) -> Savings:
    """Read a finished sweep, and interpolate each front, which begins with the fastest run, at a margin.

    A front that ends before a margin that it was asked for ends with the thriftiest run: running longer saves nothing.

    Raises
    ------
    InputError
        When the folder holds no finished sweep, nothing in it is done, or a front was not asked for the margin.
    """
    try:
        parquet = import_module("pyarrow.parquet")
    except ImportError:
        raise MissingExtraError("reports of sweeps need pyarrow: pip install 'tgvdp[sweep]'") from None
    require_folder(folder)
    path = folder / "scenarios.parquet"
    if not path.is_file():
        raise InputError(f"{folder}: holds no finished sweep: there is no {path.name}")
    with _readable(path):
        table = parquet.read_table(path)
    schema = (table.schema.metadata or {}).get(b"schema", b"no schema").decode()
    if schema != SCHEMAS["scenarios"]:
        raise InputError(f"{path}: is of {schema}, this version reads {SCHEMAS['scenarios']}")
    names = table.column_names
    wanted = [*_PLACES, *names[names.index(_BEFORE) + 1 : names.index(_BEHIND)]]
    columns = {name: table.column(name).to_pylist() for name in (*wanted, "status", *_FIGURES)}
    counts = {status: columns["status"].count(status) for status in dict.fromkeys(columns["status"])}
    done = [at for at, status in enumerate(columns["status"]) if status == "done"]
    if not done:
        raise InputError(f"{folder}: no scenario is done")
    number, fastest_kwh, asked_pct = (np.array([columns[name][at] for at in done]) for name in _FIGURES)
    least = int(np.argmin(asked_pct))
    if margin_pct > asked_pct[least] * (1.0 + _ROUNDING):
        asked = f"scenario {number[least]} was asked for margins up to {asked_pct[least]:.4g} %"
        raise InputError(f"{folder}: {asked}, got {margin_pct:g} %")
    files = sorted((folder / "fronts").glob("*.parquet"))
    found = dict(_read_off(parquet, files, margin_pct, dict(zip(number.tolist(), fastest_kwh, strict=True))))
    if lost := set(number.tolist()) - set(found):
        raise InputError(f"{folder}: scenario {min(lost)} is done, but its points are not in fronts")
    axes = {name: [columns[name][at] for at in done] for name in wanted}
    if len(set(axes["line"])) > 1:  # sections of several lines may be called the same
        axes["section"] = [f"{line} {section}" for line, section in zip(axes["line"], axes["section"], strict=True)]
    return Savings(
        margin_pct,
        number,
        fastest_kwh,
        np.array([found[one].energy_kwh for one in number.tolist()]),
        {name: values for name, values in axes.items() if len(set(values)) > 1},
        counts,
        np.array([found[one].at_most_above_pct for one in number.tolist()]),
    )


def told_apart(axes: Mapping[str, list[Any]]) -> dict[str, list[Any]]:
    """Axes without those that say nothing more: what goes along with each other, as in a zip, is one axis.

    Of train, line and section the first one stands for those that it decides and that decide it.
    """
    alike: dict[tuple[int, ...], list[str]] = {}
    for name, values in axes.items():
        first: dict[Any, int] = {}
        alike.setdefault(tuple(first.setdefault(value, len(first)) for value in values), []).append(name)
    found = {}
    for names in alike.values():
        own = [name for name in names if name in _PLACES][:1] or names
        rows = zip(*(axes[name] for name in own), strict=True)
        found[" and ".join(own)] = [row[0] if len(row) == 1 else ", ".join(map(str, row)) for row in rows]
    return found


@contextlib.contextmanager
def _readable(file: Path) -> Iterator[None]:
    try:
        yield
    except (OSError, ValueError) as error:
        raise InputError(f"{file}: cannot be read: {error}") from error


def _read_off(
    parquet: Any, files: Sequence[Path], margin_pct: float, fastest_kwh: Mapping[int, float]
) -> Iterator[tuple[int, Read]]:
    """Energy at a margin of each scenario whose fastest run is given, by its number; a group of rows at once."""
    names = ["scenario", "margin_pct", "time_s", "energy_kwh", "price_kwh_per_min"]
    for file in files:
        with _readable(file):
            source = parquet.ParquetFile(file)
        for group in range(source.num_row_groups):
            with _readable(file):
                table = source.read_row_group(group, columns=names)
            numbers, *columns = (table.column(name).to_numpy() for name in names)
            starts = np.flatnonzero(np.diff(numbers, prepend=-1))
            for start, end in zip(starts, [*starts[1:], len(numbers)], strict=True):
                number = int(numbers[start])
                if number in fastest_kwh:
                    own = [column[start:end] for column in columns]
                    yield number, _at_margin(margin_pct, fastest_kwh[number], *own)


def _at_margin(
    margin_pct: float, fastest_kwh: float, own_pct: _Floats, time_s: _Floats, energy_kwh: _Floats, price: _Floats
) -> Read:
    """Read a front off at a margin, or at its end where that comes before."""
    fastest_s = float(time_s[0] / (1.0 + 0.01 * own_pct[0]))
    front = Front(time_s, energy_kwh, price)
    if own_pct[0] > 0.0:
        first = (fastest_s, fastest_kwh, math.nan)
        front = Front(*(np.append(one, column) for one, column in zip(first, front, strict=True)))
    read = front.at(float(np.clip(fastest_s * (1.0 + 0.01 * margin_pct), front.time_s[0], front.time_s[-1])))
    assert read is not None  # it is within the front
    return read


def levels(savings: Savings, axis: str) -> list[Level]:
    """What is saved at each value of an axis, over all the others, in the order in which the values come."""
    at: dict[Any, list[int]] = {}
    for index, value in enumerate(savings.axes[axis]):
        at.setdefault(value, []).append(index)
    found = []
    for value, own in at.items():
        fastest_kwh, saved_kwh = float(savings.fastest_kwh[own].sum()), float(savings.saved_kwh[own].sum())
        share_pct = 100.0 * saved_kwh / abs(fastest_kwh) if fastest_kwh else 0.0
        found.append(Level(value, len(own), fastest_kwh, saved_kwh, share_pct))
    return found


def by_effect(savings: Savings) -> list[tuple[str, list[Level]]]:
    """Axes with their levels, the one on which the saving depends most first."""
    found = [(axis, levels(savings, axis)) for axis in savings.axes]
    return sorted(found, key=lambda one: -_span(one[1]))


def _span(found: Sequence[Level]) -> float:
    shares = [level.saved_pct for level in found]
    return max(shares) - min(shares)


class Grid(NamedTuple):
    """Saving in percent over two axes; NaN where there is no scenario."""

    row_axis: str
    rows: list[Any]
    column_axis: str
    columns: list[Any]
    saved_pct: _Floats


def grid(savings: Savings, row_axis: str, column_axis: str) -> Grid:
    """What is saved at each pair of values of two axes, over all the others."""
    rows, columns = (list(dict.fromkeys(savings.axes[axis])) for axis in (row_axis, column_axis))
    row_at, column_at = {value: at for at, value in enumerate(rows)}, {value: at for at, value in enumerate(columns)}
    sums = np.zeros((2, len(rows), len(columns)))
    pairs = zip(savings.axes[row_axis], savings.axes[column_axis], strict=True)
    index = tuple(np.array([(row_at[row], column_at[column]) for row, column in pairs]).T)
    np.add.at(sums[0], index, savings.saved_kwh)
    np.add.at(sums[1], index, savings.fastest_kwh)
    with np.errstate(divide="ignore", invalid="ignore"):
        return Grid(row_axis, rows, column_axis, columns, 100.0 * sums[0] / np.abs(sums[1]))


def axes_of_map(savings: Savings) -> list[str]:
    """The two axes on which the saving depends most, none of which decides the other, as a section does its line."""
    ranked = [axis for axis, _ in by_effect(savings)]
    pairs = itertools.combinations(ranked, 2)
    return next((list(pair) for pair in pairs if not _is_nested(*(savings.axes[axis] for axis in pair))), [])


def _is_nested(one: Sequence[Any], other: Sequence[Any]) -> bool:
    """Whether each value of one axis comes with a single value of the other: most cells of a map would be empty."""
    return len(set(zip(one, other, strict=True))) == max(len(set(one)), len(set(other)))


def report_object(savings: Savings) -> dict[str, Any]:
    """Build the object of schema tgvdp.sweep-report/1."""
    fastest_kwh, saved_kwh = float(savings.fastest_kwh.sum()), float(savings.saved_kwh.sum())
    return {
        "schema": SCHEMA,
        "margin_pct": savings.margin_pct,
        "scenarios": dict(savings.counts),
        "network": {
            "fastest_kwh": fastest_kwh,
            "saved_kwh": saved_kwh,
            "saved_pct": 100.0 * saved_kwh / abs(fastest_kwh) if fastest_kwh else 0.0,
        },
        "distribution_pct": {
            str(share): float(value)
            for share, value in zip(SHARES_PCT, np.percentile(savings.saved_pct, SHARES_PCT), strict=True)
        },
        "sensitivity": [
            {"axis": axis, "span_pct": _span(found), "levels": [level._asdict() for level in found]}
            for axis, found in by_effect(savings)
        ],
        **_warning(savings),
        **_notes(savings),
    }


def _warning(savings: Savings) -> dict[str, str]:
    """Say where fronts have no point near the margin, and which axes have values with unlike scenarios."""
    warnings = []
    above_pct = savings.at_most_above_pct
    told = int((above_pct > TELLING_PCT).sum())
    if told:
        which = f"{told} of {len(above_pct)} fronts have too few points around {savings.margin_pct:g} %"
        how = f"energies are read off a straight line there, which may be {above_pct.max():.2g} % too dear"
        warnings.append(f"{which}: {how}")
    missing = sum(savings.counts.values()) - len(savings.number)
    unlike = [axis for axis in savings.axes if len({level.scenarios for level in levels(savings, axis)}) > 1]
    if missing and unlike:
        names = ", ".join(unlike)
        warnings.append(f"scenarios that are not done ({missing}) leave values of {names} with unlike others")
    return {"warning": "; ".join(warnings)} if warnings else {}


def _notes(savings: Savings) -> dict[str, list[str]]:
    """Say which axes have values that come to the same, all else alike."""
    idle = [axis for axis in savings.axes if _is_idle(savings, axis)]
    notes = [f"{axis} changes nothing: runs cost the same at all of its values" for axis in idle]
    return {"notes": notes} if notes else {}


def _is_idle(savings: Savings, axis: str) -> bool:
    """Whether scenarios that differ on an axis alone, of which there are some, come to the same."""
    others = [values for name, values in savings.axes.items() if name != axis]
    rests = zip(*others, strict=True) if others else itertools.repeat(())
    found = zip(savings.fastest_kwh.tolist(), savings.energy_kwh.tolist(), strict=True)
    first: dict[tuple[Any, ...], tuple[float, float]] = {}
    same = all(first.setdefault(rest, energies) == energies for rest, energies in zip(rests, found, strict=False))
    return same and len(first) < len(savings.number)
