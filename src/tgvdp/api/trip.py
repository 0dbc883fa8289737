"""From what a search is given to the trip that it runs: names are looked up, the line is turned and restricted."""

import os
from typing import TypeVar

from tgvdp.api.sense import sensible_numbers
from tgvdp.constants import ENERGY_KINDS
from tgvdp.errors import InputError
from tgvdp.formats import load_energy_map, load_track, load_train
from tgvdp.formats.sources import Source
from tgvdp.line.resolved import resolve
from tgvdp.model.convention import Convention, convention_of
from tgvdp.model.energy import BUILT_IN_MAP, EnergyMap, EnergyModel
from tgvdp.model.track import SpeedRestriction, Track
from tgvdp.model.train import Train
from tgvdp.model.trip import Trip
from tgvdp.model.variants import restricted_track, reversed_track, train_in_wind
from tgvdp.options.search import SearchOptions

_Kind = TypeVar("_Kind", Train, Track)


def resolve_line(trip: Trip, max_memory_b: float | None = None) -> None:
    """Resolve the line of a trip, which whoever searches it finds done; errors as of `tgvdp.search`."""
    with sensible_numbers(trip, max_memory_b):
        resolve(trip)


def trip_of(train: Train | Source, track: Track | Source, options: SearchOptions) -> Trip:
    """Make the trip that is asked for.

    Raises
    ------
    InputError
        When train or track are none and name none, when positions lie outside the line, or when the wind cannot be
        represented.
    """
    the_train, the_track = _train(train, options.owner), _track(track, options.owner)
    convention = convention_of(
        options.convention,
        mass_model=options.mass_model,
        limits=options.limits,
        curves=options.curves,
        tunnels=options.tunnels,
    )
    if options.reverse:
        the_track = reversed_track(the_track)
    if options.speed_restrictions:
        the_track = restricted_track(the_track, map(SpeedRestriction._make, options.speed_restrictions))
    if options.wind_mps:
        _require_open_air(options.owner, the_track, convention)
        the_train = train_in_wind(the_train, options.wind_mps)
    return Trip(
        train=the_train,
        track=the_track,
        origin_m=options.origin_m,
        destination_m=the_track.length_m if options.destination_m is None else options.destination_m,
        start_speed_mps=options.start_speed_mps,
        end_speed_mps=options.end_speed_mps,
        energy=energy_model(options.energy, options.owner),
        convention=convention,
    )


def _train(given: Train | Source, owner: str) -> Train:
    if isinstance(given, str | os.PathLike):
        return load_train(given)
    return _made(owner, given, Train, "train", Track)


def _track(given: Track | Source, owner: str) -> Track:
    if isinstance(given, str | os.PathLike):
        return load_track(given)
    return _made(owner, given, Track, "track", Train)


def _made(owner: str, given: object, kind: type[_Kind], name: str, other: type) -> _Kind:
    if isinstance(given, kind):
        return given
    if isinstance(given, other):
        raise InputError(f"{owner}: {name} is a {other.__name__}: the order is {owner}(train, track)")
    raise InputError(f"{owner}: {name} must be a {kind.__name__}, a name of the catalog or a path, got {given!r:.60}")


def _require_open_air(owner: str, track: Track, convention: Convention) -> None:
    """Refuse wind where tunnels count: it does not blow there, and a train has one formula for the whole line."""
    if convention.tunnels and track.tunnels:
        raise InputError(f"{owner}: wind does not blow in the tunnels of track {track.name}: leave out wind or tunnels")


def energy_model(energy: str | EnergyMap, owner: str = "search") -> EnergyModel:
    """Make the energy model that an argument of an owner names."""
    if isinstance(energy, EnergyMap):
        return EnergyModel("map", energy)
    if not isinstance(energy, str):
        raise InputError(f"{owner}: energy must be one of {', '.join(ENERGY_KINDS)} or a map, got {energy!r:.60}")
    if energy in ("wheel", "pantograph"):
        return EnergyModel(energy)
    return EnergyModel("map", load_energy_map(BUILT_IN_MAP if energy == "map" else energy))
