"""What a circuit of QAOA asks of a gate machine: ``python -m benchmarks.quantum_resources`` writes resources.csv.

Gates and depth after compilation for two snapshots of machines, the success of a shot without and with their noise, and
the number of T gates where gates were error-corrected. A rotation by any angle takes 3·log2(1/ε) T gates and a constant
at an error of ε (Ross and Selinger, Quantum Information and Computation 16, 901, 2016); ε here is the whole error that
is allowed over the number of rotations.
"""

import math
import sys
from pathlib import Path
from typing import Any

from benchmarks.timing import ROOT
from tgvdp.formulations.circuit.qaoa import checked_angles, qaoa_circuit
from tgvdp.formulations.problem.instances import BinaryInstance
from tgvdp.formulations.problem.reading import read_instance
from tgvdp.formulations.qubo.encodings import encode
from tgvdp.formulations.qubo.ising import ising_of
from tgvdp.instances import find
from tgvdp.report.files import write_files
from tgvdp.report.plain import csv_text
from tgvdp.solvers.allowance import Allowance
from tgvdp.solvers.circuit.qiskit import fake_backend, native_circuit
from tgvdp.solvers.registry import solve
from tgvdp.trials.statistics import proportion_interval

SIZES = range(4, 10)
LAYERS = (1, 3)
#: Eagle and Heron processors of IBM.
BACKENDS = ("fake_sherbrooke", "fake_torino")
#: The penalty that tuning chose for circuits of `easy`.
PENALTY = 0.1
SHOTS = 300
#: Most qubits whose noise is simulated within minutes: of 20 a circuit takes an hour, and one shot in 22,000 succeeds.
NOISY_QUBITS = 16
#: Error that all rotations together may make.
WHOLE_ERROR = 1e-3


def resource_rows() -> list[dict[str, Any]]:
    """One row per size, number of layers and machine."""
    return [_row(steps, layers, backend) for steps in SIZES for layers in LAYERS for backend in BACKENDS]


def _row(steps: int, layers: int, backend: str) -> dict[str, Any]:
    instance = read_instance(find(f"easy-n{steps:03d}"))
    assert isinstance(instance, BinaryInstance)
    settings = {"layers": layers, "angles": "ramp", "reads": SHOTS}
    ideal = solve(instance, "qaoa", "unary", PENALTY, Allowance(**settings)).details
    angles = checked_angles(ideal["gamma"], ideal["beta"])
    circuit = qaoa_circuit(ising_of(encode(instance, "unary", PENALTY).qubo, -1), angles)
    rotations = sum(gate.name != "h" for gate in circuit.gates)
    machine = fake_backend(backend)
    native = native_circuit(circuit, machine, 1)
    noisy, low, high = None, None, None
    if circuit.n <= NOISY_QUBITS:
        found = solve(instance, "qaoa", "unary", PENALTY, Allowance(**settings, backend=backend)).details
        noisy = found["success_probability"]
        low, high = proportion_interval(round(noisy * SHOTS), SHOTS)
    row = {
        "Problem": instance.id, "N": steps, "qubits": circuit.n, "layers": layers, "machine": backend,
        "rotations": rotations, "T gates": rotations * math.ceil(3.0 * math.log2(rotations / WHOLE_ERROR)),
        "two-qubit gates": int(native.num_nonlocal_gates()), "depth": int(native.depth()),
        "no error": _errorless(native, machine),
        "random": ideal["random_probability"], "success without noise": ideal["success_probability"],
        "success with noise": noisy, "low": low, "high": high,
    }  # fmt: skip
    print(row, flush=True)
    return row


def _errorless(native: Any, machine: Any) -> float:
    """Chance that no gate and no measurement errs, by the calibration of the machine."""
    chance = 1.0
    for step in native.data:
        places = machine.target.get(step.operation.name, {})  # a barrier has none
        found = places.get(tuple(native.find_bit(qubit).index for qubit in step.qubits))
        chance *= 1.0 - ((found and found.error) or 0.0)
    return chance


def main(folder: Path) -> None:
    """Write the table."""
    write_files(folder, {"resources.csv": csv_text(resource_rows())})


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "results" / "quantum")
