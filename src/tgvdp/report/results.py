"""The results folder of a search: result.json, two tables, pictures and provenance.json."""

import json
import math
import os
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from tgvdp.errors import InputError
from tgvdp.report.advice import step_columns, step_object
from tgvdp.report.columns import to_csv, to_parquet, to_xlsx
from tgvdp.report.courses import driving_course_csv
from tgvdp.report.pictures import check_formats, pictures_of
from tgvdp.report.plain import to_json
from tgvdp.report.profiles import (
    PROFILE_DIGITS,
    Progress,
    Written,
    choose_runs,
    most_rows_in,
    profile_columns,
    runs_of,
)
from tgvdp.report.provenance import Input, make_provenance, write_ledger
from tgvdp.report.tables import Tariff, front_columns, result_object
from tgvdp.runs.instructions import instructions_of

if TYPE_CHECKING:
    from tgvdp.api import SearchResult
    from tgvdp.certificate.front import Certificate
    from tgvdp.methods.grid.trace import Trace
    from tgvdp.referee.replay import Verdict

#: Formats of the tables.
TABLE_FORMATS = ("csv", "parquet", "xlsx", "railtoolkit")


class Results(NamedTuple):
    """What was written: the files, the object that result.json holds, and how many pictures there was no time for."""

    files: list[Path]
    content: dict[str, Any]
    undrawn: int


def write_results(
    result: "SearchResult",
    out_dir: str | os.PathLike[str],
    provenance: Mapping[str, Any] | None = None,
    verdicts: Sequence["Verdict"] | None = None,
    certificate: "Certificate | None" = None,
    *,
    profiles: str = "csv",
    every_m: float | None = None,
    trace: "Trace | None" = None,
    pictures: Sequence[str] = ("png",),
    tariff: Tariff | None = None,
    drawn: Callable[[], Mapping[str, bytes]] | None = None,
    progress: Progress | None = None,
    time_s: float = math.inf,
) -> Results:
    """Write all files of a result into a folder, all or none.

    JSON and pictures carry the provenance themselves. The tables stay plain for the scripts that read them;
    ``provenance.json`` ties every file to its origin by its SHA-256.

    Parameters
    ----------
    result : SearchResult
    out_dir : path
        Made when absent; files of an earlier run are replaced.
    provenance : mapping, optional
        As `make_provenance` returns it; by default of the result itself.
    verdicts : sequence of Verdict, optional
        Of ``result.verify()``, when the caller has them already.
    certificate : Certificate, optional
        Of ``result.certify()``; without it files and pictures hold no bounds.
    profiles : {"csv", "parquet", "xlsx", "railtoolkit"}
        Format of the tables of the front and of its speed profiles.
    every_m : float, optional
        Distance between the rows of a profile, m; by default all rows are written.
    trace : Trace, optional
        Of ``result.trace()``: adds trace.json, trace.graphml and its picture.
    pictures : sequence of {"png", "svg", "pdf"}
        Formats of the pictures; empty means none.
    tariff : Tariff, optional
        What a kilowatt-hour costs and emits.
    drawn : callable, optional
        Returns the pictures, when they are drawn elsewhere meanwhile (`tgvdp.report.gallery`).
    progress : callable, optional
        Told in a few words what is being written.
    time_s : float, optional
        Time for summing up and for the tables, s, half of it for each. Points that are not summed up lack the figures
        of their rows; where all profiles would take longer, evenly spread ones are written.

    Returns
    -------
    Results

    Raises
    ------
    InputError
        When the folder cannot be written, or an option is out of range.
    """
    if profiles not in TABLE_FORMATS:
        raise InputError(f"profiles must be one of {', '.join(TABLE_FORMATS)}, got {profiles!r:.40}")
    if every_m is not None and profiles == "railtoolkit":
        raise InputError("a driving course of railtoolkit has all rows: every_m is for the other formats of profiles")
    check_formats(pictures)
    if not provenance:
        inputs: dict[str, Input] = {"train": result.trip.train, "track": result.trip.track}
        provenance = make_provenance(result.options, inputs, result.elapsed_s)
    started_s, half_s = time.perf_counter(), 0.5 * time_s
    written = choose_runs(result, every_m, most_rows_in(half_s))
    content = result_object(
        result, result.verify() if verdicts is None else verdicts, provenance, certificate, tariff=tariff,
        notes=[written.note] if written.note else [], progress=progress,
        expired=lambda: time.perf_counter() - started_s > half_s,
    )  # fmt: skip
    files = _tables(result, content, written, profiles, progress)
    undrawn = 0
    if pictures:
        if progress is not None:
            progress("drawing")
        price_per_kwh = content["tariff"]["price_per_kwh"]
        made = _draw(result, provenance, pictures, certificate, price_per_kwh) if drawn is None else drawn()
        undrawn = len(pictures) * len(pictures_of(result)) - len(made)
        if undrawn:
            note = f"the time limit left no time for {undrawn} pictures"
            content["warning"] = "; ".join(filter(None, (content.get("warning"), note)))
        files |= made
    if trace is not None:
        files |= _trace(trace, provenance, pictures)
    return Results(write_ledger(out_dir, {"result.json": to_json(content), **files}, provenance), content, undrawn)


def _tables(
    result: "SearchResult", content: Mapping[str, Any], written: Written, format: str, progress: Progress | None
) -> dict[str, bytes]:
    front = front_columns(content)
    told = ((name, instructions_of(profile)) for name, profile in runs_of(result, written))
    advice = step_columns((name, list(map(step_object, steps))) for name, steps in told)
    if format == "railtoolkit":
        course = driving_course_csv(result, written, progress)
        return {"front.csv": to_csv(front), "advice.csv": to_csv(advice), "driving_course.csv": course.encode()}
    rows = profile_columns(result, written, progress)
    if format == "parquet":
        tables = {"front": front, "advice": advice, "profiles": rows}
        return {f"{name}.parquet": to_parquet(table) for name, table in tables.items()}
    if format == "xlsx":
        return {"result.xlsx": to_xlsx({"front": front, "advice": advice, "profiles": rows})}
    return {"front.csv": to_csv(front), "advice.csv": to_csv(advice), "profiles.csv": to_csv(rows, PROFILE_DIGITS)}


def _trace(trace: "Trace", provenance: Mapping[str, Any], formats: Sequence[str]) -> dict[str, bytes]:
    files = {"trace.json": json.dumps(trace.to_object()).encode(), "trace.graphml": trace.to_graphml()}
    if formats:
        from tgvdp.report.pictures import encode
        from tgvdp.report.trace_plots import plot_trace

        files |= {f"trace.{format}": encode(plot_trace(trace), provenance, format) for format in formats}
    return files


def _draw(
    result: "SearchResult",
    provenance: Mapping[str, Any],
    formats: Sequence[str],
    certificate: "Certificate | None",
    price_per_kwh: float | None,
) -> dict[str, bytes]:
    # Here, so that whoever wants no picture does not wait for matplotlib.
    from tgvdp.report.gallery import front_files, run_files

    front = front_files(formats, math.inf, result, provenance, certificate)
    return front | run_files(formats, math.inf, result, provenance, price_per_kwh)
