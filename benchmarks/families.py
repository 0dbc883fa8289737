"""Random families: ``python -m benchmarks.families FOLDER`` writes their instances, byte for byte the same every time.

30 instances per family and size for the benchmark and 4 for tuning, which are no part of it. What is committed is this
generator and ``results/quantum/families.csv``, the index of their certified optima: ``--certify`` proves them anew.
"""

import argparse
import csv
import math
import warnings
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.entry import Draw, Entry, farthest
from benchmarks.library import certified
from benchmarks.timing import ROOT
from tgvdp.formulations.problem.binary import FormulationWarning
from tgvdp.instances import INDEX
from tgvdp.report.files import write_files
from tgvdp.report.plain import csv_text

FAMILIES = ("easy", "kinetic", "efficiency", "zones")
SIZES = (6, 7, 8, 9, 10, 12, 16, 20, 30, 40)
#: Kind of instance → how many there are of each family and size; the kind's first letter stands in their names.
COUNTS = {"sample": 30, "tuning": 4}
OPTIMA = ROOT / "results" / "quantum" / "families.csv"
#: Steps up to which enumeration, and HiGHS where speeds are squared, confirm an optimum soon.
BRUTE_STEPS, SQUARES_STEPS = 9, 12


class Member(NamedTuple):
    """Where an instance of a family stands."""

    family: str
    steps: int
    kind: str
    number: int

    @property
    def name(self) -> str:
        """Its id, and the seed of what is drawn."""
        return f"{self.family}-n{self.steps:03d}-{self.kind[0]}{self.number:02d}"

    @property
    def entry(self) -> Entry:
        """The instance: 30 to 90 % of the farthest distance within random caps."""
        draw, steps = Draw(self.name), self.steps
        cap = draw.whole(max(1, steps // 3), steps // 2)
        caps = _slowed(draw, steps, cap) if self.family == "zones" else [cap] * steps
        far = farthest(steps, caps)
        params: dict[str, Any] = {
            "kind": "binary", "model": "constant", "N": steps, "dt_s": 10.0, "dv_mps": 1.0, "acc_units": 1,
            "dec_units": 1, "cap_units": caps if self.family == "zones" else cap,
            "D_units": draw.whole(math.ceil(0.3 * far), int(0.9 * far)), "alpha": draw.whole(0, 90) / 100,
        }  # fmt: skip
        if self.family == "kinetic":
            params["model"] = "kinetic"
        if self.family == "efficiency":
            slope = round(draw.whole(40, 90) / 100 / (steps // 2), 4)
            params |= {"model": "efficiency", "alpha": 0.0, "eta0": 0.9, "deta": slope}
        return Entry(self.family, self.name, params)


def _slowed(draw: Draw, steps: int, cap: int) -> list[int]:
    """Caps with one to three slow zones, each at most a quarter of the trip."""
    caps = [cap] * steps
    for _ in range(draw.whole(1, 3)):
        start, length, slow = draw.whole(1, steps - 1), draw.whole(1, steps // 4), draw.whole(1, max(1, cap - 1))
        caps[start : start + length] = [min(slow, one) for one in caps[start : start + length]]
    return caps


def members(family: str, steps: int, kind: str) -> list[Member]:
    """All of one family, size and kind."""
    return [Member(family, steps, kind, number) for number in range(COUNTS[kind])]


def everything() -> list[Member]:
    """All members, by family and size."""
    groups = ((family, steps, kind) for family in FAMILIES for steps in SIZES for kind in COUNTS)
    return [member for group in groups for member in members(*group)]


def certify(wanted: list[Member]) -> list[dict[str, Any]]:
    """Rows of the index: certified by the dynamic program, confirmed by others where they end soon."""
    rows = []
    for member in wanted:
        others = ["closed"] if member.family in ("easy", "kinetic") else []
        others += ["brute"] if member.steps <= BRUTE_STEPS else []
        others += ["milp"] if member.family in ("easy", "zones") or member.steps <= SQUARES_STEPS else []
        rows.append(certified(member.entry, others))
        print(*(rows[-1][key] for key in ("id", "objective", "n_optimal", "confirmed_by")), flush=True)
    return rows


def write(folder: Path) -> None:
    """Write all instances and their index into a folder.

    Raises
    ------
    ValueError
        When an instance is not the one whose optimum is known.
    """
    with OPTIMA.open(encoding="utf-8", newline="") as file:
        known = {row["id"]: row for row in csv.DictReader(file)}
    entries = [member.entry for member in everything()]
    for entry in entries:
        if known[entry.name]["sha256"] != entry.sha256:
            raise ValueError(f"{entry.name} is not the instance of {OPTIMA}")
    write_files(folder, {**{f"{one.name}.json": one.content for one in entries}, INDEX: csv_text(list(known.values()))})


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.families", description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?", help="where to write all instances")
    parser.add_argument("--certify", action="store_true", help=f"prove all optima anew, into {OPTIMA.name}")
    options = parser.parse_args()
    warnings.simplefilter("ignore", FormulationWarning)
    if options.certify:
        write_files(OPTIMA.parent, {OPTIMA.name: csv_text(certify(everything()))})
    if options.folder:
        write(options.folder)


if __name__ == "__main__":
    main()
