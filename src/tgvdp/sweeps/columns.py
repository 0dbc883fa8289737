"""Columns of the tables of a sweep, for some neighbouring scenarios at a time."""

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.formats.native.changes import written
from tgvdp.options.search import SearchOptions
from tgvdp.sweeps.journal import Finished
from tgvdp.sweeps.parts import ALLOCATION, FRONTS, PROFILES, part_path
from tgvdp.sweeps.scenario import Scenario, section_name
from tgvdp.sweeps.spec import SweepSpec
from tgvdp.units import JOULE_PER_KWH

#: Part files that are kept open: neighbours in the spec mostly finish together.
_OPEN = 4


class Block(NamedTuple):
    """Some neighbouring scenarios, and what came of them."""

    scenarios: list[Scenario]
    finished: list[Finished]


def scenario_columns(spec: SweepSpec) -> Callable[[Block], Any]:
    """Table of what was asked and what came of it, a row per scenario."""
    arrow = import_module("pyarrow")
    kinds = _parameter_types(spec)

    def columns(block: Block) -> Any:
        scenarios, finished = block
        text = arrow.dictionary(arrow.int32(), arrow.string())
        table = {
            "scenario": arrow.array([one.number for one in scenarios], arrow.int64()),
            "key": arrow.array([one.key.hex() for one in finished]),
            **_names(scenarios),
            "from_m": arrow.array([one.section.from_m for one in scenarios], arrow.float64()),
            "to_m": arrow.array([one.section.to_m for one in scenarios], arrow.float64()),
        }
        for name, kind in kinds.items():
            values = [one.parameters[name] for one in scenarios]
            table[name] = arrow.array([written(one) for one in values] if kind == arrow.string() else values, kind)
        table |= {
            "status": arrow.array([one.status for one in finished], arrow.string()).cast(text),
            "error": arrow.array([one.error for one in finished], arrow.string()),
            "fastest_time_s": arrow.array([one.fastest_time_s for one in finished], arrow.float64()),
            "fastest_energy_kwh": arrow.array(_kwh([one.fastest_energy_j for one in finished]), arrow.float64()),
            "points": arrow.array([one.points for one in finished], arrow.int32()),
            "asked_margin_pct": arrow.array(list(map(_asked_pct, scenarios, finished)), arrow.float64()),
            "train_file": arrow.array([one.train.file for one in scenarios]).cast(text),
            "train_sha256": arrow.array([one.train.sha256 for one in scenarios]).cast(text),
            "line_file": arrow.array([one.line.file for one in scenarios]).cast(text),
            "line_sha256": arrow.array([one.line.sha256 for one in scenarios]).cast(text),
        }
        return arrow.table(table)

    return columns


def _asked_pct(scenario: Scenario, finished: Finished) -> float | None:
    """Largest margin that the front was asked for, %."""
    if finished.fastest_time_s is None:
        return None
    asked, fastest_s = scenario.arguments, finished.fastest_time_s
    margins = [*asked.get("at_margin", ()), *(time_s / fastest_s - 1.0 for time_s in asked.get("at_s", ()))]
    return 100.0 * float(max(margins or [asked.get("max_margin", SearchOptions.max_margin)]))


def _kwh(energies_j: Sequence[float | None]) -> list[float | None]:
    return [None if one is None else one / JOULE_PER_KWH for one in energies_j]


def _parameter_types(spec: SweepSpec) -> dict[str, Any]:
    """Type of the column of each parameter: that of all its values, or text."""
    arrow = import_module("pyarrow")
    types = {}
    for axis in spec.axes:
        for name, values in zip(axis.names, zip(*axis.rows, strict=True), strict=True):
            kinds = {type(value) for value in values}
            types[name] = (
                arrow.bool_()
                if kinds == {bool}
                else arrow.int64()
                if kinds == {int}
                else arrow.float64()
                if kinds <= {int, float}
                else arrow.string()
            )
    return types


def _names(scenarios: Sequence[Scenario], repeats: Any = None) -> dict[str, Any]:
    """Columns of train, line and section, by which results join; repeated for the rows of each scenario."""
    found = {
        "train": [one.train.name for one in scenarios],
        "line": [one.line.name for one in scenarios],
        "section": [one.section.name for one in scenarios],
    }
    arrow = import_module("pyarrow")
    at = np.arange(len(scenarios)) if repeats is None else np.repeat(np.arange(len(scenarios)), repeats)
    return {name: arrow.array(values).dictionary_encode().take(arrow.array(at)) for name, values in found.items()}


def timing_columns(block: Block) -> Any:
    """Table of what differs from run to run."""
    arrow = import_module("pyarrow")
    return arrow.table(
        {
            "scenario": arrow.array([one.number for one in block.scenarios], arrow.int64()),
            "elapsed_s": arrow.array([one.elapsed_s for one in block.finished], arrow.float64()),
            "cpu_s": arrow.array([one.cpu_s for one in block.finished], arrow.float64()),
            "worker": arrow.array([one.worker for one in block.finished], arrow.string()),
        }
    )


