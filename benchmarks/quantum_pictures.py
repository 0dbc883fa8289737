"""The pictures of success as the code draws them now: ``python -m benchmarks.quantum_pictures``.

Of the ensembles that stand beside them; runs take hours, and a better drawing needs none. The provenance stays that of
the runs.
"""

import csv
import json
import sys
from pathlib import Path
from typing import Any

from benchmarks.timing import ROOT
from tgvdp.report.files import write_files
from tgvdp.report.pictures import encode
from tgvdp.trials.output import brief, success_picture

#: Columns of ensembles.csv that pictures take numbers from; the others are texts or are not shown.
_WHOLE = ("N", "solved")
_REAL = ("p median", "TTS99 s", "TTS99 s low", "TTS99 s high")


def main(folder: Path) -> None:
    """Draw every picture of success below a folder anew."""
    for path in sorted(folder.rglob("ensembles.csv")):
        if (path.parent / "success.png").exists():
            write_files(path.parent, {"success.png": redrawn(path)})
            print(path.parent, flush=True)


def redrawn(ensembles: Path) -> bytes:
    """The picture of an ensembles.csv that stands beside its benchmark.json."""
    with ensembles.open(encoding="utf-8", newline="") as file:
        rows = [_numbers(row) for row in csv.DictReader(file)]
    content = json.loads((ensembles.parent / "benchmark.json").read_text(encoding="utf-8"))
    return encode(success_picture(rows), brief(content["provenance"]))


def _numbers(row: dict[str, str]) -> dict[str, Any]:
    return row | {name: int(row[name]) for name in _WHOLE} | {name: float(row[name]) for name in _REAL}


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "results" / "quantum")
