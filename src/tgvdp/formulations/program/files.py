"""LP and MPS files of a linear program, as text; both in the model's own unit, with 17 digits."""

from collections.abc import Iterable, Iterator
from math import isinf

from tgvdp.errors import InputError
from tgvdp.formulations.program.binary import Program, Row, Terms

#: Terms on a line: old readers of LP stop at 255 or 510 characters.
_TERMS_PER_LINE = 5


def lp_text(program: Program) -> str:
    """Write the CPLEX LP format: rows with two different bounds become two rows.

    Raises
    ------
    InputError
        When the program has products.
    """
    _require_linear(program)
    names = [variable.name for variable in program.variables]
    lines = [f"\\ {program.name}", "Minimize"]
    lines += _sum("obj", {i: cost * program.unit for i, cost in program.linear.items()}, names)
    lines.append("Subject To")
    for row in program.rows:
        for name, sense, side in _sides(row):
            body = _sum(name, row.linear, names)
            lines += [*body[:-1], f"{body[-1]} {sense} {side!r}"]
    lines.append("Bounds")
    lines += [f" {one.lower!r} <= {one.name} <= {one.upper!r}" for one in program.variables]
    lines.append("Generals")
    lines += [f" {variable.name}" for variable in program.variables if variable.integer]
    return "\n".join([*lines, "End", ""])


def mps_text(program: Program) -> str:
    """Write the free MPS format.

    Raises
    ------
    InputError
        When the program has products.
    """
    _require_linear(program)
    lines = [f"NAME {'_'.join(program.name.split())}", "ROWS", " N obj"]
    lines += [f" {_kind(row)} {row.name}" for row in program.rows]
    lines += ["COLUMNS", *_columns(program), "RHS"]
    lines += [f" rhs {row.name} {_side(row)!r}" for row in program.rows if _side(row)]
    ranges = [row for row in program.rows if _kind(row) == "G" and not isinf(row.upper)]
    if ranges:
        lines += ["RANGES", *(f" rng {row.name} {row.upper - row.lower!r}" for row in ranges)]
    lines.append("BOUNDS")
    for one in program.variables:
        lines += [f" LO bnd {one.name} {one.lower!r}", f" UP bnd {one.name} {one.upper!r}"]
    return "\n".join([*lines, "ENDATA", ""])


def _require_linear(program: Program) -> None:
    if program.products or any(row.products for row in program.rows):
        raise InputError(f"{program.name}: only linear programs can be written")


def _sum(name: str, terms: Terms, names: list[str]) -> list[str]:
    """``name: +a x +b y``, a few terms on each line; a sum of nothing is 0 times the first variable."""
    words = [f"{weight:+.17g} {names[i]}" for i, weight in terms.items()] or [f"0 {names[0]}"]
    chunks = [" ".join(words[i : i + _TERMS_PER_LINE]) for i in range(0, len(words), _TERMS_PER_LINE)]
    return [f" {name}: {chunks[0]}", *(f"   {chunk}" for chunk in chunks[1:])]


def _sides(row: Row) -> Iterator[tuple[str, str, float]]:
    if row.lower == row.upper:
        yield row.name, "=", row.lower
        return
    both = not isinf(row.lower) and not isinf(row.upper)
    if not isinf(row.lower):
        yield f"{row.name}_least" if both else row.name, ">=", row.lower
    if not isinf(row.upper):
        yield f"{row.name}_most" if both else row.name, "<=", row.upper


def _kind(row: Row) -> str:
    """E where both bounds agree, G where there is a lower one (an upper one besides becomes a range), else L."""
    if row.lower == row.upper:
        return "E"
    return "L" if isinf(row.lower) else "G"


def _side(row: Row) -> float:
    return row.upper if isinf(row.lower) else row.lower


def _columns(program: Program) -> Iterable[str]:
    entries: list[list[str]] = [[] for _ in program.variables]
    for i, cost in program.linear.items():
        entries[i].append(f"obj {cost * program.unit!r}")
    for row in program.rows:
        for i, weight in row.linear.items():
            entries[i].append(f"{row.name} {weight!r}")
    integer = False
    for variable, column in zip(program.variables, entries, strict=True):
        if variable.integer != integer:
            yield f" MARKER 'MARKER' '{'INTORG' if variable.integer else 'INTEND'}'"
            integer = variable.integer
        # A column without entries would be forgotten: give it a cost of nothing.
        yield from (f" {variable.name} {entry}" for entry in column or ["obj 0.0"])
    if integer:
        yield " MARKER 'MARKER' 'INTEND'"
