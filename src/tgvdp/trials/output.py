"""Files of a benchmark: tables for programs and for people, pictures, provenance."""

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tgvdp.report import make_provenance
from tgvdp.report.files import write_files
from tgvdp.report.pictures import encode
from tgvdp.report.plain import csv_text, markdown_table, plain
from tgvdp.trials.demand_points import DemandComparison, demand_comparison
from tgvdp.trials.execute import Results
from tgvdp.trials.landscape import landscapes
from tgvdp.trials.rows import Row, embedding_rows, rows_of, run_rows
from tgvdp.trials.trip_points import Comparison, comparison
from tgvdp.units import JOULE_PER_KWH

if TYPE_CHECKING:
    from tgvdp.report.trial_plots import Series

SCHEMA = "tgvdp.bench/1"


def write_benchmark(results: Results, folder: Path, elapsed_s: float) -> dict[str, Any]:
    """Write all files of a benchmark, each whole or not at all.

    Returns
    -------
    dict
        Object of schema tgvdp.bench/1: ``rows``, ``embeddings``, ``files``, ``provenance``.
    """
    plan = results.plan
    options = {
        "solvers": [spec.label for spec in plan.specs], "runs": plan.runs, "seed": plan.seed,
        "own_runs": {spec.label: spec.runs for spec in plan.specs if spec.runs}, "embed": plan.topologies,
    }  # fmt: skip
    inputs = {case.instance.id: case.path for case in plan.cases}
    provenance = make_provenance(options, inputs, elapsed_s)
    machine = provenance["machine"]
    rows = rows_of(results, f"{machine['processor']}, one of {machine['cores']} cores")
    embeddings = embedding_rows(results)
    instances = [case.instance for case in plan.cases]
    compared, driven = comparison(instances), demand_comparison(instances)
    figures = pictures(results, rows, embeddings) | _comparisons(compared, driven)
    files = {"benchmark.csv": csv_text(rows), "runs.csv": csv_text(run_rows(results))}
    if embeddings:
        files["embeddings.csv"] = csv_text(embeddings)
    if compared is not None:
        files["pareto.csv"] = csv_text(compared.rows())
    if driven is not None:
        files["pareto_demand.csv"] = csv_text(driven.rows())
    files |= {f"{name}.png": encode(figure, provenance) for name, figure in figures.items()}
    files["benchmark.md"] = page(results, rows, embeddings, list(figures), provenance).encode()
    content = {"schema": SCHEMA, "rows": rows, "embeddings": embeddings, "provenance": provenance}
    names = [*files, "benchmark.json"]
    whole: dict[str, Any] = plain(content | {"files": names})
    files["benchmark.json"] = json.dumps(whole, indent=1, ensure_ascii=False).encode() + b"\n"
    write_files(folder, files)
    return whole


#: Columns of the table for people, and what they are called there.
_SHOWN = {
    "Problem": "instance", "N": "N", "Workflow": "solver", "# Decision Variables": "variables", "status": "status",
    "Best Objective Value": "best", "certified optimum": "optimum", "attempts": "attempts",
    "feasible attempts": "feasible", "successful attempts": "successful", "p_success": "p",
    "p low": "p ≥", "p high": "p ≤", "random p_success": "random p", "elapsed_s median": "median s",
    "TTS99 s": "TTS99 s", "TTS99 low s": "TTS99 ≥ s",
}  # fmt: skip


_READING = """\
An attempt is a read of a sampler, a shot of a circuit, or a whole run of a solver that makes none. It succeeds when its
decoded schedule is feasible and reaches the certified optimum. p is the probability of that, its interval by Clopper
and Pearson at 95 % over all attempts (for qaoa: exact, of the state, and the range over runs). TTS99 counts the solver
alone, sampling and, for qaoa, the search for its angles on the simulator; it leaves out encoding, decoding and replay,
which all samplers share (`cpu_s` holds everything). `TTS99 ≥` is the lower end of its interval, all that is known where
nothing succeeded. Random p is degeneracy / 2ⁿ. Durations are medians."""


def page(
    results: Results,
    rows: Sequence[Row],
    embeddings: Sequence[Row],
    figures: Sequence[str],
    provenance: Mapping[str, Any],
) -> str:
    """The page for people."""
    plan = results.plan
    words = [f"`{spec.label}`" + (f" ({spec.runs} runs)" if spec.runs else "") for spec in plan.specs]
    parts = [
        "# Benchmark of formulations and solvers",
        f"{len(plan.cases)} instances, {plan.runs} runs of each solver where no other number stands, seeds "
        f"{plan.seed}, {plan.seed + 1}, …: {', '.join(words)}.",
        _READING,
        *(f"![{name}]({name}.png)" for name in figures),
        markdown_table([{_SHOWN[name]: row[name] for name in _SHOWN} for row in rows]).rstrip(),
    ]
    if embeddings:
        parts += ["## Embeddings", markdown_table(embeddings).rstrip()]
    machine = provenance["machine"]
    parts.append(
        f"Made by `tgvdp bench` {provenance['tgvdp']} with Python {provenance['python']}, numpy {provenance['numpy']}, "
        f"numba {provenance['numba']} on {machine['processor']}, {provenance['utc']}."
    )
    return "\n\n".join(parts) + "\n"


