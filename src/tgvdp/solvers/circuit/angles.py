"""QAOA on a statevector: angles by optimisation or as a ramp, shots, and the exact probability of success.

Angles minimise the expected energy, from p = 1 upwards: BFGS with the exact gradient, from the best angles of one layer
less, interpolated, from the best ramp, and from random starts. The cost of a layer is measured in units of the energy's
spread over all strings, so that starting angles fit every instance.
"""

import time
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tgvdp.errors import InputError
from tgvdp.formulations.circuit.qaoa import Angles, checked_angles, interpolated, qaoa_circuit, ramp_angles
from tgvdp.formulations.circuit.statevector import MAX_QUBITS, evaluate, sample, statevector
from tgvdp.formulations.circuit.walls import Walls
from tgvdp.formulations.problem.schedule import Solution
from tgvdp.formulations.qubo.encoded import Encoded
from tgvdp.formulations.qubo.ising import ising_of
from tgvdp.formulations.qubo.qubo import bits_of
from tgvdp.solvers.allowance import Allowance, MixerChoice
from tgvdp.solvers.extras import extra
from tgvdp.solvers.samplers.sampling import Samples, lowest, sampled_solution

#: Angles of a whole layer of a ramp, rad, of which the best one is taken.
RAMP_STEPS = tuple(np.geomspace(0.1, 3.0, 16).tolist())

#: Iterations of BFGS at most, per start and number of layers.
MAX_ITERATIONS = 100


class Found(NamedTuple):
    """Angles, and how many evaluations of the expected energy they took."""

    angles: Angles
    evaluations: int


class Space(NamedTuple):
    """The strings that a circuit can reach.

    Attributes
    ----------
    energies, violation : (S,) float64
    bits : callable
        Numbers of strings → their bits.
    state : callable
        Angles → (S,) amplitudes.
    """

    energies: NDArray[np.float64]
    violation: NDArray[np.float64]
    bits: Callable[[ArrayLike], NDArray[np.int8]]
    state: Callable[[Angles], NDArray[np.complex128]]

    @property
    def scale(self) -> float:
        """Spread of the energies, against which γ is measured."""
        return float(self.energies.std()) or 1.0


def space_of(encoded: Encoded, mixer: MixerChoice) -> Space:
    """All strings, or those whose registers are in order.

    Raises
    ------
    InputError
        When there are too many, or no registers.
    """
    qubo = encoded.qubo
    if mixer == "walls":
        walls = Walls(encoded.registers)
        energies = walls.energies(qubo)
        return Space(energies, walls.energies(encoded.violation), walls.bits, partial(walls.state, energies))
    if not 1 <= qubo.n <= MAX_QUBITS:
        raise InputError(f"solver qaoa: {qubo.n} bits, but 1 to {MAX_QUBITS} qubits are simulated")
    energies = qubo.all_energies()
    return Space(energies, encoded.violation.all_energies(), partial(bits_of, n=qubo.n), partial(statevector, energies))


def solve_qaoa(encoded: Encoded, allowance: Allowance) -> Solution:
    """Sample the state of QAOA; uses ``reads`` (shots), ``seed``, ``backend`` and what `_angles` does.

    The solution is the best of the shots. ``success_probability`` in its details is that of one shot to give a string
    that violates nothing and reaches the constrained optimum: exact of the simulated state, the share of the shots on a
    machine; ``random_probability`` is that of drawing bits by tossing coins. ``setup_s`` is the time before the first
    shot: energies, angles, state.

    Raises
    ------
    InputError
        When there are too many bits, or the backend cannot be used.
    """
    start = time.perf_counter()
    space = space_of(encoded, allowance.mixer)
    found = _angles(space, allowance)
    state = space.state(found.angles)
    setup_s = time.perf_counter() - start
    machine: dict[str, Any] = {"backend": None}
    if allowance.backend is None:
        drawn = sample(state, allowance.reads, np.random.default_rng(allowance.seed))
        samples = Samples(space.bits(drawn), np.ones(allowance.reads, dtype=np.int64))
    else:
        from tgvdp.solvers.circuit.qiskit import run_circuit

        circuit = qaoa_circuit(ising_of(encoded.qubo, -1), found.angles)
        samples, ran = run_circuit(circuit, allowance.backend, allowance.reads, allowance.seed)
        machine |= ran
    elapsed_s = time.perf_counter() - start
    details = {
        "layers": allowance.layers,
        "mixer": allowance.mixer,
        "angles": allowance.angles,
        "gamma": found.angles.gamma.tolist(),
        "beta": found.angles.beta.tolist(),
        "evaluations": found.evaluations,
        "setup_s": setup_s,
        "seed": allowance.seed,
        **machine,
        **probabilities(encoded, space, np.abs(state) ** 2),
    }
    if allowance.backend is not None:  # what the machine does without its noise is none of its figures
        details |= _of_shots(encoded, space, samples)
    return sampled_solution("qaoa", encoded, samples, elapsed_s, details)


