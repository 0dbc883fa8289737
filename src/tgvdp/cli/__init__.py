"""The command line: it parses, calls, prints and saves; everything else is done elsewhere.

Subcommands live in modules of their own, which import numpy, numba and matplotlib only when they run. `main` is the
single place where an error becomes one line on stderr and an exit code (see `tgvdp.errors`).
"""

import importlib
import io
import json
import logging
import os
import re
import sys
import warnings
from collections.abc import Sequence
from difflib import get_close_matches
from typing import Any

import click
from click.shell_completion import get_completion_class

from tgvdp import __version__
from tgvdp.errors import InputError, TgvdpError

PROGRAM = "tgvdp"
_COMPLETION_VARIABLE = "_TGVDP_COMPLETE"
EXIT_USAGE = 2
EXIT_INTERRUPTED = 130
#: What matplotlib says of each character that its font lacks; pictures of one run may lack dozens.
_GLYPH = re.compile(r"Glyph \d+ .*missing from font")
#: Of what shells call a broken pipe: whoever reads our output, such as head, has enough.
_EXIT_PIPE = 141
_COMMANDS = (
    "search",
    "journey",
    "compare",
    "explore",
    "report",
    "score",
    "formulate",
    "solve",
    "decode",
    "bench",
    "sweep",
    "catalog",
    "validate",
    "convert",
    "warm",
    "selftest",
    "completion",
)

_EXAMPLES = """
\b
Examples:
  tgvdp search                                   the built-in train on the built-in line
  tgvdp search --train tgv --track flat-100km --out flat
  tgvdp journey --track line.json --train train.json
  tgvdp catalog                                  the built-in trains and lines
  tgvdp validate my-train.json my-scenario.toml
  tgvdp solve instance.json --solver dp          a problem of the quantum formulations
  tgvdp convert line.xml line.toml               from railML to the native format
  tgvdp sweep network.toml --out network         thousands of searches
"""


_GREETING = f"""\
Usage: {PROGRAM} COMMAND [OPTIONS]

The Pareto front of delay against energy for a train on a line.

  {PROGRAM} search             search it, for the built-in train on the built-in line
  {PROGRAM} COMMAND --help     the options of a command, with examples
  {PROGRAM} --help             all commands"""


class _LazyGroup(click.Group):
    """Imports the module of a subcommand when somebody asks for it."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(_COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in _COMMANDS:
            return None
        command: click.Command = importlib.import_module(f"tgvdp.cli.{cmd_name}").command
        return command

    def make_context(self, *arguments: Any, **options: Any) -> click.Context:
        """Make the context in which all is done."""
        try:
            return super().make_context(*arguments, **options)
        except KeyboardInterrupt:  # before click, which prints an empty line
            raise _Interrupted("interrupted") from None

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse what is given, unless nothing is."""
        if not args and not ctx.resilient_parsing:
            raise _Bare
        return super().parse_args(ctx, args)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the subcommand, or say which one may have been meant."""
        try:
            return super().resolve_command(ctx, args)
        except click.UsageError:
            near = get_close_matches(args[0].lower(), _COMMANDS, n=1)
            hint = f", did you mean {near[0]!r}?" if near else f"; there are {', '.join(_COMMANDS)}"
            raise click.UsageError(f"unknown command {args[0]!r:.60}{hint}", ctx) from None

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:  # before click, which prints an empty line
            raise _Interrupted("interrupted") from None
        except SystemError as error:  # a compiled kernel was running when the signal came
            if not _caused_by_interrupt(error):
                raise
            raise _Interrupted("interrupted") from None


def _caused_by_interrupt(error: BaseException | None) -> bool:
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__
    return error is not None


class _Bare(Exception):
    """Somebody typed the program's name alone."""


class _Interrupted(click.ClickException):
    exit_code = EXIT_INTERRUPTED


