"""Options of ``tgvdp search``: their help, their checks, and the headings under which they stand."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

from tgvdp.cli.groups import apply_all, heading
from tgvdp.cli.numbers import number
from tgvdp.constants import CONVENTION_NAMES, CURVE_FORMULAS, HEURISTICS, LIMIT_RULES, MASS_MODELS, METHODS
from tgvdp.errors import InputError

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

_Command = TypeVar("_Command", bound=Callable[..., Any])

DEFAULT_TRAIN = "tgv"
PROFILE_FORMATS = ("csv", "parquet", "railtoolkit")
_PROFILES_HELP = "Format of the speed profiles; railtoolkit is the driving course that TrainRuns.jl prints."
DEFAULT_TRACK = "lgv-100km"
_PATHS_HELP = "best-first: stop after so many complete paths.  [default: 100]"
_TRAIN_HELP = f"Train: a file, or a name of the catalog.  [default: {DEFAULT_TRAIN}]"
_TRACK_HELP = f"Line: a file, or a name of the catalog.  [default: {DEFAULT_TRACK}]"
_AT_HELP = (
    "front: points exactly there instead: margins (5%) or running times (1050s, 17:30, 1:07:30), with commas between."
)
_ENERGY_HELP = (
    "What is minimised: wheel, pantograph, or a map of the power drawn: a file, a name of the catalog, or map for that"
    " of the scenario, else alstom-map.  [default: wheel]"
)
_MARGIN_HELP = "Longest running time, above the fastest run's.  [default: 25]"
_CONVENTION_HELP = "Whose reading of the line: gravity and the four switches below.  [default: ttobench]"
_MASS_HELP = "Gradients and curves act at the head, or averaged over the length.  [default: the convention's]"
_LIMITS_HELP = "A higher speed limit counts once the head, or the tail, has passed it."
_CURVES_HELP = "Formula of curve resistance."

_JOURNEY_HELP = "From the journey's section N (default: 1): origin, destination, and the longest running time."


def _targets(_: click.Context, parameter: click.Parameter, text: str | None) -> str | None:
    """Check what --at asks for."""
    from tgvdp.formats.native.points import parse_targets

    if text is not None:
        try:
            parse_targets(text)
        except InputError as error:
            raise click.BadParameter(str(error).removeprefix(f"{parameter.name}: ")) from None
    return text


def _complete(_: click.Context, parameter: click.Parameter, incomplete: str) -> "list[CompletionItem]":
    """Complete names of the catalog where the option takes them, and files."""
    from click.shell_completion import CompletionItem

    from tgvdp.model import catalog
    from tgvdp.model.energy import ENERGY_KINDS

    wanted = "map" if parameter.name == "energy" else parameter.name
    names = [name for kind in catalog.KINDS if kind == wanted for name in catalog.names(kind)]
    if parameter.name == "energy":
        names += ENERGY_KINDS
    items = [CompletionItem(name) for name in names if name.startswith(incomplete)]
    return [*items, CompletionItem(incomplete, type="file")]


_trip = heading("Train, line and trip")
_physics = heading("Energy and physics")
_search = heading("Search")
_grid = heading("Search on a grid (methods exact and best-first)")
_budget = heading("Budget")
_output = heading("Proof and output")

#: All options in the order of the help page.
_OPTIONS = [
    _trip("--track", metavar="FILE|NAME", shell_complete=_complete, help=_TRACK_HELP),
    _trip("--train", metavar="FILE|NAME", shell_complete=_complete, help=_TRAIN_HELP),
    _trip(
        "--scenario",
        metavar="FILE",
        shell_complete=_complete,
        help="Train, line and options in one file; the command line wins over it.",
    ),
    _trip("--journey", metavar="FILE[#N]", shell_complete=_complete, help=_JOURNEY_HELP),
    _trip("--from", "from_m", metavar="M", type=number("m", at_least=0.0), help="Origin on the line.  [default: 0]"),
    _trip("--to", "to_m", metavar="M", type=number("m"), help="Destination on the line.  [default: its end]"),
    _trip("--start-speed", "start_speed_kmh", metavar="KMH", type=number("km/h", at_least=0.0), help="[default: 0]"),
    _trip("--end-speed", "end_speed_kmh", metavar="KMH", type=number("km/h", at_least=0.0), help="[default: 0]"),
    _physics("--energy", metavar="MODEL", shell_complete=_complete, help=_ENERGY_HELP),
    _physics("--convention", type=click.Choice(CONVENTION_NAMES), help=_CONVENTION_HELP),
    _physics("--mass-model", type=click.Choice(MASS_MODELS), help=_MASS_HELP),
    _physics("--limits", type=click.Choice(LIMIT_RULES), help=_LIMITS_HELP),
    _physics("--curves", type=click.Choice(CURVE_FORMULAS), help=_CURVES_HELP),
    _physics("--tunnels/--no-tunnels", default=None, help="Count the train's drag in tunnels."),
    _search("--method", type=click.Choice(METHODS), help="How to search.  [default: front]"),
    _search("--points", metavar="N", type=click.IntRange(min=2), help="front: number of points.  [default: 60]"),
    _search("--max-margin", "max_margin_pct", metavar="PCT", type=number("%", above=0.0), help=_MARGIN_HELP),
    _search("--at", metavar="LIST", callback=_targets, help=_AT_HELP),
    _grid("--paths", metavar="N", type=click.IntRange(min=1), help=_PATHS_HELP),
    _grid("--heuristic", type=click.Choice(HEURISTICS), help="best-first: what orders the queue.  [default: ratio]"),
    _grid(
        "--segment",
        "segment_m",
        metavar="M",
        type=number("m", above=0.0),
        help="exact, best-first: largest segment of the grid.  [default: a 40th, a 20th of the trip]",
    ),
    _grid(
        "--speeds",
        metavar="N",
        type=click.IntRange(min=2),
        help="exact, best-first: number of speeds.  [default: 40, 20]",
    ),
    _grid("--dominance/--no-dominance", default=None, help="best-first: drop dominated paths.  [default: dominance]"),
    _grid(
        "--bounds/--no-bounds", default=None, help="best-first: prune by bounds of the cost to go.  [default: bounds]"
    ),
    _budget(
        "--max-labels",
        metavar="N",
        type=click.IntRange(min=1),
        help="exact, best-first: end after so many partial paths.",
    ),
    _budget(
        "--time-limit", "time_limit_s", metavar="S", type=number("s", above=0.0), help="End after so many seconds."
    ),
    _output("--certify/--no-certify", default=True, show_default=True, help="Prove how far the optimum can be."),
    _output("--profiles", type=click.Choice(PROFILE_FORMATS), default="csv", show_default=True, help=_PROFILES_HELP),
    _output("--out", metavar="DIR", default="out", show_default=True, help="Folder of the results."),
    _output("--json", "as_json", is_flag=True, help="Print one JSON object on stdout, everything else on stderr."),
    _output("--quiet", is_flag=True, help="Print nothing but errors and what --json asks for."),
]


def search_options(command: _Command) -> _Command:
    """Decorate a command with the options of a search."""
    return apply_all(_OPTIONS, command)