def _angles(space: Space, allowance: Allowance) -> Found:
    """Angles as ``layers``, ``mixer``, ``angles``, ``step``, ``starts`` and ``seed`` say."""
    if allowance.step is not None:
        return Found(ramp_angles(allowance.layers, allowance.step, space.scale), 0)
    if allowance.angles == "ramp":
        return best_ramp(space, allowance.layers)
    return optimised_angles(space, allowance.layers, allowance.starts, allowance.seed)


def best_ramp(space: Space, layers: int) -> Found:
    """Ramp of the lowest expected energy among those of `RAMP_STEPS`."""

    def expected(angles: Angles) -> float:
        return float(np.sum(np.abs(space.state(angles)) ** 2 * space.energies))

    ramps = [ramp_angles(layers, step, space.scale) for step in RAMP_STEPS]
    return Found(min(ramps, key=expected), len(ramps))


def optimised_angles(space: Space, layers: int, starts: int, seed: int) -> Found:
    """Angles of the lowest expected energy that the search of the module's docstring finds, over all strings."""
    minimize = extra("scipy.optimize", "solver qaoa").minimize
    energies, scale = space.energies, space.scale
    mean = float(energies.mean())
    evaluations = 0

    def scaled(point: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        nonlocal evaluations
        evaluations += 1
        p = len(point) // 2
        value = evaluate(energies, Angles(point[:p] / scale, point[p:]))
        return (value.energy - mean) / scale, np.concatenate((value.gamma / scale, value.beta)) / scale

    def descended(start: Angles) -> tuple[float, Angles]:
        point = np.concatenate((start.gamma * scale, start.beta))
        result = minimize(scaled, point, jac=True, method="BFGS", options={"maxiter": MAX_ITERATIONS, "gtol": 1e-6})
        p = len(start.gamma)
        return float(result.fun), checked_angles(result.x[:p] / scale, result.x[p:])

    rng = np.random.default_rng(seed)
    known: list[Angles] = []
    for p in range(1, layers + 1):
        random = [
            Angles(rng.uniform(0.0, 2.0, p) / scale, rng.uniform(-np.pi / 2, np.pi / 2, p)) for _ in range(starts)
        ]
        candidates = [*known, best_ramp(space, p).angles, *random]
        best = min(map(descended, candidates), key=lambda pair: pair[0])[1]
        known = [interpolated(best)]
    return Found(best, evaluations + layers * len(RAMP_STEPS))


def probabilities(encoded: Encoded, space: Space, chance: NDArray[np.float64]) -> dict[str, float | None]:
    """Exact probabilities of one shot: of success, of a ground state, of no violation, and the expected energy.

    Success is a string without violation whose schedule is feasible and reaches the least objective of all such
    strings; None where there is none.

    Parameters
    ----------
    encoded : Encoded
    space : Space
    chance : (S,) float64
        Of each of its strings.
    """
    unbroken = space.violation < 0.5  # whole numbers, and rounding
    optima = _optima(encoded, space, np.flatnonzero(unbroken))
    ground = lowest(space.energies, encoded.qubo)
    return {
        "expected_energy": float(np.sum(chance * space.energies)),
        "success_probability": float(chance[optima].sum()) if optima.size else None,
        "random_probability": optima.size / 2.0**encoded.qubo.n if optima.size else None,
        "ground_state_probability": float(chance[ground].sum()),
        "unviolated_probability": float(chance[unbroken].sum()),
    }


def _of_shots(encoded: Encoded, space: Space, samples: Samples) -> dict[str, float | None]:
    """The figures of `probabilities` as shares of shots."""
    numbers = samples.bits.astype(np.int64) @ (1 << np.arange(encoded.qubo.n, dtype=np.int64))
    chance = np.bincount(numbers, samples.counts, minlength=space.energies.size) / samples.total
    return probabilities(encoded, space, chance)


def _optima(encoded: Encoded, space: Space, unbroken: NDArray[np.int64]) -> NDArray[np.int64]:
    """Strings that are feasible and of the least objective, among those whose QUBO part is unviolated."""
    energies = space.energies
    order = unbroken[np.argsort(energies[unbroken], kind="stable")]
    best, found = None, []
    for z in order.tolist():
        schedule = encoded.decode(space.bits(z))
        if best is not None and schedule.objective != best and energies[z] > energies[found[-1]]:
            break
        if schedule.feasible:
            best = schedule.objective
            found.append(z)
    return np.array(found, dtype=np.int64)
