"""``python -m fuzz [WHAT] [--seconds N] [--seed N] [--processes N]``: slips, mutations; exit code 1 where one fails."""

import argparse
import itertools
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from random import Random

from fuzz.cases import Case, loads, mutations, others, slips
from fuzz.forks import Outcome, run, warmed


def main(arguments: list[str] | None = None) -> int:
    """Try what is asked for, and print how it ended."""
    parser = argparse.ArgumentParser(prog="python -m fuzz", description="Slips of unit and mutated files, searched.")
    parser.add_argument("what", nargs="*", choices=[*_WHAT, []], help=f"{', '.join(_WHAT)} (default all)")
    parser.add_argument("--seconds", type=float, default=600.0, help="time for each of these (default 600)")
    parser.add_argument("--cases", type=int, help="cases of each of these at most")
    parser.add_argument("--seed", type=int, default=0, help="of the order of slips, and of mutations")
    parser.add_argument("--processes", type=int, default=1, help="children at a time (default 1)")
    parser.add_argument("--failures", type=Path, help="folder that the failing files are written into")
    options = parser.parse_args(arguments)
    warmed()
    return min(sum(_tried(what, _WHAT[what](options.seed), options) for what in options.what or _WHAT), 1)


def _slips(seed: int) -> Iterable[Case]:
    cases = list(slips())
    Random(seed).shuffle(cases)
    return cases


#: What can be tried, by its name.
_WHAT: dict[str, Callable[[int], Iterable[Case]]] = {
    "slips": _slips, "mutations": mutations, "loads": loads, "others": others,
}  # fmt: skip


def _tried(what: str, cases: Iterable[Case], options: argparse.Namespace) -> int:
    """Run cases while there is time; print each that fails, and how all of them ended."""
    codes: Counter[int] = Counter()
    failures: list[Outcome] = []
    slowest_s, most_b = 0.0, 0
    for outcome in run(_within(itertools.islice(cases, options.cases), options.seconds), options.processes):
        codes[outcome.code] += 1
        slowest_s, most_b = max(slowest_s, outcome.cpu_s), max(most_b, outcome.memory_b)
        if outcome.fault:
            failures.append(outcome)
            _show(outcome, len(failures), options.failures)
    ended = ", ".join(f"{count:,} with {code}" for code, count in sorted(codes.items(), reverse=True))
    most = f"at most {slowest_s:.1f} s and {most_b / 1e6:.0f} MB"
    print(f"{what}: {sum(codes.values()):,} cases, {len(failures)} failed; ended {ended}; {most}")
    for fault, count in Counter(outcome.fault for outcome in failures).most_common():
        print(f"  {count} {fault}")
    return len(failures)


def _within(cases: Iterable[Case], seconds: float) -> Iterator[Case]:
    end_s = time.monotonic() + seconds
    return itertools.takewhile(lambda _: time.monotonic() < end_s, cases)


def _show(outcome: Outcome, number: int, folder: Path | None) -> None:
    last = outcome.text.strip().splitlines()[-1:] or [""]
    spent = f"{outcome.cpu_s:.1f} s, {outcome.memory_b / 1e6:.0f} MB"
    print(f"{outcome.fault}: {outcome.case.name} ({spent}): {last[0]:.300}", flush=True)
    if folder is not None:
        place = folder / f"{number:03d}"
        place.mkdir(parents=True, exist_ok=True)
        (place / outcome.case.file).write_bytes(outcome.case.content)
        (place / "search.txt").write_text("\n".join(map(" ".join, outcome.case.commands)) + "\n" + outcome.text)


if __name__ == "__main__":
    sys.exit(main())
