"""Options of ``tgvdp formulate`` that make an instance of a train on a line."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

from tgvdp.cli.completions import complete_source
from tgvdp.cli.groups import apply_all, heading
from tgvdp.cli.notes import remarked
from tgvdp.cli.search_options import DEFAULT_TRACK, DEFAULT_TRAIN, TRACK_HELP, TRAIN_HELP
from tgvdp.errors import InputError
from tgvdp.options.texts import Targets, parse_quantity, parse_targets

if TYPE_CHECKING:
    from tgvdp.formulations.problem.of_trip import Reference, TripInstance
    from tgvdp.model.trip import Trip

_Command = TypeVar("_Command", bound=Callable[..., Any])

_HEADING = "Instance of a trip, in place of INSTANCE"
_MODELS = ("constant", "kinetic", "efficiency", "demand")
_MOST_STEPS = 10_000
#: Running time where none is asked for: a supplement of a timetable.
_USUAL = Targets((0.1,), ())


def _target(text: str) -> Targets:
    targets = parse_targets(text)
    if len(targets.margin) + len(targets.time_s) != 1:
        raise click.BadParameter(f"must be one running time, got {text!r}")
    return targets


def _stretch(text: str) -> tuple[float, float]:
    start, colon, end = text.partition(":")
    if not colon:
        raise click.BadParameter(f"must be FROM:TO such as 20km:80km, got {text!r}")
    return parse_quantity(start, "m"), parse_quantity(end, "m")


def _quietly(read: Callable[[str], Any]) -> Callable[[str], Any]:
    def convert(text: str) -> Any:
        try:
            return read(text)
        except InputError as error:
            raise click.BadParameter(str(error)) from None

    return convert


def trip_options(command: _Command) -> _Command:
    """Add ``--steps`` and what else makes a trip; absent is None."""
    option = heading(_HEADING)
    options = [
        option("--steps", type=click.IntRange(1, _MOST_STEPS), help="Make an instance of so many steps of a trip."),
        option("--train", metavar="FILE|NAME", shell_complete=complete_source, help=TRAIN_HELP),
        option("--track", metavar="FILE|NAME", shell_complete=complete_source, help=TRACK_HELP),
        option(
            "--between", metavar="FROM:TO", type=_quietly(_stretch),
            help="Origin and destination, such as 20km:80km.  [default: the whole line]",
        ),
        option(
            "--at", metavar="TIME", type=_quietly(_target),
            help="Running time: a margin (10%), 1050s, 17:30 or 1:07:30.  [default: 10%]",
        ),
        option("--model", type=click.Choice(_MODELS), help="Of the instance.  [default: kinetic]"),
        option(
            "--energy", type=click.Choice(("wheel", "pantograph")),
            help="Braking gives nothing back, or what efficiency and regeneration leave.  [default: wheel]",
        ),
    ]  # fmt: skip
    return apply_all(options, command)


def trip_instance(
    steps: int,
    train: str | None = None,
    track: str | None = None,
    between: tuple[float, float] | None = None,
    at: Targets = _USUAL,
    model: str = "kinetic",
    energy: str = "wheel",
) -> "TripInstance":
    """Make the instance, its running time and top speed by the search; what readers noted is said on stderr."""
    from tgvdp.formats import read_source
    from tgvdp.formulations.problem.of_trip import binary_of_trip, demand_of_trip
    from tgvdp.model.energy import EnergyModel
    from tgvdp.model.trip import Trip

    read = read_source(train or DEFAULT_TRAIN, "train"), read_source(track or DEFAULT_TRACK, "track")
    for text in remarked([*read[0].remarks, *read[1].remarks]):
        click.echo(f"tgvdp: note: {text}", err=True)
    the_train, the_track = read[0].value, read[1].value
    origin_m, destination_m = between or (0.0, the_track.length_m)
    trip = Trip(
        train=the_train, track=the_track, origin_m=origin_m, destination_m=destination_m,
        energy=EnergyModel(kind=energy),
    )  # fmt: skip
    reference = _reference(trip, at)
    if model == "demand":
        return demand_of_trip(trip, reference, steps)
    return binary_of_trip(trip, reference, steps, model)  # type: ignore[arg-type]


def _reference(trip: "Trip", at: Targets) -> "Reference":
    from tgvdp.api import search
    from tgvdp.formulations.problem.of_trip import Reference

    result = search(
        trip.train, trip.track, origin_m=trip.origin_m, destination_m=trip.destination_m,
        at_s=at.time_s, at_margin=at.margin,
    )  # fmt: skip
    top_mps = float(result.fastest.profile.speed_mps.max())
    time_s, energy_j = (float(values[-1]) for values in (result.front.time_s, result.front.energy_j))
    return Reference(result.fastest.time_s, top_mps, time_s, energy_j)