@click.group(
    cls=_LazyGroup,
    epilog=_EXAMPLES,
    no_args_is_help=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.version_option(__version__, prog_name=PROGRAM)
def cli() -> None:
    """Find the Pareto front of delay against energy for a train on a line.

    Exit codes: 0 done, 2 wrong usage, 3 bad input, 4 infeasible, 5 budget reached (a partial result, labelled so),
    6 some scenarios of a sweep failed, 130 interrupted.
    """


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        Without the program's name; ``sys.argv[1:]`` by default.
    """
    _refuse_to_print_nowhere()
    _write_what_terminals_can()
    logging.getLogger().addHandler(logging.NullHandler())  # what libraries log is not for people
    with warnings.catch_warnings():
        warnings.showwarning = _Warnings()  # type: ignore[assignment]
        try:
            _check_completion()
            code = cli.main(args=arguments, prog_name=PROGRAM, standalone_mode=False)
        except SystemExit as ended:  # how click completes for shells, and with 1 its answer to a broken pipe
            return _EXIT_PIPE if ended.code else 0
        except _Bare:
            click.echo(_GREETING, err=True)
            return EXIT_USAGE
        except click.UsageError as error:
            hint = f" (see {error.ctx.command_path} --help)" if error.ctx else ""
            return _fail(error.format_message() + hint, EXIT_USAGE)
        except click.ClickException as error:
            return _fail(error.format_message(), error.exit_code)
        except click.Abort:
            return _fail("interrupted", EXIT_INTERRUPTED)
        except TgvdpError as error:
            return _fail(str(error), error.exit_code)
        except OSError as error:
            _drop_what_cannot_be_printed()
            where = "standard output" if error.filename is None else error.filename
            return _fail(f"{where}: {error.strerror or error}", InputError.exit_code)
    return int(code or 0)


def _refuse_to_print_nowhere() -> None:
    """Have a closed stdout fail where something is printed: Python has none then, and click prints in silence.

    What a closed stderr would tell is lost, and no more than that.
    """
    if sys.stderr is None:
        sys.stderr = io.TextIOWrapper(io.FileIO(os.devnull, "w"), encoding="utf-8")
    if sys.stdout is None:
        nowhere = os.open(os.devnull, os.O_RDONLY)
        sys.stdout = io.TextIOWrapper(os.fdopen(nowhere, "wb", buffering=0), write_through=True)


def _drop_what_cannot_be_printed() -> None:
    """Have a stdout that takes no more, such as a file on a full disk, end in one line: Python would try once more."""
    try:
        sys.stdout.flush()
    except OSError:
        with open(os.devnull, "wb") as nowhere:
            os.dup2(nowhere.fileno(), sys.stdout.fileno())


def _write_what_terminals_can() -> None:
    """Have characters that a terminal's encoding lacks, such as ‰, stand as question marks."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")


def _check_completion() -> None:
    """Refuse what is no request for completion in the variable of shells; click would end in silence."""
    asked = os.environ.get(_COMPLETION_VARIABLE, "")
    shell, _, what = asked.partition("_")
    if asked and not (get_completion_class(shell) and what in ("source", "complete")):
        raise click.UsageError(f"{_COMPLETION_VARIABLE}: must be SHELL_source or SHELL_complete, got {asked!r:.40}")


def echo_json(content: Any) -> None:
    """Print an object as one line of JSON, in the characters that the terminal's encoding has."""
    plain = (getattr(sys.stdout, "encoding", None) or "").lower().replace("-", "") != "utf8"
    click.echo(json.dumps(content, ensure_ascii=plain, allow_nan=False))


def _fail(message: str, exit_code: int) -> int:
    click.echo(f"{PROGRAM}: error: {' '.join(message.split())}", err=True)
    return exit_code


class _Warnings:
    """Shows warnings on one line, each text once: a second process may come to the same."""

    def __init__(self) -> None:
        self._shown: set[str] = set()

    def __call__(self, message: Warning | str, *_: object) -> None:
        text = str(message).strip().partition("\n")[0]  # numba's are followed by a traceback of its own
        if _GLYPH.match(text):
            text = "the font of the pictures lacks characters of names, which are boxes there"
        if text not in self._shown:
            self._shown.add(text)
            click.echo(f"{PROGRAM}: warning: {text}", err=True)