def pictures(results: Results, rows: Sequence[Row], embeddings: Sequence[Row]) -> dict[str, Any]:
    """All pictures (matplotlib figures) for which there is something to show, by name."""
    from tgvdp.report.trial_plots import Depths, plot_landscape, plot_sizes, plot_success

    found: dict[str, Any] = {}
    success, tts = _success(rows)
    if tts:
        found["success"] = plot_success(
            success, tts, "medians over instances of the same N; bars: 95 % intervals; hollow: bound, nothing succeeded"
        )
    variables, couplers = _sizes(rows, embeddings)
    if variables and couplers:
        found["sizes"] = plot_sizes(variables, couplers, "bits of the QUBOs, and qubits of their embeddings")
    deep = landscapes([case.instance for case in results.plan.cases], results.plan.encodings)
    if deep:
        found["landscape"] = plot_landscape(
            [
                Depths(
                    one.title, f"{one.bits} bits, {one.optima} optima, {one.local_minima} local minima",
                    one.quantiles, one.feasible_distance, one.feasible_energy,
                )
                for one in deep
            ]
        )  # fmt: skip
    return found


def _comparisons(compared: Comparison | None, driven: DemandComparison | None) -> dict[str, Any]:
    from tgvdp.report.trial_plots import Series, plot_comparison

    found: dict[str, Any] = {}
    if compared is not None:
        front, *others = (
            Series(one.name, one.time_s, one.energy_j_per_kg)
            for one in (compared.front, compared.closed, *compared.points)
        )
        detail = f"trip of {compared.instance.id}, no resistance, without regeneration; N from its shortest time on"
        found["pareto"] = plot_comparison(front, others, "J/kg", detail)
    if driven is not None:
        claimed, fine, best = (
            Series(name, driven.time_s, energy_j / JOULE_PER_KWH)
            for name, energy_j in (
                ("demand model, its own steps (exact)", driven.claimed_j),
                ("the same demands, fine steps", driven.driven_j),
                ("least for what they drive (search)", driven.optimal_j),
            )
        )
        worst = 100.0 * float(abs(driven.distance_off).max())
        detail = f"{driven.instance.id} in more and fewer steps; fine steps miss its distance by up to {worst:.1f} %"
        found["pareto_demand"] = plot_comparison(best, [claimed, fine], "kWh", detail)
    return found


def _success(rows: Sequence[Row]) -> "tuple[list[Series], list[Series]]":
    from tgvdp.report.trial_plots import median_series

    binary = [row for row in rows if row["kind"] == "binary"]
    names = _short(list(dict.fromkeys(row["Workflow"] for row in binary)))
    success, tts = [], []
    for workflow, label in names.items():
        own = [row for row in binary if row["Workflow"] == workflow]
        if any(row["p from"] not in ("no draw", None) for row in own):
            success.append(median_series(label, own, "N", "p_success", "p low", "p high"))
        if own[0]["solver"] == "random":  # a bound from a few tosses says nothing
            own = [row for row in own if row["p_success"]]
        tts.append(median_series(label, own, "N", "TTS99 s", "TTS99 low s", "TTS99 high s"))
    for encoding in dict.fromkeys(row["encoding"] for row in binary if row["encoding"]):
        own = [row for row in binary if row["encoding"] == encoding]
        success.append(median_series(f"coin tosses, {encoding} (exact)", own, "N", "random p_success", dashed=True))
    return [one for one in success if one is not None], [one for one in tts if one is not None]


def _short(labels: Sequence[str]) -> dict[str, str]:
    """Names for pictures: without the keys that say how long a solver runs, where all stay different."""
    short = [re.sub(r":(reads|starts|time-limit)=[^:]*", "", label) for label in labels]
    return {label: one if short.count(one) == 1 else label for label, one in zip(labels, short, strict=True)}


def _sizes(rows: Sequence[Row], embeddings: Sequence[Row]) -> "tuple[list[Series], list[Series]]":
    from tgvdp.report.trial_plots import median_series

    variables, couplers = [], []
    for encoding in dict.fromkeys(row["encoding"] for row in rows if row["encoding"]):
        own = [
            row | {"couplers": row["# Non-Zero Coefficients"] - row["# Decision Variables"]}
            for row in rows
            if row["encoding"] == encoding and row["# Non-Zero Coefficients"] is not None
        ]
        variables.append(median_series(f"variables, {encoding}", own, "N", "# Decision Variables"))
        couplers.append(median_series(f"variables, {encoding}", own, "N", "couplers"))
        for topology in dict.fromkeys(row["topology"] for row in embeddings):
            laid = [row for row in embeddings if row["encoding"] == encoding and row["topology"] == topology]
            variables.append(median_series(f"qubits on {topology}, {encoding}", laid, "N", "qubits"))
    return [one for one in variables if one is not None], [one for one in couplers if one is not None]
