"""What solvers reach on the instances of one family and size together, and how that grows with the size.

The time to solution of an ensemble is the median over its instances (Rønnow et al., Science 345, 420, 2014), in sweeps
(layers, for a circuit), which no machine changes, and in seconds. Intervals are those of a bootstrap over instances
(Efron and Tibshirani, An Introduction to the Bootstrap, 1993, ch. 13) at 95 %.
"""

import re
import statistics
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from tgvdp.solvers.allowance import ITEMS
from tgvdp.trials.rows import Row
from tgvdp.trials.statistics import LEVEL

Floats = NDArray[np.float64]

_RESAMPLED = 1000
#: Sizes, and instances of each, from which a growth is told.
_LEAST_SIZES, _LEAST_INSTANCES = 4, 5
#: Digits of a slope; what is left of equal efforts beyond is rounding.
_SLOPE_DIGITS = 9
#: Keys of a word that choose a variant of a solver; the others are settings of it.
_VARIANTS = {item.key for item in ITEMS if item.choices or item.field == "backend"}


def family_of(name: str) -> str:
    """What stands before the size in the name of an instance: ``easy`` of ``easy-n020-s07``."""
    return re.sub(r"-n\d+.*$", "", name)


def variants(rows: Sequence[Row]) -> dict[str, str]:
    """Names of solvers without their settings, by their words; the words of a name that one instance has twice."""
    short = {word: _variant(word) for word in dict.fromkeys(row["Workflow"] for row in rows)}
    often = Counter((row["Problem"], short[row["Workflow"]]) for row in rows)
    twice = {name for (_, name), count in often.items() if count > 1}
    return {word: word if name in twice else name for word, name in short.items()}


def _variant(word: str) -> str:
    name, *parts = word.split(":")
    return ":".join([name, *(part for part in parts if "=" not in part or part.partition("=")[0] in _VARIANTS)])


def ensembles(rows: Sequence[Row]) -> list[Row]:
    """One row per family, size and solver, of the rows whose success is known."""
    names = variants(rows)
    found: dict[tuple[str, int, str], list[Row]] = {}
    for row in rows:
        if row["p_success"] is not None:
            found.setdefault((family_of(row["Problem"]), row["N"], names[row["Workflow"]]), []).append(row)
    return [_ensemble(*key, own) for key, own in found.items()]


def _ensemble(family: str, steps: int, name: str, rows: Sequence[Row]) -> Row:
    chances = [row["p_success"] for row in rows]
    words = list(dict.fromkeys(row["Workflow"] for row in rows))
    row: Row = {
        "family": family,
        "N": steps,
        "solver": name,
        "draws": rows[0]["p from"] != "no draw",
        "word": " ".join(words),
        "instances": len(rows),
        "solved": sum(chance > 0.0 for chance in chances),
        "p median": statistics.median(chances),
        "p least": min(chances),
        "p most": max(chances),
    }
    for unit in ("sweeps", "s"):
        efforts = _column(rows, unit)
        low, high = _interval([float(np.median(one)) for one in _resampled(efforts, _seed(family, steps))])
        row |= {f"TTS99 {unit}": float(np.median(efforts)), f"TTS99 {unit} low": low, f"TTS99 {unit} high": high}
    return row


def _column(rows: Sequence[Row], unit: str) -> Floats:
    return np.array([np.inf if row[f"TTS99 {unit}"] is None else row[f"TTS99 {unit}"] for row in rows])


def _seed(family: str, steps: int) -> int:
    """The same instances are drawn for every solver."""
    return steps + 1000 * sum(family.encode())


def _resampled(values: Floats, seed: int) -> Iterator[Floats]:
    rng = np.random.default_rng(seed)
    for _ in range(_RESAMPLED):
        yield values[rng.integers(0, values.size, values.size)]


def _interval(values: Sequence[float]) -> tuple[float, float]:
    """Percentiles; one of them may be infinite."""
    ordered = np.sort(np.asarray(values))
    tail = 0.5 * (1.0 - LEVEL)
    last = ordered.size - 1
    return float(ordered[round(tail * last)]), float(ordered[round((1.0 - tail) * last)])


def scaling(rows: Sequence[Row]) -> list[Row]:
    """How the median time to solution of each family and solver grows with N, where enough sizes have one.

    ``decades per step`` is the slope of log10 TTS99 over N, ``power of N`` that over log10 N, both by least squares.
    Sizes whose median is infinite are left out: a growth then is that of the sizes that are still solved.
    """
    names = variants(rows)
    found: dict[tuple[str, str], dict[int, list[Row]]] = {}
    for row in rows:
        if row["p_success"] is not None:
            key = (family_of(row["Problem"]), names[row["Workflow"]])
            found.setdefault(key, {}).setdefault(row["N"], []).append(row)
    return [
        growth
        for (family, name), by_size in found.items()
        for unit in ("sweeps", "s")
        if (growth := _growth(family, name, by_size, unit)) is not None
    ]


def _growth(family: str, name: str, by_size: Mapping[int, Sequence[Row]], unit: str) -> Row | None:
    efforts = {steps: _column(own, unit) for steps, own in by_size.items()}
    solved = {steps: one for steps, one in sorted(efforts.items()) if np.isfinite(np.median(one))}
    if len(solved) < _LEAST_SIZES or min(map(len, solved.values())) < _LEAST_INSTANCES:
        return None
    sizes = np.array(list(solved), dtype=np.float64)
    resampled = zip(*(_resampled(one, _seed(family, steps)) for steps, one in solved.items()), strict=True)
    medians = np.array([[np.median(one) for one in sample] for sample in resampled])
    medians = medians[np.isfinite(medians).all(axis=1)]
    centre = np.array([np.median(one) for one in solved.values()])
    draws = next(iter(by_size.values()))[0]["p from"] != "no draw"
    row: Row = {
        "family": family, "solver": name, "unit": unit, "draws": draws, "sizes": " ".join(map(str, solved)),
        "sizes without": " ".join(str(steps) for steps in sorted(efforts) if steps not in solved),
    }  # fmt: skip
    for what, x in (("decades per step", sizes), ("power of N", np.log10(sizes))):
        slopes = [_slope(x, one) for one in medians] or [np.nan]
        low, high = _interval(slopes)
        row |= {what: _slope(x, centre), f"{what} low": low, f"{what} high": high}
    return row


def _slope(x: Floats, efforts: Floats) -> float:
    centred = x - x.mean()
    return round(float(centred @ np.log10(efforts) / (centred @ centred)), _SLOPE_DIGITS)
