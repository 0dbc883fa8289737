"""What a search may spend: labels and time."""

from dataclasses import dataclass

from tgvdp._jit import working_s
from tgvdp.constants import DEFAULT_TIME_S
from tgvdp.errors import InputError
from tgvdp.model.checks import require_number

#: What is left when all the time is up, s: less than any work takes.
_LEAST_TIME_S = 1e-9
#: Labels are numbered by int32.
MOST_LABELS = 2**31 - 2


@dataclass(frozen=True)
class SearchBudget:
    """Frozen limits of a search, checked when they are made.

    Parameters
    ----------
    max_labels : int, optional
        Largest number of labels (partial paths) that may be stored; above 0.
    time_limit_s : float, optional
        Largest elapsed time; above 0, infinite means none. Searches look at the clock a few times per second. The time
        in which kernels are compiled, which the first search does, is not counted.

    Raises
    ------
    InputError
        When a limit is not a number above 0.
    """

    max_labels: int | None = None
    time_limit_s: float = DEFAULT_TIME_S

    def __post_init__(self) -> None:
        if self.max_labels is not None:
            if isinstance(self.max_labels, bool) or not isinstance(self.max_labels, int) or self.max_labels < 1:
                raise InputError(f"budget: max_labels must be a whole number above 0, got {self.max_labels!r}")
            if self.max_labels > MOST_LABELS:
                raise InputError(f"budget: max_labels must be at most {MOST_LABELS:,}, got {self.max_labels:,}")
        require_number("budget", "time_limit_s", self.time_limit_s, "s", above=0.0, infinite_ok=True)

    def text(self, *, full: bool, most_labels: int) -> str:
        """Name the part of the budget that ended a search: its labels where these were full, else its time."""
        return f"the budget of {most_labels:,} labels" if full else "the time limit"

    def after(self, clock: "Clock") -> "SearchBudget":
        """What is left of the time; never nothing, so that whoever is asked next says that the time is up."""
        return SearchBudget(self.max_labels, max(clock.left_s(), _LEAST_TIME_S))

    def start(self, elapsed_s: float = 0.0) -> "Clock":
        """Start the clock, or one that has been running for a while."""
        return Clock(working_s() - elapsed_s, self.time_limit_s)


@dataclass(frozen=True)
class Clock:
    """A started clock with a limit, which stands still while kernels are compiled."""

    started_s: float
    limit_s: float

    @property
    def elapsed_s(self) -> float:
        """Seconds since the start."""
        return working_s() - self.started_s

    def left_s(self) -> float:
        """Seconds that are left; below 0 when the limit has passed."""
        return self.limit_s - self.elapsed_s

    @property
    def expired(self) -> bool:
        """Whether the time limit has passed."""
        return self.elapsed_s >= self.limit_s

    def part(self, share: float) -> "Clock":
        """The clock of work that may take a share of the time."""
        return Clock(self.started_s, share * self.limit_s)
