"""What the published runs show, as sentences whose figures come from the rows: ``python -m benchmarks quantum``.

docs/quantum-benchmark.md holds them between two marks, and a test compares it with the rows. A figure is a median with
its range, and says over what.
"""

import csv
import math
import statistics
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np

from tgvdp.formulations.problem.alstom import TOP_KMH, braking_n, energy_faults, power_w
from tgvdp.report.plain import markdown_table, rounded
from tgvdp.units import KILO, KMH_PER_MPS

Row = dict[str, str]

#: Of the demand instances of the library.
_P_MAX_W, _ALPHA = 9.8e6, 0.3

BEGIN, END = "<!-- claims: begin (python -m benchmarks quantum) -->", "<!-- claims: end -->"


def claims(folder: Path) -> str:
    """All statements, from the rows below a folder."""
    statements = [
        *_exact(_read(folder / "exact" / "benchmark.csv")),
        *_penalties(_read(folder / "penalties.csv")),
        *_front(_read(folder / "exact" / "pareto.csv"), _read(folder / "exact" / "pareto_demand.csv")),
        *_printed_qubo(_read(folder / "printed" / "qubo.csv")),
        *_printed_demand(_read(folder / "printed" / "demand.csv")),
        _alpha(),
    ]
    tables = [
        _reach(_read(folder / "ensembles.csv")),
        _growth(_read(folder / "scaling.csv")),
        _named(_read(folder / "named" / "benchmark.csv")),
        _embeddings(_read(folder / "embeddings" / "embeddings.csv")),
    ]
    return "\n".join(["".join(f"- {statement}\n" for statement in statements), *tables])


def _read(path: Path) -> list[Row]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def _span(values: Iterable[float], unit: str = "") -> str:
    """Median and range."""
    found = sorted(values)
    middle, least, most = map(rounded, (statistics.median(found), found[0], found[-1]))
    return f"{middle}{unit} (median of {len(found)}; {least} to {most})"


def _exact(rows: Sequence[Row]) -> Iterator[str]:
    """Dynamic program, closed form and HiGHS on the whole library."""
    times = {(row["Problem"], row["solver"]): float(row["elapsed_s median"]) for row in rows if row["status"] == "ok"}
    proved = {(row["Problem"], row["solver"]) for row in rows if row["p_success"] == "1.0" and _is_proved(row)}
    binary = [row["Problem"] for row in rows if row["solver"] == "dp" and row["kind"] == "binary"]
    known = [name for name in binary if (name, "dp") in proved]
    closed = [name for name in binary if (name, "closed") in times]
    yield (
        f"**Dynamic program.** It proves {len(known)} of the {len(binary)} binary instances of the library, "
        f"N = {_sizes(rows, known)}, in {_span((1e3 * times[name, 'dp'] for name in known), ' ms')}; where the closed "
        f"form knows the answer, too, that takes {_span((1e3 * times[name, 'closed'] for name in closed), ' ms')}."
    )
    objectives = {row["Problem"]: row["Problem"].rpartition("-")[0] for row in rows}
    squares = {"kinetic", "efficiency", "unequal"}
    for what, chosen in (
        ("the constant objective", [name for name in binary if objectives[name] not in squares]),
        ("an objective with squares of speeds", [name for name in binary if objectives[name] in squares]),
    ):
        ended = [name for name in chosen if (name, "milp") in proved]
        ratios = (times[name, "milp"] / times[name, "dp"] for name in ended)
        yield (
            f"**HiGHS, {what}.** Within 10 s it proves {len(ended)} of {len(chosen)} instances, in "
            f"{_span((times[name, 'milp'] for name in ended), ' s')}, the dynamic program's time times {_span(ratios)}."
        )


def _is_proved(row: Row) -> bool:
    return bool(row["Optimality Bound"]) and float(row["Optimality Bound"]) == float(row["Best Objective Value"])


def _sizes(rows: Sequence[Row], names: Sequence[str]) -> str:
    sizes = [int(row["N"]) for row in rows if row["Problem"] in names]
    return f"{min(sizes)}..{max(sizes)}"


