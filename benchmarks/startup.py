"""What a fresh process pays: import, ``--help``, compilation with an empty and a filled cache, pictures, memory."""

import os
import statistics
import tempfile
from pathlib import Path
from typing import Any

from benchmarks.instances import SHARED
from benchmarks.output import Report
from benchmarks.timing import probe, run_fresh
from tgvdp.report import palette, style

SHORT_M, LONG_M = 30e3, 500e3


def run(_shared: Path = SHARED, quick: bool = False) -> Report:
    """Measure fresh processes."""
    repeats = 1 if quick else 5
    long_m = 60e3 if quick else LONG_M
    report = Report(
        "startup",
        "Start: import, help, compilation, memory",
        options={"quick": quick, "repeats": repeats},
        notes=[
            "Fresh processes on one core, medians. `process` rows are wall time from start to exit.",
            "`tgvdp search` rows are the default search with its certificate, tables and pictures: with an empty cache "
            "(cold) and a filled one (warm), on all cores and on one; the processor time is that of all its processes. "
            f"There are {os.cpu_count()} cores{_busy()}.",
            f"Compilation: first search minus the same search warm, synthetic line of {SHORT_M / 1e3:g} km, with an "
            "empty cache folder (cold, on one core and on all) and with one that is filled (cached).",
            f"Memory: largest resident set of a process that searches a line of {long_m / 1e3:g} km, 60 points, and "
            "keeps all profiles (Linux: VmHWM); `after loading` is what Python, numpy and numba take before it.",
        ],
    )
    bare_s = _process_s("pass", repeats)
    import_s = _process_s("import tgvdp", repeats)
    help_s = statistics.median(run_fresh(["-m", "tgvdp", "--help"])[0] for _ in range(repeats))
    cold, shared, cached = [], [], []
    searches = _searches(repeats)
    with tempfile.TemporaryDirectory() as folder:
        for index in range(1 if quick else 3):
            cache = {"TGVDP_CACHE_DIR": str(Path(folder) / str(index))}
            cold.append(probe(SHORT_M, 60, 3, environment=cache))
            other = {"TGVDP_CACHE_DIR": str(Path(folder) / f"{index}, all cores")}
            shared.append(probe(SHORT_M, 60, 3, environment=other, all_cores=True))
            cached += [probe(SHORT_M, 60, 3, environment=cache) for _ in range(repeats if index == 0 else 1)]
        memory = [probe(long_m, 60, 1, environment=cache) for _ in range(1 if quick else 3)]

    def middle(found: list[dict[str, Any]], name: str) -> float:
        return statistics.median(one[name] for one in found)

    values = {
        "process, python alone": ("ms", 1e3 * bare_s),
        "process, import tgvdp": ("ms", 1e3 * import_s),
        "import tgvdp alone": ("ms", 1e3 * middle(cached, "import_s")),
        "process, tgvdp --help": ("ms", 1e3 * help_s),
        "loading numpy, numba and tgvdp.search": ("s", middle(cached, "load_s")),
        "compilation, cold": ("s", middle(cold, "jit_s")),
        "compilation, cold, all cores": ("s", middle(shared, "jit_s")),
        "compilation, cached": ("s", middle(cached, "jit_s")),
        "process, first front, cold": ("s", middle(cold, "process_s")),
        "process, first front, cached": ("s", middle(cached, "process_s")),
        **searches,
        "memory after loading": ("MB", middle(memory, "loaded_mb")),
        "peak memory, 60 points with profiles": ("MB", middle(memory, "peak_mb")),
        "rows of these profiles": ("rows", middle(memory, "profile_rows")),
    }
    report.rows = [{"what": what, "value": float(value), "unit": unit} for what, (unit, value) in values.items()]
    report.figures = {what: float(value) for what, (_, value) in values.items()}
    report.plot = _plot(report.figures)
    return report


def _searches(repeats: int) -> dict[str, tuple[str, float]]:
    """Wall and processor times of the command line."""
    found: dict[str, tuple[str, float]] = {}
    with tempfile.TemporaryDirectory() as folder:
        search = ["search", "--quiet", "--out", str(Path(folder) / "out")]
        for place in ("all cores", "one core"):
            for state, times in (("cold", 1), ("warm", repeats)):
                runs = [_command(search, Path(folder) / place, place == "all cores") for _ in range(times)]
                wall_s, processor_s = map(statistics.median, zip(*runs, strict=True))
                found[f"tgvdp search, {state}, {place}"] = ("s", wall_s)
                found[f"tgvdp search, {state}, {place}, processor time"] = ("s", processor_s)
        found["tgvdp warm, all cores"] = ("s", _command(["warm"], Path(folder) / "warm", True)[0])
    return found


def _command(arguments: list[str], cache: Path, all_cores: bool) -> tuple[float, float]:
    """Wall time of a command in a fresh process, s, and the processor time of all its processes, s."""
    before_s = _processor_s()
    wall_s, _ = run_fresh(["-m", "tgvdp", *arguments], {"TGVDP_CACHE_DIR": str(cache)}, all_cores)
    return wall_s, _processor_s() - before_s


def _busy() -> str:
    """How busy the machine was before, where it tells."""
    return f", and {os.getloadavg()[0]:.1f} processes were running before" if hasattr(os, "getloadavg") else ""


def _processor_s() -> float:
    """Processor time of all processes that were started here and have ended, s."""
    times = os.times()
    return times.children_user + times.children_system


def _process_s(code: str, repeats: int) -> float:
    return statistics.median(run_fresh(["-c", code])[0] for _ in range(repeats))


def _plot(figures: dict[str, float]) -> Any:
    figure = style.new_figure(3.4)
    left, right = figure.subplots(1, 2)
    names = ("loading numpy, numba and tgvdp.search", "compilation, cached", "compilation, cold")
    left.barh(["loading", "cached", "cold"], [figures[name] for name in names], 0.6, color=palette.BLUE)
    style.dress(left, "s")
    style.title(left, "The first front", "on top of the front itself")
    names = ("memory after loading", "peak memory, 60 points with profiles")
    right.barh(["loaded", "peak"], [figures[name] for name in names], 0.6, color=palette.GREEN)
    right.axvline(300.0, color=palette.VERMILION, linewidth=1.0)
    style.dress(right, "MB")
    style.title(right, "Memory", "red: the bar")
    return figure
