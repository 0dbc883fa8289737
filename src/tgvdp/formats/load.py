"""One thing from a file or the catalog: trains, tracks, journeys, maps, or all that a file holds."""

import functools
from hashlib import sha256
from typing import Any, cast

from tgvdp.formats.detect import read_source
from tgvdp.formats.scenario import Read, Scenario
from tgvdp.formats.sources import Source, source_path
from tgvdp.formats.syntax.reading import bad, listed, read_bytes, shown
from tgvdp.model import catalog
from tgvdp.model.energy import EnergyMap
from tgvdp.model.journey import Journey, Section
from tgvdp.model.track import Track
from tgvdp.model.train import Train


@functools.cache
def _built_in(name: str, kind: catalog.Kind) -> Any:
    return read_source(name, kind).value


def _value(source: Source, kind: catalog.Kind, line_speed_mps: float | None = None) -> Any:
    """What a source holds of a kind; things of the catalog, whose files do not change, are read once."""
    if isinstance(source, str) and line_speed_mps is None and source in catalog.names(kind):
        return _built_in(source, kind)
    return read_source(source, kind, line_speed_mps=line_speed_mps).value


def load_train(path_or_name: Source) -> Train:
    """Load a train from the catalog or from a file.

    Parameters
    ----------
    path_or_name : str or path
        A name of the catalog, or a file of any format that holds or references a train. Of several, ``FILE#NAME``
        means one.

    Raises
    ------
    InputError
        When there is no such name or file, or when it holds no valid train.
    """
    return cast(Train, _value(path_or_name, "train"))


def load_track(path_or_name: Source, *, line_speed_mps: float | None = None) -> Track:
    """Load a track from the catalog or from a file.

    Parameters
    ----------
    path_or_name : str or path
        A name of the catalog, or a file of any format that holds or references a track. Of several, ``FILE#NAME``
        means one.
    line_speed_mps : float, optional
        Speed limit wherever the file gives none, m/s, in formats that may lack limits: railML, SFERA, OSRD paths and
        tables.

    Raises
    ------
    InputError
        When there is no such name or file, or when it holds no valid track; when a line speed is given for a file
        of a format in which limits are never missing.
    """
    return cast(Track, _value(path_or_name, "track", line_speed_mps))


def load_journey(path: Source, track: Track | None = None) -> Journey:
    """Load a journey from a file.

    Parameters
    ----------
    path : str or path
    track : Track, optional
        The line, whose named places tell where a timetable of names alone stops.

    Raises
    ------
    InputError
        When there is no such file, or when it holds no valid journey, or none of the name behind ``#``.
    """
    return whole_of(read_source(path, "journey", track=track))


def whole_of(read: Read) -> Journey:
    """Return a journey that was read, all of it.

    Raises
    ------
    InputError
        When what stands behind ``#`` is no journey of the file.
    """
    if read.section not in (None, read.value.name):
        raise bad(read.path, f"holds no journey {shown(read.section or '')}; it holds: {read.value.name}")
    return cast(Journey, read.value)


def load_section(path: Source, track: Track | None = None) -> tuple[Journey, Section]:
    """Load a journey and choose a section; see `load_journey` and `section_of`."""
    read = read_source(path, "journey", track=track)
    return read.value, section_of(read, track)


def section_of(read: Read, track: Track | None = None) -> Section:
    """Choose a run from stop to stop of a journey that was read: the first one, or as ``FILE#2``, ``FILE#Aston`` say.

    Parameters
    ----------
    read : Read
    track : Track, optional
        The line, whose names of stops choose sections that begin there, too, as those of the journey do.

    Raises
    ------
    InputError
        When there is no section of that number or name, or several.
    """
    sections: tuple[Section, ...] = read.value.sections
    part = "1" if read.section in (None, read.value.name) else read.section
    names = [_names_at(section.origin_m, read.value, track) for section in sections]
    found = [section for section in sections if str(section.number) == part] or [
        section for section, own in zip(sections, names, strict=True) if part.casefold() in map(str.casefold, own)
    ]
    if len(found) == 1:
        return found[0]
    told = listed([shown(own[0]) for own in names if own])
    begin = f"{', which begin at' if all(names) else ', of which some begin at'} {told}" if told else ""
    doubt = f"{len(found)} of which begin at" if found else "got"
    raise bad(read.path, f"has sections 1 to {len(sections)}{begin}, {doubt} {part!r:.40}")


def _names_at(position_m: float, journey: Journey, track: Track | None) -> list[str]:
    """What a journey and its line call a position, m."""
    own = [place.name for place in journey.places if place.position_m == position_m]
    lines = [track.name_at(position_m)] if track is not None else []
    return [name for name in (*own, *lines) if name]


def load_energy_map(path_or_name: Source) -> EnergyMap:
    """Load a map of the power drawn over speed and demand from the catalog or from a file.

    Parameters
    ----------
    path_or_name : str or path
        A name of the catalog, or a native file that holds or references a map.

    Raises
    ------
    InputError
        When there is no such name or file, or when it holds no valid map.
    """
    return cast(EnergyMap, _value(path_or_name, "map"))


def load_scenario(path: Source, *, line_speed_mps: float | None = None) -> Scenario:
    """Load everything that a file holds, and what it references.

    Parameters
    ----------
    path : str or path
    line_speed_mps : float, optional
        See `load_track`.

    Raises
    ------
    InputError
        When the file or one that it references is missing or wrong, or when it holds several trains or tracks and
        none is chosen by ``FILE#NAME``.
    """
    return cast(Scenario, read_source(path, line_speed_mps=line_speed_mps).value)


def input_digest(path_or_name: Source) -> str:
    """SHA-256, in hexadecimal, of the bytes of a file or of a file of the catalog."""
    return sha256(read_bytes(source_path(path_or_name))).hexdigest()