def _penalties(rows: Sequence[Row]) -> Iterator[str]:
    """Weights of the instances that can be enumerated."""
    for encoding in ("bits", "unary"):
        own = [row for row in rows if row["encoding"] == encoding]
        ratios = (float(row["sufficient"]) / float(row["critical"]) for row in own if float(row["critical"]))
        easy = ", ".join(
            f"{rounded(float(row['critical']))} at N = {row['N']}" for row in own if row["Problem"].startswith("easy")
        )
        yield (
            f"**Penalties, {encoding}.** Over the {len(own)} instances of the library that this encoding writes in at "
            f"most 20 bits, the sufficient weight is the critical one times {_span(ratios)}. On `easy` the critical "
            f"weight is {easy}: below it the minimum of the QUBO breaks a constraint. The least string is an optimum "
            f"with the sufficient weight but on {_wrong(own, 'sufficient')}, with `tenfold` but on "
            f"{_wrong(own, 'tenfold')}."
        )


def _wrong(rows: Sequence[Row], rule: str) -> str:
    return ", ".join(row["Problem"] for row in rows if row[f"{rule} finds"] == "False") or "none"


def _front(binary: Sequence[Row], demand: Sequence[Row]) -> Iterator[str]:
    """How far the formulations are from the true front."""
    for name in dict.fromkeys(row["formulation"] for row in binary):
        own = [row for row in binary if row["formulation"] == name and row["least_j_per_kg"]]
        above = [100.0 * (float(row["energy_j_per_kg"]) / float(row["least_j_per_kg"]) - 1.0) for row in own]
        if max(above) > 0.0:
            yield f"**Above the front, {name}**, on the trip of {own[0]['Problem']}: {_span(above, ' %')}."
    more = [100.0 * (float(row["driven_j"]) / float(row["optimal_j"]) - 1.0) for row in demand]
    off = [100.0 * abs(float(row["distance_off"])) for row in demand]
    yield (
        f"**Demand model**, on the trip of {demand[0]['Problem']}: driven by fine steps, its demands miss their "
        f"distance by {_span(off, ' %')}, and take more energy than the best run of the distance that they do cover: "
        f"{_span(more, ' %')}."
    )


def _printed_qubo(rows: Sequence[Row]) -> Iterator[str]:
    """Whether the strings of least energy of each form are optima."""
    parts = []
    for word in dict.fromkeys(row["encoding"] for row in rows):
        counts = []
        for rule in ("sufficient", "tenfold"):
            own = [row for row in rows if (row["encoding"], row["penalty"]) == (word, rule) and row["ground states"]]
            good = sum(row["optimal"] == row["ground states"] for row in own)
            counts.append(f"{good} of {len(own)} with `{rule}`")
        if own:
            parts.append(f"`{word}` on {', '.join(counts)}")
    yield f"**QUBOs as printed.** All strings of least energy are optima of the problem for {'; '.join(parts)}."
    cubic = [row for row in rows if "cubic" in row["encoding"]]
    least = min(cubic, key=lambda row: int(row["N"]))
    yield f"**The cubic objective** takes {least['bits']} bits at N = {least['N']}, too many to list their strings."


def _printed_demand(rows: Sequence[Row]) -> Iterator[str]:
    """What the approximations of the demand model are worth on the true curves."""
    for solver, form in dict.fromkeys((row["solver"], row["form"]) for row in rows):
        own = [row for row in rows if (row["solver"], row["form"]) == (solver, form)]
        found = [row for row in own if row["distance missed m"]]
        kept = [row for row in found if row["feasible by replay"] == "True"]
        none = sum(row["plan"] == "none" for row in own)
        missed = (abs(float(row["distance missed m"])) for row in found)
        dearer = (float(row["dearer %"]) for row in found)
        cost = "; ".join(f"{row['Problem']} {rounded(float(row['dearer %']))} % dearer" for row in kept)
        yield (
            f"**Demand model, `{solver}:form={form}`.** Of {len(own)} approximations {none} have no plan and "
            f"{len(own) - none - len(found)} gave none in time; of {len(found)} plans {len(kept)} keep all constraints "
            f"on the true curves{f' ({cost})' if cost else ''}. They miss the distance by {_span(missed, ' m')}, and "
            f"cost more than the certified optimum: {_span(dearer, ' %')}."
        )


