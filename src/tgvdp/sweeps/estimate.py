"""What a sweep would be: how many scenarios, and by a few of them how long."""

from typing import Any

import numpy as np

from tgvdp.sweeps.cluster import Cluster
from tgvdp.sweeps.scenario import task_of
from tgvdp.sweeps.spec import SweepSpec
from tgvdp.sweeps.work import solve

SCHEMA = "tgvdp.sweep-estimate/1"
#: Scenarios that are solved for an estimate, evenly spread.
_SAMPLED = 8


def estimate(spec: SweepSpec, cluster: Cluster) -> dict[str, Any]:
    """Count the scenarios, and solve a few in this process.

    Returns
    -------
    dict
        ``schema``, ``scenarios``, ``trains``, ``lines``, ``sections``, ``axes`` (values by names), ``sampled``,
        ``failed``, ``error``, ``seconds_each``, ``workers``, ``elapsed_s``; the last of a cluster
        elsewhere as of one worker.
    """
    numbers = sorted(set(np.linspace(0, len(spec) - 1, _SAMPLED).round().astype(int).tolist()))
    records = [solve(task_of(spec[number], number)) for number in numbers]
    errors = [record.error for record in records if record.status == "failed"]
    solved_s = [record.elapsed_s for record in records if record.status != "failed"]
    each_s = float(np.mean(solved_s)) if solved_s else None
    workers = cluster.size or 1
    return {
        "schema": SCHEMA,
        "scenarios": len(spec),
        "trains": len(spec.trains),
        "lines": len(spec.lines),
        "sections": sum(map(len, spec.sections)),
        "axes": {" and ".join(axis.names): len(axis.rows) for axis in spec.axes},
        "sampled": len(records),
        "failed": len(errors),
        "error": errors[0] if errors else None,
        "seconds_each": each_s,
        "workers": workers,
        "elapsed_s": None if each_s is None else len(spec) * each_s / workers,
    }
