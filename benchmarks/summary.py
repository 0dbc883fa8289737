"""The table of bars for README, rendered from the JSON files of the benchmarks."""

from collections.abc import Callable, Iterator
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

from benchmarks.output import read_reports, replace_between
from tgvdp.report.plain import shown

BEGIN, END = "<!-- benchmarks: begin (python -m benchmarks summary) -->", "<!-- benchmarks: end -->"


class Bar(NamedTuple):
    """One measured figure and the limits it is held to; ``sign`` +1: at most, −1: at least."""

    what: str
    unit: str
    must: float
    aim: float
    sign: int
    report: str
    figure: Callable[[dict[str, Any]], float | None]


def _of(*path: str) -> Callable[[dict[str, Any]], float | None]:
    def figure(figures: dict[str, Any]) -> float | None:
        value: Any = figures
        for name in path:
            value = value.get(name) if isinstance(value, dict) else None
        return value

    return figure


BARS = (
    Bar("energy above reference, main line, worst", "%", 0.10, 0.05, 1, "accuracy", _of("main line", "max_gap_pct")),
    Bar("energy above reference, metro, worst", "%", 0.20, 0.05, 1, "accuracy", _of("metro", "max_gap_pct")),
    Bar("energy above reference, main line, least", "%", -0.03, -0.03, -1, "accuracy", _of("main line", "min_gap_pct")),
    Bar("energy above reference, metro, least", "%", -0.03, -0.03, -1, "accuracy", _of("metro", "min_gap_pct")),
    Bar("error of the fastest running time", "%", 0.005, 0.005, 1, "accuracy", _of("t_min_error_pct")),
    Bar("certified gap, main line, median", "%", 0.15, 0.10, 1, "accuracy", _of("main line", "certified_median_pct")),
    Bar("certified gap, metro, median", "%", 0.50, 0.10, 1, "accuracy", _of("metro", "certified_median_pct")),
    Bar("replayed running time, error", "%", 0.05, 0.01, 1, "accuracy", _of("replay_time_pct")),
    Bar("replayed energy, error", "%", 0.05, 0.01, 1, "accuracy", _of("replay_energy_pct")),
    Bar("overspeed in replay", "m/s", 0.0, 0.0, 1, "accuracy", _of("overspeed_mps")),
    Bar("effort excess in replay", "%", 0.1, 0.01, 1, "accuracy", _of("effort_excess_pct")),
    Bar("replay of 60 profiles", "ms", 300.0, 300.0, 1, "accuracy", _of("replay_ms")),
    Bar("front of 60 points, up to 50 km, slowest", "ms", 10.0, 5.0, 1, "accuracy", _of("main line", "front_ms_max")),
    Bar("... on all cores", "ms", 10.0, 5.0, 1, "accuracy", _of("main line", "all_cores_ms_max")),
    Bar("front of 60 points, metro section, slowest", "ms", 3.0, 3.0, 1, "accuracy", _of("metro", "front_ms_max")),
    Bar("... on all cores", "ms", 3.0, 3.0, 1, "accuracy", _of("metro", "all_cores_ms_max")),
    Bar("front of 60 points, 500 km", "ms", 150.0, 150.0, 1, "scaling", _of("length km", "500")),
    Bar(
        "certificate of 60 points, main line, slowest",
        "ms",
        100.0,
        100.0,
        1,
        "accuracy",
        _of("main line", "certify_ms_max"),
    ),
    Bar("certificate of 60 points, metro, slowest", "ms", 100.0, 100.0, 1, "accuracy", _of("metro", "certify_ms_max")),
    Bar(
        "faster than IPOPT cold, within 0.03 %, main line, median",
        "×",
        150.0,
        500.0,
        -1,
        "ipopt",
        _of("main line", "cold_median"),
    ),
    Bar(
        "faster than IPOPT warm, within 0.03 %, main line, median",
        "×",
        150.0,
        500.0,
        -1,
        "ipopt",
        _of("main line", "warm_median"),
    ),
    Bar("... cold, as accurate as ours", "×", 150.0, 500.0, -1, "ipopt", _of("main line", "cold_equal_median")),
    Bar("... warm, as accurate as ours", "×", 150.0, 500.0, -1, "ipopt", _of("main line", "warm_equal_median")),
    Bar("faster than BOA* in C, median", "×", 5.0, 10.0, -1, "labels", _of("boa_ratio_median")),
    Bar("faster than BOA* in C, least", "×", 5.0, 10.0, -1, "labels", _of("boa_ratio_min")),
    Bar("faster than NAMOA*dr in C, median", "×", 5.0, 10.0, -1, "labels", _of("namoa_ratio_median")),
    Bar("faster than NAMOA*dr in C, least", "×", 5.0, 10.0, -1, "labels", _of("namoa_ratio_min")),
    Bar("memory per label, most", "B", 16.0, 16.0, 1, "labels", _of("bytes_per_label_most")),
    Bar("compilation, cold", "s", 7.0, 4.0, 1, "startup", _of("compilation, cold")),
    Bar("compilation, cached", "s", 0.4, 0.2, 1, "startup", _of("compilation, cached")),
    Bar("tgvdp search with pictures, cold", "s", 15.0, 10.0, 1, "startup", _of("tgvdp search, cold, all cores")),
    Bar("tgvdp search with pictures, warm", "s", 2.0, 1.0, 1, "startup", _of("tgvdp search, warm, all cores")),
    Bar("import tgvdp", "ms", 50.0, 50.0, 1, "startup", _of("import tgvdp alone")),
    Bar("tgvdp --help", "ms", 150.0, 150.0, 1, "startup", _of("process, tgvdp --help")),
    Bar("peak memory, 500 km", "MB", 300.0, 300.0, 1, "startup", _of("peak memory, 60 points with profiles")),
)


