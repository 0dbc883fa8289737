"""The options of a search: ONE declaration of each, from which everything that knows them derives."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from tgvdp.constants import (
    CONVENTION_NAMES,
    CURVE_FORMULAS,
    DEFAULT_TIME_S,
    ENERGY_KINDS,
    HEURISTICS,
    LIMIT_RULES,
    MASS_MODELS,
    METHODS,
)
from tgvdp.errors import ArgumentError
from tgvdp.model.track import SpeedRestriction
from tgvdp.options.option import Option, option, options_of
from tgvdp.options.texts import parse_restriction, parse_targets

if TYPE_CHECKING:
    from tgvdp.model.energy import EnergyMap

_FRONT, _BEST_FIRST, _ON_GRID = ("front",), ("best-first",), ("exact", "best-first")

TRIP = "Train, line and trip"
PHYSICS = "Energy and physics"
SEARCH = "Search"
GRID = "Search on a grid (methods exact and best-first)"
BUDGET = "Budget"
#: No gust has been as fast: more is a slip of unit.
_FASTEST_WIND_KMH = 500.0


def _targets(text: str) -> Mapping[str, Any]:
    margin, time_s = parse_targets(text)
    return {"at_margin": margin, "at_s": time_s}


def _restrictions(texts: Sequence[str]) -> Mapping[str, Any]:
    return {"speed_restrictions": tuple(map(parse_restriction, texts))}


@dataclass(frozen=True, kw_only=True)
class SearchOptions:
    """What a search is asked for beside its train and track, in SI, checked when it is made.

    Each field is one argument of `tgvdp.search`, where it is described; its declaration is an
    `tgvdp.options.option.Option`, found in `OPTIONS`.

    Raises
    ------
    ArgumentError
        When an option is out of range or no choice, when the method does not have it and it is not its default, or
        when another option leaves it without effect.
    """

    #: Whose arguments errors say that they are.
    owner: ClassVar[str] = "search"

    origin_m: float = option(0.0, "Origin on the line.", name="from", heading=TRIP, unit="m", at_least=0.0, metavar="M")
    destination_m: float | None = option(
        None, "Destination on the line.", name="to", heading=TRIP, unit="m", metavar="M", shown_default="its end"
    )
    start_speed_mps: float = option(0.0, name="start-speed", heading=TRIP, unit="km/h", at_least=0.0, metavar="KMH")
    end_speed_mps: float = option(0.0, name="end-speed", heading=TRIP, unit="km/h", at_least=0.0, metavar="KMH")
    reverse: bool = option(
        False,
        "The line in the other direction: all positions count from what is its end in the file.",
        name="reverse",
        heading=TRIP,
    )
    speed_restrictions: Sequence[tuple[float, float, float]] = option(
        (),
        "Lower the speed limit there; may be given several times.",
        name="speed-restriction",
        heading=TRIP,
        rows=SpeedRestriction,
        read=_restrictions,
        repeatable=True,
        metavar="FROM:TO:KMH",
    )
    energy: "str | EnergyMap" = option(  # noqa: RUF009  (a field, as the others are)
        "wheel",
        "What is minimised: wheel, pantograph, or a map of the power drawn: a file, a name of the catalog, or map for"
        " that of the scenario, else alstom-map.",
        name="energy",
        heading=PHYSICS,
        choices=ENERGY_KINDS,
        open=True,
        metavar="MODEL",
    )
    convention: str = option(
        "ttobench",
        "Whose reading of the line: gravity and the four switches below.",
        name="convention",
        heading=PHYSICS,
        choices=CONVENTION_NAMES,
    )
    mass_model: str | None = option(
        None,
        "Gradients and curves act at the head, or averaged over the length.",
        name="mass-model",
        heading=PHYSICS,
        choices=MASS_MODELS,
        shown_default="the convention's",
    )
    limits: str | None = option(
        None,
        "A higher speed limit counts once the head, or the tail, has passed it.",
        name="limits",
        heading=PHYSICS,
        choices=LIMIT_RULES,
    )
    curves: str | None = option(
        None, "Formula of curve resistance.", name="curves", heading=PHYSICS, choices=CURVE_FORMULAS
    )
    tunnels: bool | None = option(None, "Count the train's drag in tunnels.", name="tunnels", heading=PHYSICS)
    wind_mps: float = option(
        0.0,
        "Head wind, negative for a tail wind.",
        name="wind",
        heading=PHYSICS,
        unit="km/h",
        at_least=-_FASTEST_WIND_KMH,
        at_most=_FASTEST_WIND_KMH,
        metavar="KMH",
    )
    method: str = option("front", "How to search.", name="method", heading=SEARCH, choices=METHODS)
    points: int = option(
        60, "number of points.", name="points", heading=SEARCH, methods=_FRONT, at_least=2, at_most=1000, metavar="N"
    )
    max_margin: float = option(
        0.25,
        "Longest running time, above the fastest run's.",
        name="max-margin",
        heading=SEARCH,
        unit="%",
        above=0.0,
        metavar="PCT",
    )
    max_time_s: float | None = option(None, unit="s", above=0.0)  # what a journey allows
    at_s: Sequence[float] = option(
        (),
        "points exactly there instead: margins (5%) or running times (1050s, 17:30, 1:07:30), with commas between.",
        name="at",
        heading=SEARCH,
        methods=_FRONT,
        excludes=("points", "max_margin"),
        read=_targets,
        unit="s",
        above=0.0,
        metavar="LIST",
    )
    at_margin: Sequence[float] = option(  # --at sets it too
        (), methods=_FRONT, excludes=("points", "max_margin"), unit="%", at_least=0.0
    )
    clean: bool = option(
        False,
        "rebuild each point as a clean extremal: few phases, as a driver would; ten times as slow.",
        name="clean",
        heading=SEARCH,
        methods=_FRONT,
    )
    min_phase_s: float = option(
        1.0,
        "leave shorter phases of driving out where that costs next to nothing.",
        name="min-phase",
        heading=SEARCH,
        methods=_FRONT,
        unit="s",
        at_least=0.0,
        metavar="S",
    )
    paths: int = option(
        100,
        "stop after so many complete paths, 0: find all.",
        name="paths",
        heading=GRID,
        methods=_BEST_FIRST,
        at_least=0,
        metavar="N",
    )
    heuristic: str = option(
        "ratio",
        "what orders the queue.",
        name="heuristic",
        heading=GRID,
        methods=_BEST_FIRST,
        choices=HEURISTICS,
    )
    segment_m: float | None = option(
        None,
        "largest segment of the grid.",
        name="segment",
        heading=GRID,
        methods=_ON_GRID,
        unit="m",
        above=0.0,
        metavar="M",
        shown_default="a 40th, a 20th of the trip",
    )
    speeds: int | None = option(
        None,
        "number of speeds.",
        name="speeds",
        heading=GRID,
        methods=_ON_GRID,
        at_least=2,
        metavar="N",
        shown_default="40, 20",
    )
    max_labels: int | None = option(
        None,
        "end after so many partial paths.",
        name="max-labels",
        heading=BUDGET,
        methods=_ON_GRID,
        at_least=1,
        metavar="N",
    )
    time_limit_s: float | None = option(
        None,
        "End after so many seconds.",
        name="time-limit",
        heading=BUDGET,
        unit="s",
        above=0.0,
        infinite_ok=True,
        metavar="S",
        shown_default=f"{DEFAULT_TIME_S:g}",
    )
    max_memory_b: float | None = option(
        None,
        "Take no more memory than this.",
        name="max-memory",
        heading=BUDGET,
        unit="MB",
        above=0.0,
        metavar="MB",
        shown_default="half of the machine's",
    )
    dominance: bool = option(True, "drop dominated paths.", name="dominance", heading=GRID, methods=_BEST_FIRST)
    bounds: bool = option(True, "prune by bounds of the cost to go.", name="bounds", heading=GRID, methods=_BEST_FIRST)

    def __post_init__(self) -> None:
        given = [one for one in OPTIONS if not one.is_default(getattr(self, one.argument))]
        for one in given:
            object.__setattr__(self, one.argument, one.check(getattr(self, one.argument), self.owner))
        asked = [one for one in given if getattr(self, one.argument) != one.default]
        foreign = [one for one in asked if self.method not in one.methods]
        if foreign:
            owners = " and ".join(foreign[0].methods)
            reason = f"belongs to method {owners}, it has no effect on {self.method}"
            raise self._idle([one.argument for one in foreign], reason)
        for one in asked:
            idle = sorted({other.argument for other in asked} & set(one.excludes))
            if idle:
                raise self._idle(idle, f"has no effect beside {one.argument}")

    def _idle(self, arguments: Sequence[str], reason: str) -> ArgumentError:
        """Error of the first of several arguments for one reason, which names the others."""
        first, *others = arguments
        nor = f", nor {'has' if len(others) == 1 else 'have'} {', '.join(others)}" if others else ""
        return ArgumentError(self.owner, first, f"{reason}{nor}")

    def as_dict(self) -> dict[str, Any]:
        """Values by their arguments."""
        return dict(vars(self))


class JourneyOptions(SearchOptions):
    """What a journey is asked for: as much of a search as it has."""

    owner = "journey"


#: Every option of a search, in the order of the arguments of `tgvdp.search`.
OPTIONS: tuple[Option, ...] = options_of(SearchOptions)

#: Those that people set, by their names in files.
BY_FIELD: dict[str, Option] = {one.field: one for one in OPTIONS if one.name}

_BY_ARGUMENT = {one.argument: one for one in OPTIONS}

#: Those of them that a journey has, too.
JOURNEY_FIELDS = (
    *("reverse", "speed_restriction", "energy", "convention", "mass_model", "limits", "curves", "tunnels", "wind_kmh"),
    *("points", "max_margin_pct", "at", "time_limit_s", "max_memory_mb"),
)


def by_argument(argument: str) -> Option:
    """Option of a name in Python."""
    return _BY_ARGUMENT[argument]


def excluded_by(one: Option) -> tuple[Option, ...]:
    """Options that have no effect beside one."""
    return tuple(map(by_argument, one.excludes))


def arguments_of(values: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of `tgvdp.search`, in SI, from values by their names in files; what is absent keeps its default."""
    arguments: dict[str, Any] = {}
    for field, value in values.items():
        arguments |= BY_FIELD[field].arguments(value) if field in BY_FIELD else {field: value}
    return arguments
