"""Options under headings, so that a long help page says what belongs together."""

from collections import Counter
from collections.abc import Callable
from typing import Any, TypeVar

import click

_Command = TypeVar("_Command", bound=Callable[..., Any])
Decorator = Callable[[Any], Any]


class GroupedOption(click.Option):
    """An option that stands under a heading."""

    def __init__(self, *declarations: Any, heading: str, **settings: Any) -> None:
        super().__init__(*declarations, **settings)
        self.heading = heading


class GroupedCommand(click.Command):
    """A command whose help lists its options by their headings, in the order of their first options.

    Each option is given once, unless it is made to be given several times.
    """

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Refuse an option that is given twice: its last value would win in silence."""
        _, _, order = self.make_parser(ctx).parse_args(args=list(args))
        for parameter, count in Counter(order).items():
            if isinstance(parameter, click.Option) and count > 1 and not (parameter.multiple or parameter.count):
                raise click.UsageError(f"{parameter.opts[0]} is given {count} times, it takes one value", ctx)
        return super().parse_args(ctx, args)

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the headings and their options; those without one come last."""
        found: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is not None and isinstance(parameter, click.Option):  # arguments stand in the usage
                found.setdefault(getattr(parameter, "heading", "Options"), []).append(record)
        for heading, records in found.items():
            with formatter.section(heading):
                formatter.write_dl(records)


def heading(title: str) -> Callable[..., Decorator]:
    """Return `click.option` for the options of one heading."""

    def option(*declarations: str, **settings: Any) -> Decorator:
        return click.option(*declarations, cls=GroupedOption, heading=title, **settings)

    return option


def apply_all(decorators: list[Decorator], command: _Command) -> _Command:
    """Decorate a command so that its options are in the order of the list."""
    for decorator in reversed(decorators):
        command = decorator(command)
    return command
