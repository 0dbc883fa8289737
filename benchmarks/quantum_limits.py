"""Statements on what the tuning of the published runs leaves out: weights of their own, and shorter attempts."""

import math
import statistics
from collections.abc import Sequence

from benchmarks.quantum_forms import Row, span
from benchmarks.quantum_weights import LEFT_OUT
from tgvdp.report.plain import markdown_table, rounded

_SAMPLERS = ("sa", "pt", "tabu")
#: How words end that have the least effort of tuning.
_LEAST = (":sweeps=100", ":layers=3")
#: Sizes from which a growth is told.
_LEAST_SIZES = 4


def weights(rows: Sequence[Row]) -> str:
    """What settings drawn from wider ranges reach, with one weight for all violations and with one for each kind."""
    bits = [row for row in rows if row["solver"].split(":")[0] in _SAMPLERS and ":bits" in row["solver"]]
    solved = {
        arm: sum(float(row["p median"]) > 0.0 for row in bits if row["weights"] == arm) for arm in ("each", "one")
    }
    sizes, families = (", ".join(dict.fromkeys(row[name] for row in bits)) for name in ("N", "family"))
    pairs = {(row["solver"], row["family"], row["weights"]): row for row in rows if ":bits" not in row["solver"]}
    unary = "; ".join(
        f"`{solver}` on {family} {_percent(row)} (one weight: {_percent(pairs[solver, family, 'one'])})"
        for (solver, family, arm), row in pairs.items()
        if arm == "each" and solver.split(":")[0] in _SAMPLERS
    )
    circuits = {(row["family"], row["weights"]): row for row in rows if row["solver"].startswith("qaoa:bits")}
    gains = [
        float(row["TTS99 sweeps"]) / float(circuits[family, "each"]["TTS99 sweeps"])
        for (family, arm), row in circuits.items()
        if arm == "one"
    ]
    return (
        "**A weight for each kind of violation.** Tuning gives all violations one weight, of bits 0.2 at least, and "
        "fewer sweeps where these succeed sooner. Of 20 settings drawn from wider ranges, with attempts of 3000 "
        "sweeps and picked on the instances of tuning, the best solves the median instance of "
        f"{solved['each']} of {len(bits) // 2} sets of bits (three samplers, {families}, N = {sizes}) with a weight "
        f"for each kind, of {solved['one']} with one for all; `{LEFT_OUT}` was not tried. Of unary where "
        f"the tuned settings fail at N = 30 it solves the median instance in a share of the attempts of: {unary}. On "
        f"circuits of bits of N = 8 the layers to a success fall by a factor of {span(gains)}. So the next "
        "table shows what that tuning reaches, not what a solver or an encoding can; the table below it is of "
        "these settings."
    )


def _percent(row: Row) -> str:
    return f"{rounded(100.0 * float(row['p median']))} %"


def weights_table(rows: Sequence[Row]) -> str:
    """The largest size whose median instance is solved, with a weight for each kind and with one for all."""
    families = dict.fromkeys(row["family"] for row in rows)
    table = []
    for solver in dict.fromkeys(row["solver"] for row in rows):
        cells = {}
        for family in families:
            own = [row for row in rows if (row["solver"], row["family"]) == (solver, family)]
            each, one = ([row for row in own if row["weights"] == arm] for arm in ("each", "one"))
            cells[family] = f"{_largest(each)}; {_largest(one)}" if own else "–"
        table.append(
            {"a weight for each kind; one for all: largest median solved, success, TTS99 sweeps": f"`{solver}`"} | cells
        )
    return markdown_table(table)


def _largest(rows: Sequence[Row]) -> str:
    solved = [row for row in rows if float(row["p median"]) > 0.0]
    if not solved:
        return "none"
    last = max(solved, key=lambda row: int(row["N"]))
    return f"N = {last['N']}, {_percent(last)}, {rounded(float(last['TTS99 sweeps']))}"


def short(rows: Sequence[Row], reached: Sequence[Row]) -> str:
    """How shorter attempts than those of tuning change the effort and its growth; ``reached`` are the ensembles."""
    moved = [row for row in rows if not row["setting"].endswith(_LEAST)]
    gains = [float(row["TTS99 sweeps of tuning"]) / float(row["TTS99 sweeps"]) for row in moved]
    shorter = {(row["solver"], row["family"], row["N"]): float(row["TTS99 sweeps"]) for row in moved}
    grown = []
    for solver, family in dict.fromkeys((row["solver"], row["family"]) for row in moved):
        own = [row for row in reached if (row["solver"], row["family"]) == (solver, family)]
        old = {row["N"]: float(row["TTS99 sweeps"]) for row in own}
        slopes = [_slope(old), _slope({one: shorter.get((solver, family, one), effort) for one, effort in old.items()})]
        if None not in slopes:
            grown.append(f"`{solver}` on {family} {rounded(slopes[0] or 0.0)} → {rounded(slopes[1] or 0.0)}")
    less = sum(gain > 1.0 for gain in gains)
    return (
        f"**Shorter attempts.** Tuning tries attempts of 100 sweeps or 3 layers at least, and these had won on "
        f"{len(rows)} sets of one solver on unary, family and size. Of attempts down to 8 sweeps or 1 layer, chosen on "
        f"the instances of tuning, shorter ones win on {len(moved)} of these sets; there "
        f"{less} need less than published, and the effort falls by a factor of {span(gains)}. They save most where N "
        "is small, so that effort mostly grows faster than the table below says, in decades per step: "
        f"{', '.join(grown)}. Of bits, whose attempts were not made shorter, growth is that of the tuning, too."
    )


def _slope(efforts: dict[str, float]) -> float | None:
    """Decades per step by least squares over the sizes that are solved."""
    points = [(float(steps), math.log10(effort)) for steps, effort in efforts.items() if math.isfinite(effort)]
    if len(points) < _LEAST_SIZES:
        return None
    return statistics.linear_regression(*zip(*points, strict=True)).slope
