"""A search's result as the JSON object and the table that scripts read. Pure: nothing is written here."""

import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from tgvdp.model.checks import require_number
from tgvdp.model.energy import violations
from tgvdp.report.advice import sentence
from tgvdp.report.line_met import line_object
from tgvdp.report.plain import plain
from tgvdp.runs.comfort import ride_of
from tgvdp.runs.instructions import instructions_of
from tgvdp.runs.peak_power import peak_power_w
from tgvdp.units import KILO, joule_to_kwh, mps_to_kmh

if TYPE_CHECKING:
    from tgvdp.api import SearchResult
    from tgvdp.certificate.front import Certificate
    from tgvdp.model.trip import Trip
    from tgvdp.referee.replay import Verdict
    from tgvdp.report.columns import Columns
    from tgvdp.runs.profile import Profile

SCHEMA = "tgvdp.search/1"
VERDICT_FIELDS = ("time_error_pct", "energy_error_pct", "overspeed_mps", "effort_excess_pct", "ok")
FRONT_COLUMNS = (
    "id", "time_s", "delay_s", "margin_pct", "energy_kwh", "saved_pct", "price_kwh_per_min", "lower_bound_kwh",
    "gap_pct", "peak_power_kw",
)  # fmt: skip
#: Where the energy goes, whichever model was minimised; see `tgvdp.runs.profile.EnergyBalance`.
BALANCE_FIELDS = ("wheel_kwh", "pantograph_kwh", "regenerated_kwh", "auxiliary_kwh", "braking_losses_kwh")
#: Accelerations and jerk; see `tgvdp.runs.comfort.Ride`.
RIDE_FIELDS = ("acceleration_mps2", "deceleration_mps2", "jerk_mps3")
#: What a tariff adds to each run.
TARIFF_FIELDS = ("cost_eur", "co2_kg")
#: Points between two words of progress.
_TELL_EVERY = 500


class Tariff(NamedTuple):
    """What a kilowatt-hour drawn from the line costs; None where nobody said.

    Attributes
    ----------
    price_per_kwh : float, optional
        €/kWh.
    co2_g_per_kwh : float, optional
        Grams of CO2 per kWh.

    Notes
    -----
    Both count the energy at the pantograph, less what is returned, whichever energy was minimised.
    """

    price_per_kwh: float | None = None
    co2_g_per_kwh: float | None = None

    def of(self, profile: "Profile") -> dict[str, float]:
        """Cost, €, and CO2, kg, of a run; without what is not known."""
        drawn_kwh = joule_to_kwh(profile.balance.pantograph_j)
        grams = None if self.co2_g_per_kwh is None else drawn_kwh * self.co2_g_per_kwh
        amounts = (
            None if self.price_per_kwh is None else drawn_kwh * self.price_per_kwh,
            None if grams is None else grams / KILO,
        )
        return {name: amount for name, amount in zip(TARIFF_FIELDS, amounts, strict=True) if amount is not None}


def make_tariff(price_per_kwh: float | None = None, co2_g_per_kwh: float | None = None) -> Tariff:
    """Check what a kilowatt-hour costs.

    Raises
    ------
    InputError
        When a figure is negative or no number.
    """
    given = {"price_per_kwh": (price_per_kwh, "€/kWh"), "co2_g_per_kwh": (co2_g_per_kwh, "g/kWh")}
    return Tariff(
        **{
            name: None if value is None else require_number("tariff", name, value, unit, at_least=0.0)
            for name, (value, unit) in given.items()
        }
    )


