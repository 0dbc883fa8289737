"""Speed profiles as one table: which runs, which rows, which columns."""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from tgvdp.runs.profile import REGIMES
from tgvdp.runs.samples import Samples, rows_of, sample_count, sampled

if TYPE_CHECKING:
    from tgvdp.api import SearchResult
    from tgvdp.report.columns import Columns
    from tgvdp.runs.profile import Profile

#: Significant digits of the largest number, so that neighbouring rows are exact enough to be replayed.
PROFILE_DIGITS = {
    "position_m": 14, "speed_mps": 12, "limit_mps": 12, "gradient_permil": 5, "time_s": 12, "force_n": 9,
    "energy_j": 12,
}  # fmt: skip
#: Id of the fastest run; the points of the front have integer ids from 0.
FASTEST_ID = "fastest"
#: Rows that are written at most, of all runs together: what a spreadsheet opens, and some hundred megabytes of CSV.
MOST_ROWS = 1_000_000
#: Rows that are written in a second, and those of a sampled run at least.
_ROWS_PER_S, _LEAST_ROWS = 100_000, 100

#: Told what is being done, in a few words.
Progress = Callable[[str], None]
_TELL_EVERY = 200


class Written(NamedTuple):
    """Which runs are written.

    Attributes
    ----------
    points : list of int
        Indices of points of the front, besides the fastest run.
    every_m : float, optional
        Distance of the samples, m; None for all rows.
    note : str
        Why this is not all; empty where it is.
    """

    points: list[int]
    every_m: float | None
    note: str


def most_rows_in(time_s: float) -> int:
    """Rows that may be written, where there is so much time for them."""
    return int(min(MOST_ROWS, _ROWS_PER_S * time_s))


def choose_runs(result: "SearchResult", every_m: float | None = None, most_rows: int = MOST_ROWS) -> Written:
    """Choose the runs to write: all, or evenly spread ones where all would have more than ``most_rows`` rows.

    Where even two of them would, they are sampled. How many rows a run has is told by the first, the middle and the
    last one.

    Raises
    ------
    InputError
        When ``every_m`` is out of range.
    """
    count = len(result.front)
    if every_m is None:
        each = max(result.row_count(index) for index in {0, count // 2, count - 1})
    else:
        each = sample_count(result.trip, every_m)
    if count * each <= most_rows:
        return Written(list(range(count)), every_m, "")
    kept = max(2, most_rows // each)
    points = np.unique(np.linspace(0, count - 1, kept).round().astype(int)).tolist()
    spaced = ""
    if len(points) * each > most_rows:
        every_m = result.trip.distance_m / max(most_rows // len(points), _LEAST_ROWS)
        spaced = f" with a row every {float(f'{every_m:.3g}'):g} m"
    note = f"{len(points)} of {count} profiles are written{spaced}, evenly spread: all would have {count * each} rows"
    return Written(points, every_m, note)


def profile_columns(result: "SearchResult", written: Written, progress: Progress | None = None) -> "Columns":
    """Columns of ``profiles.csv``: the fastest run, then the chosen points of the front."""
    names: list[str] = []
    tables: list[Samples] = []
    for name, profile in runs_of(result, written, progress):
        table = samples_of(result, profile, written.every_m)
        names += [name] * len(table.position_m)
        tables.append(table)
    columns = {field: np.concatenate([getattr(table, field) for table in tables]) for field in Samples._fields}
    return {"id": names, **columns, "regime": [REGIMES[code] for code in columns["regime"].tolist()]}


def samples_of(result: "SearchResult", profile: "Profile", every_m: float | None) -> Samples:
    """Rows of one run, or its samples."""
    return rows_of(result.trip, profile) if every_m is None else sampled(result.trip, profile, every_m)


def runs_of(
    result: "SearchResult", written: Written, progress: Progress | None = None
) -> Iterator[tuple[str, "Profile"]]:
    """Ids and profiles of the chosen runs."""
    yield FASTEST_ID, result.fastest.profile
    for done, index in enumerate(written.points):
        if progress is not None and done % _TELL_EVERY == 0:
            progress(f"writing profiles, {done} of {len(written.points)}")
        yield str(index), result.profile(index)
