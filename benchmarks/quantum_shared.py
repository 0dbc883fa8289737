"""What the runs on trains at one substation show: sentences and tables for the page of the quantum benchmark."""

from collections.abc import Iterator, Sequence

from benchmarks.quantum_forms import Row, span
from benchmarks.substation_weights import DRAWN, READS
from tgvdp.instances import index
from tgvdp.report.plain import markdown_table, rounded

#: Solvers that can prove an optimum, and those that draw.
_EXACT, _DRAWN = {"dp": "dp", "milp": "HiGHS", "scip": "SCIP"}, ("sa", "pt", "tabu")
#: Settings with one weight for all violations, and with one for each kind.
_ARMS = ("one", "each")


def substations(rows: Sequence[Row], large: Sequence[Row], weights: Sequence[Row]) -> Iterator[str]:
    """Who proves, who finds, and what is left open; ``weights`` are the samplers with weights drawn at random."""
    names = list(dict.fromkeys(row["Problem"] for row in rows))
    ended = [row for row in rows if row["solver"] in _EXACT and _is_proved(row)]
    proved = (f"{label} {sum(row['solver'] == one for row in ended)}" for one, label in _EXACT.items())
    greedy = sum(_best(rows, name, "greedy") == 1.0 for name in names)
    drawn = ", ".join(f"`{one}` {sum(_best(rows, name, one) > 0.0 for name in names)}" for one in _DRAWN)
    settings = sum(row["solver"] == _DRAWN[0] for row in rows) // len(names)
    one, each = (", ".join(f"`{solver}` {_solved(weights, solver, arm)}" for solver in _DRAWN) for arm in _ARMS)
    never = [name for name in names if not any(int(row["successful"]) for row in weights if row["instance"] == name)]
    yield (
        f"**Trains at one substation, the {len(names)} smallest instances.** Of these {', '.join(proved)} prove within "
        f"60 s of clock, in processor time {span((float(row['cpu_s median']) for row in ended), ' s')}. The plan "
        f"without search is an optimum of {greedy}. Samplers reach an optimum in some of 50 attempts of 10000 sweeps, "
        f"with the best of {settings} settings of one weight for all violations, of: {drawn}. Of {DRAWN} settings "
        f"drawn from wider ranges and picked by other attempts on the same instance, the best reaches one in some of "
        f"{READS} with one weight of: {one}; with a weight each of logic, distance and power of: {each}. None of these "
        f"reaches one of {', '.join(never) or 'none'}, which says nothing of what others would."
    )
    left = [row for row in map(index().get, dict.fromkeys(row["Problem"] for row in large)) if row]
    unproved = [row for row in left if row["best_known"]]
    gaps = (100.0 * (float(row["best_known"]) / float(row["bound"]) - 1.0) for row in unproved)
    tried = []
    for solver in ("milp", "scip"):
        own = [row for row in large if row["solver"] == solver]
        tried.append(
            f"by {_EXACT[solver]} {sum(map(_is_proved, own))} of the {len(own)} that it was given "
            f"({span((float(row['cpu_s median']) for row in own), ' s')} of processor time)"
        )
    yield (
        f"**Trains at one substation, the {len(left)} largest instances.** In 600 s of clock on a shared machine "
        f"{' and '.join(tried)} are proved; the dynamic program proves {len(left) - len(unproved)} before its budget "
        f"of states ends. {len(unproved)} are open, where the best known plan is above the best bound by "
        f"{span(gaps, ' %')}."
    )


def compared_table(rows: Sequence[Row], weights: Sequence[Row]) -> str:
    """One line per instance: processor time of a proof, and what the others reach."""
    table = []
    for name in dict.fromkeys(row["Problem"] for row in rows):
        own = {row["solver"]: row for row in rows if row["Problem"] == name}
        table.append(
            {
                "instance": name,
                "bits, `unary`": own["sa"]["# Decision Variables"],
                **{f"{label} proves in": _seconds(own[solver]) for solver, label in _EXACT.items()},
                "`greedy`, above the optimum": _above(own["greedy"]),
                **{
                    f"`{one}`, success: best of grid; drawn, one weight; one each": "; ".join(
                        f"{rounded(100.0 * chance)} %"
                        for chance in (_best(rows, name, one), *(_chance(weights, name, one, arm) for arm in _ARMS))
                    )
                    for one in _DRAWN
                },
            }
        )
    return markdown_table(table)


def large_table(rows: Sequence[Row]) -> str:
    """One line per large instance: the best known plan and bound, and those of each solver."""
    table = []
    for name in dict.fromkeys(row["Problem"] for row in rows):
        known = index()[name]
        own = {row["solver"]: row for row in rows if row["Problem"] == name}
        cells = {
            f"{_EXACT[one]}, 600 s: plan, bound": (
                ", ".join(own[one][column] or "–" for column in ("Best Objective Value", "Optimality Bound"))
                if one in own
                else "not run"
            )
            for one in ("milp", "scip")
        }
        cells["`greedy`"] = own["greedy"]["Best Objective Value"] or "none"
        best, bound = (known[one] or f"{known['objective']} (dp)" for one in ("best_known", "bound"))
        table.append({"large instance": name, "best known": best, "bound": bound, **cells})
    return markdown_table(table)


def _is_proved(row: Row) -> bool:
    return bool(row["Optimality Bound"]) and row["Optimality Bound"] == row["Best Objective Value"]


def _seconds(row: Row) -> str:
    return f"{rounded(float(row['cpu_s median']))} s" if _is_proved(row) else "not proved"


def _above(row: Row) -> str:
    """Excess of a plan over the certified optimum."""
    if not row["Best Objective Value"]:
        return "no plan"
    return f"{rounded(100.0 * (float(row['Best Objective Value']) / float(row['certified optimum']) - 1.0))} %"


def _solved(weights: Sequence[Row], solver: str, arm: str) -> int:
    """Instances of which some attempt with weights of an arm is an optimum."""
    names = dict.fromkeys(row["instance"] for row in weights)
    return sum(_chance(weights, name, solver, arm) > 0.0 for name in names)


def _chance(weights: Sequence[Row], name: str, solver: str, arm: str) -> float:
    """Success of an attempt with the setting that was picked."""
    (row,) = (row for row in weights if (row["instance"], row["solver"], row["weights"]) == (name, solver, arm))
    return int(row["successful"]) / int(row["attempts"])


def _best(rows: Sequence[Row], name: str, solver: str) -> float:
    """Success of an attempt with the best of the settings."""
    return max(float(row["p_success"] or 0.0) for row in rows if (row["Problem"], row["solver"]) == (name, solver))
