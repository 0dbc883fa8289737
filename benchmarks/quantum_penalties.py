"""Penalty weights of the small published instances: sufficient, by the rule of thumb, and exactly critical."""

import warnings
from typing import Any

from tgvdp.errors import InputError
from tgvdp.formulations.problem.binary import FormulationWarning
from tgvdp.formulations.problem.instances import BinaryInstance
from tgvdp.formulations.problem.reading import read_instance
from tgvdp.formulations.qubo.encoded import Encoded
from tgvdp.formulations.qubo.encodings import encode
from tgvdp.formulations.qubo.names import Encoding
from tgvdp.formulations.qubo.penalties import critical_penalty
from tgvdp.formulations.qubo.qubo import bits_of
from tgvdp.instances import find, index

#: Most bits of which all strings are listed.
MOST_BITS = 20


def penalty_rows() -> list[dict[str, Any]]:
    """One row per published instance and encoding of at most `MOST_BITS` bits."""
    rows = []
    for name, known in index().items():
        instance = read_instance(find(name))
        if not isinstance(instance, BinaryInstance) or instance.steps > MOST_BITS:
            continue
        for encoding in ("bits", "unary"):
            row = _row(instance, encoding, float(known["objective"]))
            rows += [row] if row is not None else []
    return rows


def _row(instance: BinaryInstance, encoding: Encoding, optimum: float) -> dict[str, Any] | None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormulationWarning)
        try:
            safe, thumb = encode(instance, encoding, "sufficient"), encode(instance, encoding, "tenfold")
        except InputError:
            return None  # an encoding that needs equal steps
    if safe.qubo.n > MOST_BITS:
        return None
    return {
        "Problem": instance.id,
        "N": instance.steps,
        "encoding": encoding,
        "bits": safe.qubo.n,
        "critical": critical_penalty(safe.objective, safe.violation),
        "sufficient": safe.penalty,
        "sufficient finds": _finds(safe, optimum),
        "tenfold": thumb.penalty,
        "tenfold finds": _finds(thumb, optimum),
    }


def _finds(encoded: Encoded, optimum: float) -> bool:
    """Whether the string of least energy is an optimum."""
    least = int(encoded.qubo.all_energies().argmin())
    schedule = encoded.decode(bits_of(least, encoded.qubo.n))
    return bool(schedule.feasible and abs(schedule.objective - optimum) <= 1e-12 * max(1.0, abs(optimum)))
