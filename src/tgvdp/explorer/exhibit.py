"""What the page shows: one JSON object, and the profiles of its runs, one JSON object each."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from tgvdp.runs.profile import REGIMES

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tgvdp.api import SearchResult
    from tgvdp.runs.profile import Profile

#: Columns of a profile in the page, SI; ``regime`` is an index into `REGIMES`.
PROFILE_COLUMNS = ("position_m", "speed_mps", "time_s", "force_n", "energy_j")
#: Significant digits of the largest value: a ten thousandth of what a screen can show.
_DIGITS = 8


@dataclass(frozen=True)
class Exhibit:
    """What the page shows.

    Attributes
    ----------
    kind : str
        "search", "journey" or "benchmark".
    name : str
        For people.
    view : bytes
        JSON object: ``kind``, ``name``, and what that kind has.
    profiles : dict of str to bytes
        JSON objects of columns, by id: ``fastest`` and the indices of the front.
    """

    kind: str
    name: str
    view: bytes
    profiles: Mapping[str, bytes] = field(default_factory=dict)


def search_exhibit(
    name: str,
    content: Mapping[str, Any],
    profiles: Mapping[str, Mapping[str, Any]],
    *,
    trace: Mapping[str, Any] | None = None,
    asked: Mapping[str, Any] | None = None,
    editable: Mapping[str, Any] | None = None,
) -> Exhibit:
    """Make the exhibit of a search.

    Parameters
    ----------
    name : str
    content : mapping
        As result.json holds it.
    profiles : mapping
        Columns of each run, by id, with those of `PROFILE_COLUMNS` and ``regime``.
    trace : mapping, optional
        Of a best-first search; see `tgvdp.methods.grid.trace`.
    asked, editable : mapping, optional
        Of a run that the page asked for: what it asked, and what of it can be dragged.
    """
    view = {
        "kind": "search", "name": name, "content": content, "regimes": REGIMES, "trace": trace, "asked": asked,
        "editable": editable, "drawn": list(profiles),
    }  # fmt: skip
    return Exhibit(
        "search", name, msgspec.json.encode(view), {key: profile_json(rows) for key, rows in profiles.items()}
    )


def profile_json(columns: Mapping[str, Any]) -> bytes:
    """Columns of a profile as JSON, rounded to what can be seen."""
    shown = {name: rounded(columns[name]) for name in PROFILE_COLUMNS}
    return msgspec.json.encode({**shown, "regime": list(map(int, columns["regime"]))})


def rounded(values: "Iterable[float] | NDArray[Any]") -> list[float]:
    """Values with the decimals that the largest one needs."""
    column = np.asarray(values, dtype=np.float64)
    largest = float(np.max(np.abs(column), initial=0.0))
    decimals = _DIGITS - 1 - (math.floor(math.log10(largest)) if 0.0 < largest < math.inf else 0)
    rounded: list[float] = np.round(column, decimals).tolist()
    return rounded


def profile_columns(profile: "Profile") -> dict[str, Any]:
    """Columns of a profile as the page needs them."""
    return {name: getattr(profile, name) for name in (*PROFILE_COLUMNS, "regime")}


def profiles_of(result: "SearchResult") -> dict[str, dict[str, Any]]:
    """Columns of the fastest run and of every point of the front, by id."""
    runs = {str(index): result.profile(index) for index in range(len(result.front))}
    return {name: profile_columns(profile) for name, profile in {"fastest": result.fastest.profile, **runs}.items()}
