"""Where a result comes from: version, options, hashes of the inputs, machine, elapsed and calendar time."""

import datetime
import hashlib
import json
import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from tgvdp import __version__
from tgvdp.cores import usable_cores
from tgvdp.errors import InputError
from tgvdp.model.energy import EnergyMap
from tgvdp.model.track import Track
from tgvdp.model.train import Train
from tgvdp.report.files import write_files
from tgvdp.report.plain import plain, to_json

#: What was read: a file, values, or the fingerprint that was taken when a file was read.
Input = str | os.PathLike[str] | Mapping[str, Any] | Train | Track | EnergyMap


def make_provenance(
    options: Mapping[str, Any],
    inputs: Mapping[str, Input],
    elapsed_s: float,
) -> dict[str, Any]:
    """Describe how a result was made, as values that JSON can hold.

    Parameters
    ----------
    options : mapping
        Every option of the run, defaults included.
    inputs : mapping of str to path, fingerprint, Train, Track or EnergyMap
        What was read, by role (``"train"``, ``"track"``). A file is hashed byte by byte and named without its folder; a
        fingerprint (``file``, ``part`` where one was chosen, ``sha256``, ``notes`` where its reader had any) stands as
        it is; a train or track that was built in memory is hashed by its values.
    elapsed_s : float
        Duration of the search, s.

    Raises
    ------
    InputError
        When an input file cannot be read.
    """
    return {
        "tgvdp": __version__,
        "python": platform.python_version(),
        "numpy": _version_of("numpy"),
        "numba": _version_of("numba"),
        "options": plain(options),
        "inputs": {role: _fingerprint(source) for role, source in inputs.items()},
        "machine": {"platform": platform.platform(), "processor": _processor(), "cores": usable_cores()},
        "elapsed_s": plain(elapsed_s),
        "utc": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
    }


def _version_of(package: str) -> str:
    """Version from the installed metadata: asking the package itself would import it."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def _fingerprint(source: Input) -> dict[str, Any]:
    if isinstance(source, Train | Track | EnergyMap):
        content = json.dumps(asdict(source), sort_keys=True).encode()
        return {"name": source.name, "sha256": hashlib.sha256(content).hexdigest()}
    if isinstance(source, Mapping):
        return dict(source)
    path = Path(source)
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    return {"file": path.name, "sha256": hashlib.sha256(content).hexdigest()}


def _processor() -> str:
    """Name of the processor; Linux tells it only in /proc."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def write_ledger(
    out_dir: str | os.PathLike[str],
    files: Mapping[str, bytes],
    provenance: Mapping[str, Any],
    beneath: Sequence[Path] = (),
) -> list[Path]:
    """Write files, and ``provenance.json`` with the provenance and the SHA-256 of each of them.

    It lists files that were written into folders beneath, too.
    """
    listed = {**files, **{file.relative_to(out_dir).as_posix(): file.read_bytes() for file in beneath}}
    ledger = {
        "schema": "tgvdp.provenance/1",
        **plain(provenance),
        "files": {name: hashlib.sha256(data).hexdigest() for name, data in listed.items()},
    }
    return write_files(out_dir, {**files, "provenance.json": to_json(ledger)})
