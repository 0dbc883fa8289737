"""A search's result as the JSON object and the CSV tables that scripts read. Pure: nothing is written here."""

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tgvdp.model.energy import violations
from tgvdp.report.plain import plain
from tgvdp.runs.comfort import ride_of
from tgvdp.units import KILO, joule_to_kwh, mps_to_kmh

if TYPE_CHECKING:
    from tgvdp.api import SearchResult
    from tgvdp.certificate.front import Certificate
    from tgvdp.referee.replay import Verdict
    from tgvdp.runs.profile import Profile

SCHEMA = "tgvdp.search/1"
VERDICT_FIELDS = ("time_error_pct", "energy_error_pct", "overspeed_mps", "effort_excess_pct", "ok")
FRONT_COLUMNS = (
    "id", "time_s", "delay_s", "margin_pct", "energy_kwh", "saved_pct", "price_kwh_per_min", "lower_bound_kwh",
    "gap_pct",
)  # fmt: skip
#: Where the energy goes, whichever model was minimised; see `tgvdp.runs.profile.EnergyBalance`.
BALANCE_FIELDS = ("wheel_kwh", "pantograph_kwh", "regenerated_kwh", "auxiliary_kwh", "braking_losses_kwh")
#: Accelerations and jerk; see `tgvdp.runs.comfort.Ride`.
RIDE_FIELDS = ("acceleration_mps2", "deceleration_mps2", "jerk_mps3")
PROFILE_COLUMNS = ("id", "position_m", "speed_mps", "time_s", "force_n", "energy_j", "regime")
#: Id of the fastest run in ``profiles.csv``; the points of the front have integer ids from 0.
FASTEST_ID = "fastest"


def result_object(
    result: "SearchResult",
    verdicts: Sequence["Verdict"],
    provenance: Mapping[str, Any],
    certificate: "Certificate | None" = None,
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

    Returns
    -------
    dict
        Schema ``tgvdp.search/1``, in plain types. Energies in kWh by the energy model that was searched, and beside
        them where the energy of each run goes; times in s. A figure that is not finite or not known is None: the price
        of the fastest run and of the methods on a grid, bounds without a certificate, the running time by explicit
        steps of a convention that has none. ``warning`` is present only where the front is less than was asked for.
    """
    fastest = result.fastest
    front = []
    unknown = [None] * len(result.front)
    prices = unknown if result.price_kwh_per_min is None else result.price_kwh_per_min.tolist()
    bounds = unknown if certificate is None else [joule_to_kwh(bound) for bound in certificate.lower_bound_j.tolist()]
    gaps = unknown if certificate is None else certificate.gap_pct.tolist()
    times, energies = result.front.time_s.tolist(), result.front.energy_j.tolist()
    rows = zip(times, energies, prices, bounds, gaps, verdicts, strict=True)
    for index, (time_s, energy_j, price, bound, gap, verdict) in enumerate(rows):
        profile = result.profile(index)
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
                "balance": _balance(profile),
                "ride": ride_of(profile)._asdict(),
                "replay": {name: plain(getattr(verdict, name)) for name in VERDICT_FIELDS},
            }
        )
    content = {
        "schema": SCHEMA,
        "method": result.method,
        "complete": bool(result.complete),
        "energy": _energy_of(result),
        "fastest": {
            "time_s": float(fastest.time_s),
            "energy_kwh": joule_to_kwh(float(fastest.energy_j)),
            "stepped_time_s": plain(fastest.stepped_time_s),
            "balance": _balance(fastest.profile),
            "ride": ride_of(fastest.profile)._asdict(),
        },
        "front": front,
        "counters": plain(result.counters),
        "provenance": plain(provenance),
    }
    if result.warnings:
        content["warning"] = "; ".join(result.warnings)
    return content


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


def front_csv(content: Mapping[str, Any]) -> str:
    """One line per point of the front of an object from `result_object`; figures that are not known stay empty."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*FRONT_COLUMNS, *BALANCE_FIELDS, *RIDE_FIELDS, *VERDICT_FIELDS])
    for point in content["front"]:
        parts = (
            (point, FRONT_COLUMNS),
            (point["balance"], BALANCE_FIELDS),
            (point["ride"], RIDE_FIELDS),
            (point["replay"], VERDICT_FIELDS),
        )
        writer.writerow([part[name] for part, names in parts for name in names])
    return text.getvalue()


def profiles_csv(result: "SearchResult") -> str:
    """All rows of the fastest run and of every point of the front.

    Twelve digits keep the difference of neighbouring positions and speeds exact enough to be replayed.
    """
    lines = [",".join(PROFILE_COLUMNS)]
    lines.extend(_profile_lines(FASTEST_ID, result.fastest.profile))
    for index in range(len(result.front)):
        lines.extend(_profile_lines(str(index), result.profile(index)))
    return "\n".join(lines) + "\n"


def _profile_lines(name: str, profile: "Profile") -> Iterator[str]:
    row = f"{name},%.12g,%.12g,%.12g,%.9g,%.12g,%s"
    numbers = (profile.position_m, profile.speed_mps, profile.time_s, profile.force_n, profile.energy_j)
    # Adding 0 turns −0 into 0.
    columns = [(values + 0.0).tolist() for values in numbers]
    return map(row.__mod__, zip(*columns, profile.regime_names, strict=True))
