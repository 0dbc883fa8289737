"""A command: one row of the list that a run is driven by, and how rows are written and copied."""

from tgvdp._jit import part

#: Columns of a command, (n, 5): regime, position from the origin in m, position from which it may hold, whether its
#: switch is bound (`switches.PINNED`, `FROZEN` there, or 0), and where the run from a pinned one touches the envelope.
REGIME, AT, HOLDS_FROM, BOUND, TOUCH = range(5)
COMMAND_COLUMNS = 5


@part
def write_command(commands, at, regime, from_m, holds_from_m):
    """Write a command that is not bound; returns the number of those up to it."""
    commands[at, REGIME] = regime
    commands[at, AT] = from_m
    commands[at, HOLDS_FROM] = holds_from_m
    commands[at, BOUND] = 0.0
    commands[at, TOUCH] = -1.0
    return at + 1


@part
def copy_command(commands, i, out, at):
    """Copy command i to others, or to another place among its own; returns the number of those up to it."""
    for column in range(COMMAND_COLUMNS):
        out[at, column] = commands[i, column]
    return at + 1


@part
def copy_commands(commands, count, out):
    """Copy the first ``count`` commands."""
    for i in range(count):
        copy_command(commands, i, out, i)
