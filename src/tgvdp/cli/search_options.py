"""Options of ``tgvdp search``: those of the search from their declarations, and those of the command alone."""

from collections.abc import Callable
from typing import Any, TypeVar

import click

from tgvdp.cli.completions import complete_fields, complete_folder, complete_source
from tgvdp.cli.groups import Decorator, apply_all, heading
from tgvdp.cli.numbers import LINE_SPEED, number
from tgvdp.cli.places import place
from tgvdp.errors import InputError
from tgvdp.options.option import Option
from tgvdp.options.search import BY_FIELD, TRIP

_Command = TypeVar("_Command", bound=Callable[..., Any])

DEFAULT_TRAIN = "tgv"
DEFAULT_TRACK = "lgv-100km"
PROFILE_FORMATS = ("csv", "parquet", "xlsx", "railtoolkit")
PICTURE_FORMATS = ("png", "svg", "pdf")
_PROFILES_HELP = "Format of front and speed profiles; railtoolkit is the driving course that TrainRuns.jl prints."
_EVERY_HELP = "Profiles with a row every M metres.  [default: all rows of the search]"
_TRACE_HELP = "best-first: write each step of the search into trace.json, trace.graphml and a picture; for small grids."
_FORMAT_HELP = f"Formats of the pictures, with commas: {', '.join(PICTURE_FORMATS)}."
_PRICE_HELP = "€/kWh at the pantograph: adds the cost of each run."
_CO2_HELP = "Grams of CO2 per kWh at the pantograph: adds the emission of each run."
TRAIN_HELP = f"Train: a file, or a name of the catalog.  [default: {DEFAULT_TRAIN}]"
TRACK_HELP = f"Line: a file, or a name of the catalog.  [default: {DEFAULT_TRACK}]"
SET_HELP = (
    "Set a field of the train or line, by its name and unit in the native format, such as train.mass_t=450; may be"
    " given several times."
)
_JOURNEY_HELP = (
    "From the journey's section N, or that from the stop STOP (default: the first): origin, destination, and the"
    " longest running time."
)


def _formats(_: click.Context, __: click.Parameter, text: str) -> tuple[str, ...]:
    """Take the list of --format apart."""
    formats = tuple(dict.fromkeys(word.strip().lower() for word in text.split(",") if word.strip()))
    if not formats or (unknown := next((word for word in formats if word not in PICTURE_FORMATS), None)):
        missing = "there is none" if not formats else f"there is no {unknown!r}"
        raise click.BadParameter(f"{missing}; there are {', '.join(PICTURE_FORMATS)}")
    return formats


def declared(one: Option) -> Decorator:
    """Option of the command line, as it is declared."""
    settings: dict[str, Any] = {"help": one.summary or None, "metavar": one.metavar or None}
    if one.kind is bool:
        return heading(one.heading)(f"{one.flag}/--no-{one.name}", one.field, default=None, **settings)
    if one.read is not None:
        settings |= {"callback": _readable(one.read), "multiple": one.repeatable}
    elif one.open:
        settings |= {"callback": lambda _, __, text: None if text is None else one.choice(text)}
        settings["shell_complete"] = complete_source
    elif one.choices:
        settings["type"] = click.Choice(one.choices, case_sensitive=False)
        settings["metavar"] = f"[{'|'.join(one.choices)}]"  # as files and Python spell them, not in lower case
    elif one.kind is int:
        low, high = (None if limit is None else int(limit) for limit in (one.at_least, one.at_most))
        settings["type"] = click.IntRange(min=low, max=high)
    elif one.heading == TRIP and one.unit == "m":
        settings |= {"type": place(at_least=one.at_least), "metavar": "M|STOP"}
    else:
        settings["type"] = number(one.unit, above=one.above, at_least=one.at_least, at_most=one.at_most)
    return heading(one.heading)(one.flag, one.field, **settings)


def _readable(read: Callable[[Any], Any]) -> Callable[[click.Context, click.Parameter, Any], Any]:
    """Check a text of its own grammar, or several, and leave them as they are."""

    def check(_: click.Context, __: click.Parameter, text: Any) -> Any:
        if text is not None and text != ():
            try:
                read(text)
            except InputError as error:
                raise click.BadParameter(str(error)) from None
        return text or None

    return check


_trip = heading(TRIP)
_output = heading("Proof and output")

#: What commands have that run trains on lines: where limits come from, and fields that are set.
LINE_AND_FIELDS = (
    _trip("--line-speed", "line_speed_kmh", **LINE_SPEED),
    _trip("--set", "changes", metavar="FIELD=VALUE", multiple=True, shell_complete=complete_fields, help=SET_HELP),
)
PICTURES = _output("--pictures/--no-pictures", default=True, show_default=True, help="Draw pictures.")


def folder_and_screen(folder: str) -> tuple[Decorator, ...]:
    """Options of a command that writes a folder, which has a name of its own, and prints what is in it."""
    return (
        _output(
            "--out", metavar="DIR", default=folder, show_default=True, shell_complete=complete_folder,
            help="Folder of the results.",
        ),
        _output("--force", is_flag=True, help="Write into a folder that holds files of others."),
        _output("--json", "as_json", is_flag=True, help="Print one JSON object on stdout, everything else on stderr."),
        _output("-q", "--quiet", is_flag=True, help="Print nothing but errors and what --json asks for."),
    )  # fmt: skip


#: All options in the order of the help page.
_OPTIONS = [
    _trip("--track", metavar="FILE|NAME", shell_complete=complete_source, help=TRACK_HELP),
    _trip("--train", metavar="FILE|NAME", shell_complete=complete_source, help=TRAIN_HELP),
    _trip(
        "--scenario",
        metavar="FILE",
        shell_complete=complete_source,
        help="Train, line and options in one file; the command line wins over it.",
    ),
    _trip("--journey", metavar="FILE[#N|STOP]", shell_complete=complete_source, help=_JOURNEY_HELP),
    *LINE_AND_FIELDS,
    *map(declared, BY_FIELD.values()),
    _output("--certify/--no-certify", default=True, show_default=True, help="Prove how far the optimum can be."),
    _output("--profiles", type=click.Choice(PROFILE_FORMATS), default="csv", show_default=True, help=_PROFILES_HELP),
    _output("--every", "every_m", metavar="M", type=number("m", above=0.0), help=_EVERY_HELP),
    _output("--trace", is_flag=True, help=_TRACE_HELP),
    _output("--format", metavar="LIST", default="png", show_default=True, callback=_formats, help=_FORMAT_HELP),
    PICTURES,
    _output("--price-per-kwh", metavar="EUR", type=number("€/kWh", at_least=0.0), help=_PRICE_HELP),
    _output("--co2-g-per-kwh", metavar="G", type=number("g/kWh", at_least=0.0), help=_CO2_HELP),
    *folder_and_screen("out"),
]


def search_options(command: _Command) -> _Command:
    """Decorate a command with the options of a search."""
    return apply_all(_OPTIONS, command)