def _alpha() -> str:
    """What α of the demand instances gives back, against what the brakes do."""
    speed_mps = np.linspace(20.0, TOP_KMH, 201) / KMH_PER_MPS
    shares = []
    for demand in (-1.0, -0.5):
        returned_w = -power_w(speed_mps, demand, _P_MAX_W, TOP_KMH / KMH_PER_MPS, _ALPHA)
        shares.append(_range(100.0 * returned_w / (-demand * braking_n(speed_mps) * speed_mps)))
    faults = energy_faults(_P_MAX_W, TOP_KMH / KMH_PER_MPS, _ALPHA)
    fades, excess = rounded(100.0 * faults.braking_part), rounded(faults.braking_worst_w / KILO)
    return (
        f"**α = {_ALPHA:g} of the demand instances.** The formulation leaves α open. It multiplies the cost map, not "
        f"the work of the brake: from 20 m/s on it gives back {shares[0]} % of that work at full demand and "
        f"{shares[1]} % at half. Where the brake fades, on {fades} % of the speeds up to {TOP_KMH:g} km/h, it gives "
        f"back more than the brake takes, by {excess} kW at most."
    )


def _range(values: Iterable[float]) -> str:
    found = sorted(values)
    return f"{rounded(found[0])} to {rounded(found[-1])}"


def _by_family(rows: Sequence[Row], head: str, cell: Callable[[Sequence[Row]], str]) -> str:
    """Table of solvers by families."""
    families = dict.fromkeys(row["family"] for row in rows)
    table = []
    for solver in dict.fromkeys(row["solver"] for row in rows):
        own = {name: [row for row in rows if (row["solver"], row["family"]) == (solver, name)] for name in families}
        table.append({head: f"`{solver}`", **{name: cell(found) if found else "–" for name, found in own.items()}})
    return markdown_table(table)


def _reach(rows: Sequence[Row]) -> str:
    """How far each solver that draws comes on the random families."""

    def cell(tried: Sequence[Row]) -> str:
        solved = [row for row in tried if math.isfinite(float(row["TTS99 sweeps"]))]
        if not solved:
            return "none"
        last = max(solved, key=lambda row: int(row["N"]))
        middle, least, most = (rounded(100.0 * float(last[f"p {which}"])) for which in ("median", "least", "most"))
        return f"N = {last['N']} of {max(int(row['N']) for row in tried)}: {middle} % ({least} to {most})"

    drawn = [row for row in rows if row["draws"] == "True"]
    return _by_family(drawn, "largest size whose median instance is solved, of those tried: success, range", cell)


def _growth(rows: Sequence[Row]) -> str:
    """How fast the effort grows: in sweeps where a solver draws, else in seconds."""

    def cell(found: Sequence[Row]) -> str:
        (row,) = (row for row in found if (row["unit"] == "sweeps") == (row["draws"] == "True"))
        what = "decades per step" if row["draws"] == "True" else "power of N"
        value, low, high = (rounded(float(row[f"{what}{end}"])) for end in ("", " low", " high"))
        return f"{'' if row['draws'] == 'True' else 'N^'}{value} [{low}, {high}]"

    return _by_family(
        rows, "growth of TTS99: decades of sweeps per step; of dp and milp, the power of N of its time", cell
    )


def _named(rows: Sequence[Row]) -> str:
    """Success on published instances by the settings tuned for their family."""
    table = [
        {
            "instance": row["Problem"], "solver": f"`{row['Workflow']}`",
            "success of an attempt": f"{rounded(100 * float(row['p_success']))} %",
            "95 % interval": f"{rounded(100 * float(row['p low']))} to {rounded(100 * float(row['p high']))}"
            if row["p from"] == "attempts" else "exact",
            "TTS99, sweeps": rounded(float(row["TTS99 sweeps"])),
        }
        for row in rows
        if row["p_success"]
    ]  # fmt: skip
    return markdown_table(table)


def _embeddings(rows: Sequence[Row]) -> str:
    """Qubits and longest chains."""
    table = []
    for encoding, topology in dict.fromkeys((row["encoding"], row["topology"]) for row in rows):
        own = [row for row in rows if (row["encoding"], row["topology"]) == (encoding, topology)]
        cells = {f"N = {row['N']}": f"{row['qubits'] or '–'} / {row['longest chain'] or '–'}" for row in own}
        table.append({"qubits / longest chain, `easy`": f"{encoding}, {topology}", **cells})
    return markdown_table(table)
