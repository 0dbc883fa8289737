"""Files of a benchmark: tables for programs and for people, pictures, provenance."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tgvdp.report import make_provenance
from tgvdp.report.files import write_files
from tgvdp.report.pictures import encode
from tgvdp.report.plain import csv_text, markdown_table, plain
from tgvdp.trials.demand_points import DemandComparison, demand_comparison
from tgvdp.trials.ensembles import ensembles, scaling
from tgvdp.trials.execute import Plan, Results
from tgvdp.trials.landscape import landscapes
from tgvdp.trials.pivot import growth_table, tables
from tgvdp.trials.rows import Row, embedding_rows, rows_of, run_rows
from tgvdp.trials.trip_points import Comparison, comparison
from tgvdp.units import JOULE_PER_KWH

SCHEMA = "tgvdp.bench/2"


def write_benchmark(results: Results, folder: Path, elapsed_s: float) -> dict[str, Any]:
    """Write all files of a benchmark, each whole or not at all.

    Returns
    -------
    dict
        Object of schema tgvdp.bench/2: ``files``, ``provenance``, and what stands in the tables, ``rows`` and
        ``embeddings``, which benchmark.json leaves to them.
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
    together, growth = ensembles(rows), scaling(rows)
    figures = pictures(results, rows, together, embeddings) | _comparisons(compared, driven)
    files = {"benchmark.csv": csv_text(rows), "runs.csv": csv_text(run_rows(results))}
    for name, found in (("ensembles", together), ("scaling", growth)):
        if found:
            files[f"{name}.csv"] = csv_text(found)
    if embeddings:
        files["embeddings.csv"] = csv_text(embeddings)
    if compared is not None:
        files["pareto.csv"] = csv_text(compared.rows())
    if driven is not None:
        files["pareto_demand.csv"] = csv_text(driven.rows())
    files |= {f"{name}.png": encode(figure, brief(provenance)) for name, figure in figures.items()}
    files["benchmark.md"] = page(plan, together, growth, embeddings, list(figures), provenance).encode()
    content = plain({"schema": SCHEMA, "files": [*files, "benchmark.json"], "provenance": provenance})
    files["benchmark.json"] = json.dumps(content, indent=1, ensure_ascii=False).encode() + b"\n"
    write_files(folder, files)
    whole: dict[str, Any] = content | plain({"rows": rows, "embeddings": embeddings})
    return whole


def brief(provenance: Mapping[str, Any]) -> dict[str, Any]:
    """Provenance for the metadata of a picture, which the inputs of a thousand instances would outweigh."""
    return {**provenance, "inputs": "benchmark.json"}


_READING = """\
An attempt is a read of a sampler, a shot of a circuit, or a whole run of a solver that makes none. It succeeds when its
decoded schedule is feasible and reaches the certified optimum. A cell holds, as medians over the instances of a family
and size: the success of an attempt; the sweeps (layers of a circuit) until one attempt has succeeded with probability
99 %, with its 95 % interval by a bootstrap over instances; and the time of that by the solver alone, for qaoa on the
simulator. Where the median instance was never solved, the cell says how many were. Settings, ranges and all rows are
in the CSV files."""

_GROWTH = """\
Slopes of the median TTS99 over the sizes that have one, with 95 % intervals by the bootstrap: decades per step if it
grows exponentially, the power of N if it grows as a power. Sizes whose median instance was never solved are left out,
which flatters those who fail."""


def page(
    plan: Plan,
    together: Sequence[Row],
    growth: Sequence[Row],
    embeddings: Sequence[Row],
    figures: Sequence[str],
    provenance: Mapping[str, Any],
) -> str:
    """The page for people: tables of solvers by sizes, what grows how fast, pictures."""
    parts = [
        "# Benchmark of formulations and solvers",
        f"{len(plan.cases)} instances, {plan.runs} runs of each solver where it has no number of its own, seeds "
        f"{plan.seed}, {plan.seed + 1}, …",
        _READING,
        *tables(together),
    ]
    if growth:
        parts += ["## Growth with N", _GROWTH, growth_table(growth).rstrip()]
    parts += [f"![{name}]({name}.png)" for name in figures]
    if embeddings:
        parts += ["## Embeddings", markdown_table(embeddings).rstrip()]
    machine = provenance["machine"]
    parts.append(
        f"Made by `tgvdp bench` {provenance['tgvdp']} with Python {provenance['python']}, numpy {provenance['numpy']}, "
        f"numba {provenance['numba']} on {machine['processor']}, {provenance['utc']}."
    )
    return "\n\n".join(parts) + "\n"


def success_picture(together: Sequence[Row]) -> Any:
    """Picture (matplotlib figure) of success and time to solution of ensembles; None where nothing ever succeeds."""
    from tgvdp.report.trial_plots import plot_success
    from tgvdp.trials.panels import family_panels

    panels = family_panels(together)
    if not panels:
        return None
    return plot_success(panels, "medians over the instances of a family and size; bars: 95 % intervals")


def pictures(
    results: Results, rows: Sequence[Row], together: Sequence[Row], embeddings: Sequence[Row]
) -> dict[str, Any]:
    """All pictures (matplotlib figures) for which there is something to show, by name."""
    from tgvdp.report.trial_plots import Depths, plot_landscape, plot_sizes
    from tgvdp.trials.panels import size_panels

    success = success_picture(together)
    found: dict[str, Any] = {} if success is None else {"success": success}
    sizes = size_panels(rows, embeddings)
    if sizes:
        found["sizes"] = plot_sizes(
            sizes, "QUBOs and their embeddings; medians over the instances of a family and size"
        )
    deep = landscapes([case.instance for case in results.plan.cases], results.plan.encodings)
    if deep:
        found["landscape"] = plot_landscape(
            [
                Depths(
                    one.title,
                    f"λ = {one.penalty:.3g} (m/s)²; {one.optima} optima, {one.strict_minima} strict and "
                    f"{one.weak_minima} weak minima",
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