def table(reports: dict[str, dict[str, Any]]) -> str:
    """Markdown table of all bars that the reports have figures for."""
    lines = ["| what | measured | must | aim | |", "| --- | ---: | ---: | ---: | --- |", *_lines(reports)]
    quick = sorted(name for name, content in reports.items() if content["provenance"]["options"].get("quick"))
    machine = next(iter(reports.values()))["provenance"]
    processor, python, numba = machine["machine"]["processor"], machine["python"], machine["numba"]
    lines += ["", f"One core of {processor}{_pace(reports)}, Python {python}, numba {numba}."]
    if quick:
        lines.append(f"Not for keeping: quick runs of {', '.join(quick)}.")
    return "\n".join(lines) + "\n"


def _pace(reports: dict[str, dict[str, Any]]) -> str:
    """What an arc takes, by which times on other machines compare."""
    if "phases" not in reports:
        return ""
    return f" (an arc takes {median(row['ns/arc'] for row in reports['phases']['rows']):.3g} ns)"


def _lines(reports: dict[str, dict[str, Any]]) -> Iterator[str]:
    for bar in BARS:
        value = bar.figure(reports[bar.report]["figures"]) if bar.report in reports else None
        if value is None:
            yield f"| {bar.what} | not measured | {_limit(bar, bar.must)} | {_limit(bar, bar.aim)} | |"
            continue
        met = "missed"
        for name, limit in (("must", bar.must), ("aim", bar.aim)):
            if bar.sign * value <= bar.sign * limit:
                met = name
        yield (
            f"| {bar.what} | {shown(float(value))} {bar.unit} | {_limit(bar, bar.must)} | {_limit(bar, bar.aim)} "
            f"| {met if met == 'missed' else f'meets the {met}'} |"
        )


def _limit(bar: Bar, value: float) -> str:
    return f"{'≤' if bar.sign > 0 else '≥'} {value:g} {bar.unit}"


def summarise(folder: Path, readme: Path | None) -> str:
    """Render the table into ``summary.md`` of a folder and, between its marks, into a README; returns it."""
    reports = read_reports(folder)
    if not reports:
        return f"{folder}: no results yet"
    text = table(reports)
    (folder / "summary.md").write_text(f"# Benchmarks: the bars\n\n{text}", encoding="utf-8")
    if readme is not None:
        replace_between(readme, BEGIN, END, text)
    return text
