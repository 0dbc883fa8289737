"""Instances of the binary model for tests of solvers."""

import numpy as np

from tgvdp.formulations.problem.instances import BinaryInstance


def binary_instance(steps, **changes):
    """A level trip with equal steps; change what the test is about."""
    plain = {
        "id": f"n{steps}",
        "model": "constant",
        "steps": steps,
        "dt_s": 1.0,
        "dv_mps": 1.0,
        "acc_units": 1,
        "dec_units": 1,
        "cap_units": steps // 2,
        "distance_units": float(steps * steps // 6),
        "eta0": 0.9,
        "deta": 0.05,
    } | changes
    caps = plain["cap_units"]
    plain["cap_units"] = tuple(caps) if isinstance(caps, (list, tuple)) else (caps,) * steps
    return BinaryInstance(**plain)


def random_instance(rng: np.random.Generator, most_steps=8):
    """Any model, steps, caps, tolerance and regeneration; about half of them feasible."""
    steps = int(rng.integers(1, most_steps + 1))
    acc, dec = (1, 1) if rng.random() < 0.6 else rng.integers(1, 4, 2).tolist()
    one_cap = rng.random() < 0.5
    return binary_instance(
        steps,
        model=str(rng.choice(["constant", "kinetic", "efficiency"])),
        dv_mps=float(rng.choice([0.1, 0.5, 1.0])),
        acc_units=acc,
        dec_units=dec,
        cap_units=int(rng.integers(2, 6)) if one_cap else rng.integers(1, 6, steps).tolist(),
        distance_units=float(rng.integers(1, max(2, steps * steps // 4 + 1))),
        tol_units=float(rng.integers(0, 2)),
        alpha=float(rng.choice([0.0, 0.3, 0.6, 1.0])),
    )
