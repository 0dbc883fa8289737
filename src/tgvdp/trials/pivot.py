"""What people read of a benchmark: one table per family, solvers by sizes."""

from collections.abc import Sequence

from tgvdp.report.plain import markdown_table, rounded
from tgvdp.trials.rows import Row


def tables(ensembles: Sequence[Row]) -> list[str]:
    """Headings and tables of all families."""
    parts = []
    for family in dict.fromkeys(row["family"] for row in ensembles):
        own = [row for row in ensembles if row["family"] == family]
        parts += [f"## {family}", pivot(own).rstrip()]
    return parts


def pivot(ensembles: Sequence[Row]) -> str:
    """Success, TTS99 in sweeps with its interval, and in seconds, of one family."""
    sizes = sorted({row["N"] for row in ensembles})
    lines = []
    for solver in dict.fromkeys(row["solver"] for row in ensembles):
        cells = {row["N"]: _cell(row) for row in ensembles if row["solver"] == solver}
        lines.append({"N": f"`{solver}`", **{str(steps): cells.get(steps, "–") for steps in sizes}})
    return markdown_table(lines)


def _cell(row: Row) -> str:
    chance = f"{rounded(100.0 * row['p median'])} %"
    if row["TTS99 sweeps"] == float("inf"):
        return f"{chance}<br>solved {row['solved']} of {row['instances']}"
    sweeps, low, high = (rounded(row[f"TTS99 sweeps{end}"]) for end in ("", " low", " high"))
    spread = f" [{low}, {high}]" if row["instances"] > 1 else ""
    effort = f"<br>{sweeps}{spread}" if row["draws"] else ""
    return f"{chance}{effort}<br>{rounded(row['TTS99 s'])} s"


def growth_table(growth: Sequence[Row]) -> str:
    """Growth in sweeps of solvers that draw, else in seconds."""
    lines = []
    for row in growth:
        if (row["unit"] == "sweeps") != row["draws"]:
            continue
        slopes = {
            what: f"{rounded(row[what])} [{rounded(row[f'{what} low'])}, {rounded(row[f'{what} high'])}]"
            for what in ("decades per step", "power of N")
        }
        known = {"family": row["family"], "solver": f"`{row['solver']}`", "TTS99 in": row["unit"]}
        lines.append({**known, "sizes": row["sizes"], "sizes without": row["sizes without"] or "none", **slopes})
    return markdown_table(lines)
