"""Statements on forms and machines, from the rows: printed forms, the multiplier, fineness and gates."""

import statistics
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from tgvdp.formulations.problem.alstom import TOP_KMH, braking_n, energy_faults, power_w
from tgvdp.report.plain import markdown_table, rounded
from tgvdp.units import KILO, KMH_PER_MPS

Row = dict[str, str]

#: Of the demand instances of the library.
_P_MAX_W, _ALPHA = 9.8e6, 0.3


def span(values: Iterable[float], unit: str = "") -> str:
    """Median and range."""
    found = sorted(values)
    middle, least, most = map(rounded, (statistics.median(found), found[0], found[-1]))
    return f"{middle}{unit} (median of {len(found)}; {least} to {most})"


def printed_qubo(rows: Sequence[Row]) -> Iterator[str]:
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


def printed_demand(rows: Sequence[Row]) -> Iterator[str]:
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
            f"on the true curves{f' ({cost})' if cost else ''}. They miss the distance by {span(missed, ' m')}, and "
            f"cost more than the certified optimum: {span(dearer, ' %')}."
        )


def alpha() -> str:
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


def multiplier(rows: Sequence[Row]) -> str:
    """What the outer loop over the multiplier solves, and what its repair does alone."""
    total, solved, raw = (sum(int(row[name]) for row in rows) for name in ("attempts", "successes", "without repair"))
    alone = sum(int(row["solved by the repair alone"]) for row in rows)
    instances = sum(int(row["instances"]) for row in rows)
    largest = max(int(row["N"]) for row in rows)
    at_end = [row for row in rows if int(row["N"]) == largest]
    kept = ", ".join(f"{row['family']} {row['without repair']} of {row['attempts']}" for row in at_end)
    return (
        f"**Unary with a multiplier, `multiplier`.** {solved} of {total} attempts end in an optimum, {raw} of them "
        f"without the repair; at N = {largest} without it {kept}. The repair alone, from a standing train, solves "
        f"{alone} of {instances} instances: what the loop finds is the repair's merit, and these families are easy for "
        "a greedy search, too."
    )


def effort(rows: Sequence[Row]) -> str:
    """What longer runs and larger penalties than the tuned ones reach."""
    pairs, parts = dict.fromkeys((row["solver"], row["family"]) for row in rows), []
    for solver, family in pairs:
        own = [row for row in rows if (row["solver"], row["family"]) == (solver, family)]
        best = max(own, key=lambda row: (int(row["solved"]), float(row["mean success"])))
        parts.append(
            f"`{solver}` on {family} {best['solved']} of {best['instances']} (`{best['setting']}`: "
            f"{rounded(100.0 * float(best['mean success']))} % of attempts)"
        )
    return (
        f"**Beyond the tuning.** Where the tuned settings do not solve the median instance of N = {rows[0]['N']}, the "
        f"best of {len(rows) // len(pairs)} settings with the most sweeps and larger penalties, one weight for "
        f"all violations, picked on these instances, solves: {'; '.join(parts)}. The sizes in the next table are ends "
        "of the tuning, not always of the solver."
    )


def fineness(rows: Sequence[Row]) -> str:
    """How fine a machine must be."""
    table = []
    for encoding in dict.fromkeys(row["encoding"] for row in rows):
        own = [row for row in rows if row["encoding"] == encoding and row["topology"] == rows[0]["topology"]]
        cells = {
            f"N = {row['N']}": f"{rounded(float(row['chain strength']))} / "
            f"{rounded(100.0 * float(row['finest coupling']))} %"
            for row in own
        }
        table.append(
            {"chain strength over the largest coupling / finest coupling over the full scale": encoding, **cells}
        )
    return markdown_table(table)


def resources(rows: Sequence[Row]) -> str:
    """What circuits ask of a gate machine."""

    def percent(row: Row, name: str) -> str:
        return f"{rounded(100.0 * float(row[name]))} %"

    table = []
    for size, layers in dict.fromkeys((row["N"], row["layers"]) for row in rows):
        own = [row for row in rows if (row["N"], row["layers"]) == (size, layers)]
        first = own[0]
        cells = {"N": size, "qubits": first["qubits"], "layers": layers, "T gates": first["T gates"],
                 "success without noise": percent(first, "success without noise"),
                 "coin tosses": percent(first, "random")}  # fmt: skip
        for row in own:
            parts = [percent(row, name) for name in ("success with noise", "low", "high") if row[name]]
            noisy = "{} [{}, {}]".format(*parts) if parts else "–"
            cells[f"{row['machine']}: two-qubit gates, depth, no error, success"] = (
                f"{row['two-qubit gates']}, {row['depth']}, {percent(row, 'no error')}, {noisy}"
            )
        table.append(cells)
    return markdown_table(table)
