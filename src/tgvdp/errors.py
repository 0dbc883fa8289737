"""Everything that can go wrong, and the exit code that each case has on the command line.

Exit codes: 1 a fault of tgvdp, 2 usage (raised by the command-line parser itself), 3 bad input, 4 infeasible, 5 budget
reached with a partial result, 6 some scenarios of a sweep failed, 130 interrupted. A message is one line that names the
file, the field, the value and its unit.
"""


class TgvdpError(Exception):
    """Base of all errors that tgvdp raises on purpose."""

    exit_code = 1


class InputError(TgvdpError, ValueError):
    """The input is wrong: a file, a field, a value or a unit."""

    exit_code = 3


class ArgumentError(InputError):
    """One argument, option or field is wrong.

    Attributes
    ----------
    owner : str
        Whose it is: a function, a train, a line.
    argument : str
        Its name there.
    reason : str
        What it must be, and what it is, with its unit.
    """

    def __init__(self, owner: str, argument: str, reason: str) -> None:
        super().__init__(owner, argument, reason)
        self.owner, self.argument, self.reason = owner, argument, reason

    def __str__(self) -> str:
        return f"{self.owner}: {self.argument} {self.reason}"


class MissingExtraError(InputError):
    """A feature needs an optional package that is not installed."""


class UnavailableError(InputError):
    """A machine or a service of others cannot be used: no account, no such machine, no network."""


class NumericalError(TgvdpError):
    """The arithmetic failed on this input: numbers beyond sense, which then are named, or a fault of tgvdp."""


class InfeasibleError(TgvdpError):
    """The input is well formed, but no run obeys all its limits."""

    exit_code = 4


class BudgetExceededError(TgvdpError):
    """A label or time budget ended before there was anything to return."""

    exit_code = 5


class TasksFailedError(TgvdpError):
    """Some scenarios of a sweep failed; the others are done."""

    exit_code = 6
