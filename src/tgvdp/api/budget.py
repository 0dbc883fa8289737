"""The budget of what is computed: of a search, and of what follows it."""

from collections.abc import Mapping
from typing import Any

from tgvdp.constants import DEFAULT_TIME_S
from tgvdp.methods.budget import SearchBudget


def budget_of(options: Mapping[str, Any], time_limit_s: float | None = None) -> SearchBudget:
    """Budget by the options of a search.

    Parameters
    ----------
    options : mapping
        As `tgvdp.options.search.SearchOptions.as_dict` returns them; what is absent or None is the default.
    time_limit_s : float, optional
        Time of what follows the search, s; by default as much as the search had.

    Raises
    ------
    InputError
        When a limit is not a number above 0.
    """
    limits_s = (time_limit_s, options.get("time_limit_s"), DEFAULT_TIME_S)
    return SearchBudget(
        max_labels=options.get("max_labels"),
        time_limit_s=next(limit_s for limit_s in limits_s if limit_s is not None),
    )
