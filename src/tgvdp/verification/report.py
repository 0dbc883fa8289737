"""All parts of the verification, and what people and programs read of them."""

import itertools
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from tgvdp.report.plain import markdown_table, plain
from tgvdp.report.provenance import make_provenance
from tgvdp.verification import agreement, closed_forms, convergence, exhaustive, references, survey
from tgvdp.verification.case import Case

SCHEMA = "tgvdp.selftest/1"
_NUMBER = "{:.9g}"

PAGE = """\
# Verification

What `tgvdp` computes, held against what does not share its code: formulas, the order in which errors fall,
enumeration, other methods, the conservation of energy, optima by others, and its own referee and certificate on random
trips. It can be done anew on any machine, in half a minute once everything is compiled:

    tgvdp selftest
    tgvdp selftest --json > verification.json
    tgvdp selftest --references FOLDER --out verification.md    # this page; FOLDER holds reference/ and ttobench/

*Digits* is the log relative error, −log₁₀ |found − expected| / |expected|: in how many digits two numbers agree
(McCullough, The American Statistician 52, 1998), 15 where they are equal. Where nothing but zero is right, the error
is a share of the energies, the time or the number of points that it belongs to. *Least* is how many digits must agree.
The parts stand in `tgvdp.verification`, each with its formulas.

The [survey](../results/proof.md) of trains of all kinds, with a polish that looks for better runs, is larger than the
one below; [speed and accuracy](speed.md) compares with other tools.
"""


def verify(references_in: Path | None = None, progress: Callable[[str], None] = lambda _: None) -> list[Case]:
    """Run all parts.

    Parameters
    ----------
    references_in : Path, optional
        Folder of optima by others, see `tgvdp.verification.references`.
    progress : callable, optional
        Told what is being verified.
    """
    parts: list[Iterable[Case]] = [module.cases() for module in (closed_forms, convergence, exhaustive, agreement)]
    parts += [survey.cases()] + ([] if references_in is None else [references.cases(references_in)])
    return list(_told(itertools.chain.from_iterable(parts), progress))


def _told(cases: Iterable[Case], progress: Callable[[str], None]) -> Iterator[Case]:
    for case in cases:
        progress(f"verified: {case.part}: {case.name}")
        yield case


def content_of(cases: Sequence[Case], started_s: float, inputs: Mapping[str, Any]) -> dict[str, Any]:
    """The object that ``--json`` prints.

    Parameters
    ----------
    cases : sequence of Case
    started_s : float
        By `time.perf_counter`.
    inputs : mapping
        Files that were read, for the provenance.
    """
    return {
        "schema": SCHEMA,
        "ok": all(case.ok for case in cases),
        "cases": [plain(case._asdict() | {"digits": case.digits, "ok": case.ok}) for case in cases],
        "provenance": make_provenance({}, inputs, time.perf_counter() - started_s),
    }


def text_of(cases: Sequence[Case]) -> str:
    """A line for each case under the name of its part, and how many fail."""
    lines = []
    for part, members in by_part(cases).items():
        lines += [f"{part}"]
        lines += [f"  {case.digits:4.1f} {'ok  ' if case.ok else 'FAIL'} {case.name}" for case in members]
    failed = [case for case in cases if not case.ok]
    lines += [f"  failed: {case.name}: {case.found:.9g}, expected {case.expected:.9g}" for case in failed]
    lines += [f"{len(cases) - len(failed)} of {len(cases)} cases agree in as many digits as they must"]
    return "\n".join(lines)


def page_of(cases: Sequence[Case], content: Mapping[str, Any]) -> str:
    """The page docs/verification.md."""
    about = content["provenance"]
    machine = (
        f"Python {about['python']}, numpy {about['numpy']}, numba {about['numba']}, {about['machine']['processor']}"
    )
    parts = [PAGE]
    for part, members in by_part(cases).items():
        parts.append(f"## {part[0].upper()}{part[1:]}\n\n{markdown_table([_row(case) for case in members])}")
    failed = sum(not case.ok for case in cases)
    parts.append(f"{len(cases)} cases, {failed} failed. tgvdp {about['tgvdp']}, {machine}, {about['utc'][:10]}.\n")
    return "\n".join(parts)


def _row(case: Case) -> dict[str, str]:
    numbers = {"found": _NUMBER.format(case.found), "expected": _NUMBER.format(case.expected)}
    digits = {"digits": f"{case.digits:.1f}", "least": f"{case.least_digits:g}", "": "ok" if case.ok else "**fails**"}
    return {"case": case.name, **numbers, **digits}


def by_part(cases: Sequence[Case]) -> dict[str, list[Case]]:
    """Cases by their part, parts in the order of their first cases."""
    parts: dict[str, list[Case]] = {}
    for case in cases:
        parts.setdefault(case.part, []).append(case)
    return parts
