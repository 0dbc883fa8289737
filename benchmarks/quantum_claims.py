"""What the published runs show, as sentences whose figures come from the rows: ``python -m benchmarks quantum``.

docs/quantum-benchmark.md holds them between two marks, and a test compares it with the rows. A figure is a median with
its range, and says over what.
"""

import csv
import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from benchmarks.quantum_forms import (
    Row,
    alpha,
    effort,
    fineness,
    multiplier,
    printed_demand,
    printed_qubo,
    resources,
    span,
)
from benchmarks.quantum_limits import short, weights, weights_table
from benchmarks.quantum_shared import compared_table, large_table, substations
from tgvdp.report.plain import markdown_table, rounded

BEGIN, END = "<!-- claims: begin (python -m benchmarks quantum) -->", "<!-- claims: end -->"


def claims(folder: Path) -> str:
    """All statements, from the rows below a folder."""
    shared = [_read(folder / "substations" / name) for name in ("benchmark.csv", "large/benchmark.csv", "weights.csv")]
    statements = [
        *_exact(_read(folder / "exact" / "benchmark.csv")),
        *_greedy(_read(folder / "greedy.csv")),
        *_penalties(_read(folder / "penalties.csv")),
        *_front(_read(folder / "exact" / "pareto.csv"), _read(folder / "exact" / "pareto_demand.csv")),
        *printed_qubo(_read(folder / "printed" / "qubo.csv")),
        *printed_demand(_read(folder / "printed" / "demand.csv")),
        alpha(),
        multiplier(_read(folder / "multiplier.csv")),
        effort(_read(folder / "effort.csv")),
        weights(_read(folder / "weights.csv")),
        short(_read(folder / "short.csv"), _read(folder / "ensembles.csv")),
        *substations(*shared),
    ]
    tables = [
        _reach(_read(folder / "ensembles.csv")),
        weights_table(_read(folder / "weights.csv")),
        _growth(_read(folder / "scaling.csv")),
        _named(_read(folder / "named" / "benchmark.csv")),
        _embeddings(_read(folder / "embeddings" / "embeddings.csv")),
        fineness(_read(folder / "embeddings" / "embeddings.csv")),
        resources(_read(folder / "resources.csv")),
        compared_table(shared[0], shared[2]),
        large_table(shared[1]),
    ]
    return "\n".join(["".join(f"- {statement}\n" for statement in statements), *tables])


def _read(path: Path) -> list[Row]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def _exact(rows: Sequence[Row]) -> Iterator[str]:
    """Dynamic program, closed form and HiGHS on the whole library."""
    times = {(row["Problem"], row["solver"]): float(row["elapsed_s median"]) for row in rows if row["status"] == "ok"}
    proved = {(row["Problem"], row["solver"]) for row in rows if row["p_success"] == "1.0" and _is_proved(row)}
    binary = [row["Problem"] for row in rows if row["solver"] == "dp" and row["kind"] == "binary"]
    known = [name for name in binary if (name, "dp") in proved]
    closed = [name for name in binary if (name, "closed") in times]
    yield (
        f"**Dynamic program.** It proves {len(known)} of the {len(binary)} binary instances of the library, "
        f"N = {_sizes(rows, known)}, in {span((1e3 * times[name, 'dp'] for name in known), ' ms')}; where the closed "
        f"form knows the answer, too, that takes {span((1e3 * times[name, 'closed'] for name in closed), ' ms')}."
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
            f"{span((times[name, 'milp'] for name in ended), ' s')}, the dynamic program's time times {span(ratios)}."
        )


def _greedy(rows: Sequence[Row]) -> Iterator[str]:
    """What a plan without search reaches, and which instances defeat it."""

    def counted(own: Sequence[Row]) -> str:
        return " of ".join(str(sum(int(row[name]) for row in own)) for name in ("solved", "instances"))

    library = [row for row in rows if row["instances from"] == "library"]
    single = [row for row in library if row["family"] != "substation"]
    shared = [row for row in library if row["family"] == "substation"]
    drawn = [row for row in rows if row["instances from"] == "random"]
    families = (
        f"{family} {counted([row for row in drawn if row['family'] == family])}"
        for family in dict.fromkeys(row["family"] for row in drawn)
    )
    yield (
        f"**Greedy.** The plan without search (`greedy`) is an optimum of {counted(single)} single trains of the "
        f"library with equal steps. Of the random families it solves {', '.join(families)}: who solves these with a "
        "sampler shows that the sampler works, not that it is needed."
    )
    largest = max(int(row["N"]) for row in drawn)
    zones = [row for row in drawn if row["family"] == "zones"]
    (last,) = (row for row in zones if int(row["N"]) == largest)
    (substation,) = shared
    yield (
        f"**What defeats greedy.** Some slow zones between faster parts: at N = {largest} it solves {counted([last])} "
        f"of `zones`, and is up to {rounded(max(float(row['worst above %']) for row in zones))} % above the optimum at "
        "some size. Trains "
        f"at one substation: it solves {counted(shared)} certified instances, is up to "
        f"{rounded(float(substation['worst above %']))} % above the optimum on others and finds no plan for "
        f"{substation['no plan']}."
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
            f"most 20 bits, the sufficient weight is the critical one times {span(ratios)}. On `easy` the critical "
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
            yield f"**Above the front, {name}**, on the trip of {own[0]['Problem']}: {span(above, ' %')}."
    more = [100.0 * (float(row["driven_j"]) / float(row["optimal_j"]) - 1.0) for row in demand]
    off = [100.0 * abs(float(row["distance_off"])) for row in demand]
    yield (
        f"**Demand model**, on the trip of {demand[0]['Problem']}: driven by fine steps, its demands miss their "
        f"distance by {span(off, ' %')}, and take more energy than the best run of the distance that they do cover: "
        f"{span(more, ' %')}."
    )


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
    return _by_family(
        drawn,
        "largest size whose median instance the tuned settings of one weight solve, of those tried: success, range",
        cell,
    )


def _growth(rows: Sequence[Row]) -> str:
    """How fast the effort grows: in sweeps where a solver draws, else in seconds."""

    def cell(found: Sequence[Row]) -> str:
        (row,) = (row for row in found if (row["unit"] == "sweeps") == (row["draws"] == "True"))
        what = "decades per step" if row["draws"] == "True" else "power of N"
        value, low, high = (rounded(float(row[f"{what}{end}"])) for end in ("", " low", " high"))
        largest = f", to N = {row['sizes'].split()[-1]}" if row["sizes without"] else ""
        return f"{'' if row['draws'] == 'True' else 'N^'}{value} [{low}, {high}]{largest}"

    return _by_family(
        rows,
        "growth of TTS99: decades of sweeps per step; of dp and milp, the power of N of its time; without the sizes "
        "whose median instance is not solved, which flatters",
        cell,
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
