"""QAOA circuits in qiskit, and their runs on simulated noisy machines and on real ones."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from tgvdp.errors import InputError, UnavailableError
from tgvdp.formulations.circuit.qaoa import Circuit
from tgvdp.solvers.extras import extra
from tgvdp.solvers.samplers.sampling import Samples

_PURPOSE = "solver qaoa on a machine"

#: Prefix of the names of simulated machines.
FAKE = "fake_"


def qiskit_circuit(circuit: Circuit, *, measure: bool = True) -> Any:
    """Copy a circuit into a ``qiskit.QuantumCircuit``."""
    qiskit = extra("qiskit", _PURPOSE)
    copy = qiskit.QuantumCircuit(circuit.n)
    for gate in circuit.gates:
        angle = () if gate.name == "h" else (gate.angle,)
        getattr(copy, gate.name)(*angle, *gate.qubits)
    if measure:
        copy.measure_all()
    return copy


def run_circuit(circuit: Circuit, backend: str, shots: int, seed: int) -> tuple[Samples, Mapping[str, Any]]:
    """Run a circuit on a machine.

    Parameters
    ----------
    circuit : Circuit
    backend : str
        ``fake_...``, a snapshot of a real machine with its couplings and noise, simulated by Aer; or the name of a
        machine of IBM Quantum, with the account that ``QiskitRuntimeService.save_account`` has stored.
    shots : int
    seed : int
        Of the noise and of the choice of qubits; a real machine's noise has none.

    Returns
    -------
    Samples
    mapping
        Name of the machine, depth and number of two-qubit gates of the circuit that ran.

    Raises
    ------
    UnavailableError
        When there is no such real machine, or no account.
    InputError
        When there is no such simulated machine, or the machine has too few qubits.
    """
    machine = fake_backend(backend) if backend.startswith(FAKE) else _runtime_backend(backend)
    if machine.num_qubits < circuit.n:
        raise InputError(f"solver qaoa: {backend} has {machine.num_qubits} qubits, the circuit {circuit.n}")
    native = native_circuit(circuit, machine, seed)
    if backend.startswith(FAKE):
        aer = extra("qiskit_aer", _PURPOSE)
        counts = (
            aer.AerSimulator.from_backend(machine).run(native, shots=shots, seed_simulator=seed).result().get_counts()
        )
    else:
        sampler = extra("qiskit_ibm_runtime", _PURPOSE).SamplerV2(mode=machine)
        counts = sampler.run([native], shots=shots).result()[0].data.meas.get_counts()
    two_qubit_gates = native.num_nonlocal_gates()
    details = {"backend": backend, "depth": int(native.depth()), "two_qubit_gates": int(two_qubit_gates)}
    return samples_of_counts(counts, circuit.n), details


def native_circuit(circuit: Circuit, machine: Any, seed: int) -> Any:
    """The circuit in the gates and couplings of a machine; ``seed`` is of the choice of qubits."""
    manager = extra("qiskit.transpiler", _PURPOSE).generate_preset_pass_manager(
        optimization_level=3, backend=machine, seed_transpiler=seed
    )
    return manager.run(qiskit_circuit(circuit))


def samples_of_counts(counts: Mapping[str, int], n: int) -> Samples:
    """Bits of qiskit's counts, whose texts have the last qubit first."""
    texts = sorted(counts)
    bits = np.array([[int(digit) for digit in reversed(text)] for text in texts], dtype=np.int8).reshape(len(texts), n)
    return Samples(bits, np.array([counts[text] for text in texts], dtype=np.int64))


def fake_backend(name: str) -> Any:
    """Snapshot of a machine by its name, such as ``fake_manila``.

    Raises
    ------
    InputError
        When there is none of that name.
    """
    provider = extra("qiskit_ibm_runtime.fake_provider", _PURPOSE).FakeProviderForBackendV2()
    known = {backend.name: backend for backend in provider.backends()}
    if name not in known:
        raise InputError(f"solver qaoa: no machine is called {name!r}; there are {', '.join(sorted(known))}")
    return known[name]


def _runtime_backend(name: str) -> Any:
    runtime = extra("qiskit_ibm_runtime", _PURPOSE)
    try:
        service = runtime.QiskitRuntimeService()
    except (runtime.accounts.AccountNotFoundError, ValueError) as error:
        raise UnavailableError(
            f"solver qaoa: {name} needs an account of IBM Quantum, stored by QiskitRuntimeService.save_account: {error}"
        ) from None
    try:
        return service.backend(name)
    except Exception as error:
        raise UnavailableError(f"solver qaoa: IBM Quantum offers no machine {name!r}: {error}") from None
