"""What is kept of a benchmark: one JSON file per instance and solver, replaced as a whole after each run.

A file's name holds a digest of everything that decides what a run does: the instance's bytes, the solver's word, the
base seed, the edition of the program and of the files. What changes is therefore run again, and what does not is found
again.
"""

import hashlib
import json
import re
from pathlib import Path
from typing import Any

from tgvdp import __version__
from tgvdp.errors import InputError
from tgvdp.report.files import write_files

SCHEMA = "tgvdp.bench-runs/2"
#: Folder of the files within that of the results.
RUNS = "runs"
_DIGEST_LENGTH = 12


class Store:
    """Finished runs in a folder.

    Parameters
    ----------
    folder : Path
        That of the results.
    seed : int
        Base seed of the benchmark.
    """

    def __init__(self, folder: Path, seed: int) -> None:
        self._folder = folder / RUNS
        self._seed = seed

    def runs(self, instance_id: str, sha256: str, work: str) -> dict[int, dict[str, Any]]:
        """Finished runs of some work (a solver's word) on an instance, by number.

        Raises
        ------
        InputError
            When a file is damaged.
        """
        path = self._folder / self._name(instance_id, sha256, work)
        try:
            content = json.loads(path.read_bytes())
            return {int(number): record for number, record in content["runs"].items()}
        except FileNotFoundError:
            return {}
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise InputError(f"{path}: is damaged ({error}): delete it, and its runs are made again") from None

    def keep(self, instance_id: str, sha256: str, work: str, number: int, record: dict[str, Any]) -> None:
        """Add a finished run to what is on disk."""
        runs = self.runs(instance_id, sha256, work) | {number: record}
        content = {
            "schema": SCHEMA,
            "instance": instance_id,
            "sha256": sha256,
            "work": work,
            "seed": self._seed,
            "tgvdp": __version__,
            "runs": {str(one): runs[one] for one in sorted(runs)},
        }
        text = json.dumps(content, indent=1, ensure_ascii=False)
        write_files(self._folder, {self._name(instance_id, sha256, work): text.encode()})

    def _name(self, instance_id: str, sha256: str, work: str) -> str:
        key = hashlib.sha256("\0".join((SCHEMA, sha256, work, str(self._seed), __version__)).encode()).hexdigest()
        words = re.sub(r"[^A-Za-z0-9._-]+", "-", f"{instance_id}--{work}")[:80]
        return f"{words}--{key[:_DIGEST_LENGTH]}.json"
