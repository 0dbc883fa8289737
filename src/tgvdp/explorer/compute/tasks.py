"""What a child process can be asked to do, by name; arguments and values are what msgpack can hold."""

import warnings
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import msgspec

from tgvdp import api, formats
from tgvdp.api import warm as kernels
from tgvdp.errors import InputError
from tgvdp.explorer.compute.asked import OFFERED, Asked, FieldError, File, is_upload, upload_of
from tgvdp.explorer.compute.editable import editable_of
from tgvdp.explorer.exhibit import profile_columns, profile_json, profiles_of, search_exhibit
from tgvdp.formats.native.changes import changed
from tgvdp.formats.review.describe import describe
from tgvdp.model.energy import EnergyMap
from tgvdp.model.track import Track
from tgvdp.model.train import Train
from tgvdp.options.search import arguments_of
from tgvdp.progress import Listener, heard_by
from tgvdp.report.line_met import line_object
from tgvdp.report.provenance import make_provenance
from tgvdp.report.tables import result_object
from tgvdp.units import joule_to_kwh, kmh_to_mps


class _Case(NamedTuple):
    """What is searched, and what it was made of."""

    train: Train
    track: Track
    arguments: dict[str, Any]
    mass_kg: float  # before edits
    inputs: dict[str, Any]


def read(tell: Listener, file: Mapping[str, Any], line_speed_kmh: float | None = None) -> dict[str, Any]:
    """Read an uploaded file and say what it holds."""
    tell("reading")
    return {"holds": [_described(scenario) for scenario in _scenarios(msgspec.convert(file, File), line_speed_kmh)]}


def _described(scenario: formats.Scenario) -> dict[str, Any]:
    description = describe(scenario)
    return {
        "kinds": [kind for kind in ("train", "track", "map", "journey") if getattr(scenario, kind) is not None],
        "name": description.name,
        "format": description.format,
        "headline": description.headline,
        "notes": list(description.notes),
        "options": scenario.options,
    }


def _scenarios(file: File, line_speed_kmh: float | None) -> tuple[formats.Scenario, ...]:
    line_speed_mps = None if line_speed_kmh is None else kmh_to_mps(line_speed_kmh)
    return formats.load_bytes(file.name, file.data, line_speed_mps=line_speed_mps)


def run(tell: Listener, asked: Mapping[str, Any], uploads: Mapping[str, Any]) -> dict[str, Any]:
    """Search, replay, prove, and make the exhibit of it."""
    request = msgspec.convert(asked, Asked)
    case = _case(request, msgspec.convert(uploads, dict[str, File]))
    with heard_by(tell), warnings.catch_warnings(record=True):
        tell("searching")
        result = api.search(case.train, case.track, **case.arguments)
        tell("replaying")
        verdicts = result.verify()
        tell("proving")
        certificate = result.certify()
        about = make_provenance(result.options, case.inputs, result.elapsed_s)
        content = result_object(result, verdicts, about, certificate)
        tell("summing up")
        name = ", ".join([f"{case.train.name} on {case.track.name}", *_differences(request)])
        reverse = case.arguments.get("reverse", False)
        editable = editable_of(result.trip, case.track, case.mass_kg, reverse=reverse)
        exhibit = search_exhibit(
            name, content, profiles_of(result), trace=_trace(result), asked=asked, editable=editable
        )
    return {"name": exhibit.name, "view": exhibit.view, "profiles": exhibit.profiles}


def _trace(result: api.SearchResult) -> dict[str, Any] | None:
    """Steps of a best-first search, where it has so few that one can watch them."""
    if result.method != "best-first":
        return None
    trace = result.trace()
    return trace.to_object() if trace.complete else None


def _differences(asked: Asked) -> list[str]:
    """What a run has that the usual one has not, in a few words each."""
    options = [f"{OFFERED[name].name} {value}" for name, value in asked.options.items() if not is_upload(str(value))]
    limits = f"{len(asked.limits_kmh)} limits changed" if asked.limits_kmh else ""
    mass = "" if asked.mass_t is None else f"{asked.mass_t:g} t"
    return [text for text in (*options, mass, limits) if text]


def draft(tell: Listener, asked: Mapping[str, Any], uploads: Mapping[str, Any], delay_s: float) -> dict[str, Any]:
    """Search anew while somebody drags: the front, and the profile nearest to a delay, unproven."""
    case = _case(msgspec.convert(asked, Asked), msgspec.convert(uploads, dict[str, File]))
    result = api.search(case.train, case.track, **case.arguments)
    fastest, front = result.fastest, result.front
    index = int(abs(front.time_s - fastest.time_s - delay_s).argmin())
    content = {
        "fastest": {"time_s": fastest.time_s, "energy_kwh": joule_to_kwh(fastest.energy_j)},
        "time_s": front.time_s.tolist(),
        "energy_kwh": [joule_to_kwh(energy_j) for energy_j in front.energy_j.tolist()],
        "index": index,
        "line": line_object(result.trip),
        "elapsed_s": result.elapsed_s,
    }
    profile = profile_json(profile_columns(result.profile(index)))
    return {"content": msgspec.json.encode(content), "profile": profile}


def _case(asked: Asked, uploads: Mapping[str, File]) -> _Case:
    """Read what is asked for; errors name the field of the form."""
    train, inputs = _part("train", asked.train, uploads, None)
    track, track_input = _part("track", asked.track, uploads, asked.line_speed_kmh)
    options = dict(asked.options)
    energy = str(options.get("energy"))
    if is_upload(energy):
        options["energy"] = _held("map", energy, uploads, None)
    mass_kg = train.mass_kg
    for field, edits in asked.edits.items():
        try:
            train, track, *_ = changed(train, track, edits)
        except InputError as error:
            raise FieldError(field, str(error)) from None
    return _Case(train, track, arguments_of(options), mass_kg, {"train": inputs, "track": track_input})


def _part(kind: str, source: str, uploads: Mapping[str, File], line_speed_kmh: float | None) -> tuple[Any, Any]:
    """A train or track, and where it comes from."""
    if is_upload(source):
        value = _held(kind, source, uploads, line_speed_kmh)
        return value, value
    held = formats.read_source(source, kind)  # type: ignore[arg-type]  # a name of the catalog, as was checked
    return held.value, held.fingerprint


def _held(kind: str, source: str, uploads: Mapping[str, File], line_speed_kmh: float | None) -> Any:
    """What an uploaded file holds of a kind."""
    file, item = upload_of(source, uploads, kind)
    try:
        scenarios = _scenarios(file, line_speed_kmh if kind == "track" else None)
    except InputError as error:
        raise FieldError(kind, str(error)) from None
    value: Train | Track | EnergyMap | None = getattr(scenarios[item], kind, None) if item < len(scenarios) else None
    if value is None:
        raise FieldError("energy" if kind == "map" else kind, f"{file.name}: holds no such {kind}")
    return value


def warm(tell: Listener) -> None:
    """Load, or compile, what a search needs."""
    tell("loading the compiled kernels")
    kernels.tour("front")
    kernels.checks()


TASKS: dict[str, Callable[..., Any]] = {"read": read, "run": run, "draft": draft, "warm": warm}