def row_columns(parts: Path, kind: str) -> Callable[[Block], Any]:
    """Table of the rows that part files hold, put in the order of the scenarios."""
    arrow, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")

    @functools.lru_cache(maxsize=_OPEN)
    def part(number: int) -> dict[str, Any] | None:
        path = part_path(parts, kind, number)
        if not path.exists():
            return None
        return {name: column.to_numpy() for name, column in _columns(parquet.read_table(path)).items()}

    def columns(block: Block) -> Any:
        ids = np.array([one.id for one in block.finished])
        held = []
        for number in dict.fromkeys(one.part for one in block.finished if one.part is not None):
            rows = part(number)
            if rows is not None:
                own = np.isin(rows["id"], [one.id for one in block.finished if one.part == number])
                held.append({name: column[own] for name, column in rows.items()})
        if not held:
            return None
        joined = {name: np.concatenate([one[name] for one in held]) for name in held[0]}
        order, counts = _gathered(joined.pop("id"), ids)
        rows = {name: column[order] for name, column in joined.items()}
        at = np.repeat(np.arange(len(ids)), counts)
        numbers = np.array([one.number for one in block.scenarios], dtype=np.int64)
        return arrow.table(
            {"scenario": np.repeat(numbers, counts), **_names(block.scenarios, counts)}
            | _FIGURES[kind](rows, block.finished, at)
        )

    return columns


def _gathered(held: NDArray[np.int64], wanted: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Where the rows of each wanted id are, id by id, and how many of each: equal scenarios want the same rows."""
    order = np.argsort(held, kind="stable")
    first, behind = (np.searchsorted(held, wanted, side, sorter=order) for side in ("left", "right"))
    counts = behind - first
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return order[np.repeat(first, counts) + within], counts


def _columns(table: Any) -> dict[str, Any]:
    return dict(zip(table.column_names, table.columns, strict=True))


def _front_figures(rows: Mapping[str, Any], finished: Sequence[Finished], at: Any) -> dict[str, Any]:
    """Columns of a front, as ``front.csv`` of a search has them."""
    arrow = import_module("pyarrow")
    fastest_s = np.array([one.fastest_time_s or math.nan for one in finished])[at]
    fastest_j = np.array([math.nan if one.fastest_energy_j is None else one.fastest_energy_j for one in finished])[at]
    saved_j = fastest_j - rows["energy_j"]
    with np.errstate(divide="ignore", invalid="ignore"):
        saved_pct = np.where(fastest_j == 0.0, 0.0, 100.0 * saved_j / np.abs(fastest_j))
    price = rows["price_kwh_per_min"]
    return {
        "point": rows["point"],
        "time_s": rows["time_s"],
        "delay_s": rows["time_s"] - fastest_s,
        "margin_pct": 100.0 * (rows["time_s"] / fastest_s - 1.0),
        "energy_kwh": rows["energy_j"] / JOULE_PER_KWH,
        "saved_kwh": saved_j / JOULE_PER_KWH,
        "saved_pct": saved_pct,
        "price_kwh_per_min": arrow.array(price, mask=~np.isfinite(price)),
    }


def _allocation_figures(rows: Mapping[str, Any], _: Sequence[Finished], __: Any) -> dict[str, Any]:
    """Columns of what each section of a journey gets, under the name that it has where it is run on its own."""
    arrow = import_module("pyarrow")
    names = [section_name(*ends_m) for ends_m in zip(rows["from_m"].tolist(), rows["to_m"].tolist(), strict=True)]
    columns = {name: rows[name] for name in ("point", "from_m", "to_m", "time_s")}
    return (
        {"section": arrow.array(names).dictionary_encode()} | columns | {"energy_kwh": rows["energy_j"] / JOULE_PER_KWH}
    )


def _profile_figures(rows: Mapping[str, Any], _: Sequence[Finished], __: Any) -> dict[str, Any]:
    """Columns of speed profiles, as ``profiles.csv`` of a search has them."""
    from tgvdp.runs.profile import REGIMES  # here, for it brings numba

    arrow = import_module("pyarrow")
    regimes = arrow.DictionaryArray.from_arrays(arrow.array(rows["regime"]), arrow.array(list(REGIMES)))
    return {**rows, "regime": regimes}


_FIGURES: dict[str, Callable[[Mapping[str, Any], Sequence[Finished], Any], dict[str, Any]]] = {
    FRONTS: _front_figures,
    ALLOCATION: _allocation_figures,
    PROFILES: _profile_figures,
}

#: Tables whose rows part files hold.
ROWS = tuple(_FIGURES)