def result_object(
    result: "SearchResult",
    verdicts: Sequence["Verdict"],
    provenance: Mapping[str, Any],
    certificate: "Certificate | None" = None,
    *,
    tariff: Tariff | None = None,
    notes: Sequence[str] = (),
    progress: Callable[[str], None] | None = None,
    expired: Callable[[], bool] = bool,
) -> dict[str, Any]:
    """Build the object that ``--json`` prints and ``result.json`` holds.

    Parameters
    ----------
    result : SearchResult
    verdicts : sequence of Verdict
        One per point of the front, as ``result.verify()`` returns them.
    provenance : mapping
        As `make_provenance` returns it.
    certificate : Certificate, optional
        As ``result.certify()`` returns it.
    tariff : Tariff, optional
        Adds what the runs cost and emit.
    notes : sequence of str
        More to be said in ``warning``.
    progress : callable, optional
        Told now and then how far this is.
    expired : callable, optional
        Whether the time is up for what the rows of runs say; points that are not reached lack it.

    Returns
    -------
    dict
        Schema ``tgvdp.search/1``, in plain types; docs/results.md says what each field means. A figure that is not
        finite or not known is None. ``warning`` is present only where something is less than was asked for.
    """
    fastest, trip = result.fastest, result.trip
    tariff = tariff or Tariff()
    known = _figures(fastest.profile, trip, tariff)
    not_known = {name: dict.fromkeys(figure) if isinstance(figure, dict) else None for name, figure in known.items()}
    front = []
    unknown = [None] * len(result.front)
    prices = unknown if result.price_kwh_per_min is None else result.price_kwh_per_min.tolist()
    bounds = unknown if certificate is None else [joule_to_kwh(bound) for bound in certificate.lower_bound_j.tolist()]
    gaps = unknown if certificate is None else certificate.gap_pct.tolist()
    times, energies = result.front.time_s.tolist(), result.front.energy_j.tolist()
    rows = zip(times, energies, prices, bounds, gaps, verdicts, strict=True)
    for index, (time_s, energy_j, price, bound, gap, verdict) in enumerate(rows):
        if progress is not None and index % _TELL_EVERY == 0:
            progress(f"summing up, {index} of {len(times)}")
        front.append(
            {
                "id": index,
                "time_s": time_s,
                "delay_s": time_s - fastest.time_s,
                "margin_pct": margin_pct(time_s, fastest.time_s),
                "energy_kwh": joule_to_kwh(energy_j),
                "saved_pct": saved_pct(energy_j, fastest.energy_j),
                "price_kwh_per_min": plain(price),
                "lower_bound_kwh": plain(bound),
                "gap_pct": plain(gap),
                **(not_known if expired() else _figures(result.profile(index), trip, tariff)),
                "replay": {name: plain(getattr(verdict, name)) for name in VERDICT_FIELDS},
            }
        )
    content = {
        "schema": SCHEMA,
        "method": result.method,
        "complete": bool(result.complete),
        "trip": _trip_of(result),
        "line": line_object(result.trip),
        "energy": _energy_of(result),
        "tariff": tariff._asdict(),
        "fastest": {
            "time_s": float(fastest.time_s),
            "energy_kwh": joule_to_kwh(float(fastest.energy_j)),
            "stepped_time_s": plain(fastest.stepped_time_s),
            **known,
        },
        "front": front,
        "practices": {"linear_margin": _linear_margin(result, expired)},
        "counters": plain(result.counters),
        "provenance": plain(provenance),
    }
    if warnings := (*result.warnings, *notes):
        content["warning"] = "; ".join(warnings)
    return content


def _linear_margin(result: "SearchResult", expired: Callable[[], bool]) -> list[dict[str, float]]:
    """What the linear margin takes at the points of the front, as far as time allows.

    Nothing where a trip does not begin and end at rest.
    """
    if result.trip.start_speed_mps or result.trip.end_speed_mps:
        return []
    within_time = itertools.takewhile(lambda _: not expired(), range(len(result.front)))
    profiles = map(result.linear_margin, within_time)
    return [{"time_s": one.duration_s, "energy_kwh": joule_to_kwh(one.total_energy_j)} for one in profiles]


def _trip_of(result: "SearchResult") -> dict[str, Any]:
    """Who runs where."""
    trip = result.trip
    ends = ("origin_m", "destination_m", "start_speed_mps", "end_speed_mps")
    return {"train": trip.train.name, "track": trip.track.name, **{name: getattr(trip, name) for name in ends}}


def _figures(profile: "Profile", trip: "Trip", tariff: Tariff) -> dict[str, Any]:
    """What the rows of a run say."""
    return {
        "peak_power_kw": peak_power_w(profile, trip.train) / KILO,
        **tariff.of(profile),
        "balance": _balance(profile),
        "ride": ride_of(profile)._asdict(),
        "advice": sentence(trip.track, instructions_of(profile)),
    }


def _balance(profile: "Profile") -> dict[str, float]:
    kwh = (joule_to_kwh(float(value)) for value in profile.balance)
    return dict(zip(BALANCE_FIELDS, kwh, strict=True))


def _energy_of(result: "SearchResult") -> dict[str, Any]:
    """The energy model, and for a map where it breaks the conservation of energy."""
    model = result.trip.energy
    if model.map is None:
        return {"model": model.kind}
    faults = [
        {"speed_kmh": mps_to_kmh(one.speed_mps), "demand": one.demand, "drawn_kw": one.power_w / KILO,
         "at_least_kw": one.bound_w / KILO}
        for one in violations(result.trip.train, model.map)
    ]  # fmt: skip
    return {"model": model.kind, "map": model.map.name, "violations": faults}


def margin_pct(time_s: float, fastest_s: float) -> float:
    """Running-time margin over the fastest run, in percent."""
    return 100.0 * (time_s / fastest_s - 1.0)


def saved_pct(energy_j: float, fastest_j: float) -> float:
    """Energy saved against the fastest run, in percent of its own (which may be returned); 0 where it needs none."""
    return 100.0 * (fastest_j - energy_j) / abs(fastest_j) if fastest_j else 0.0


def front_columns(content: Mapping[str, Any]) -> "Columns":
    """Columns of ``front.csv`` of an object from `result_object`: one row per point of the front."""
    front = content["front"]
    own = (*FRONT_COLUMNS, *(name for name in TARIFF_FIELDS if name in content["fastest"]))
    columns: dict[str, list[Any]] = {name: [point[name] for point in front] for name in own}
    for part, names in (("balance", BALANCE_FIELDS), ("ride", RIDE_FIELDS), ("replay", VERDICT_FIELDS)):
        columns |= {name: [point[part][name] for point in front] for name in names}
    return columns
