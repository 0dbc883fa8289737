"""Small random trains at a substation, and all their plans by enumeration: it shares nothing with the solvers."""

import itertools
import random
from fractions import Fraction
from pathlib import Path
from typing import Any

from tgvdp.formulations.problem.instances import SubstationInstance
from tgvdp.formulations.problem.reading import parse_instance


def substation(trains: list[dict[str, Any]], power_units: int = 1000, alpha: float = 0.0) -> SubstationInstance:
    """An instance of given trains, at Δt = 10 s and Δv = 2 m/s."""
    params = {
        "kind": "substation", "dt_s": 10.0, "dv_mps": 2.0, "power_units": power_units, "alpha": alpha,
        "trains": trains,
    }  # fmt: skip
    instance = parse_instance(Path("trip.json"), {"id": "trip", "params": params})
    assert isinstance(instance, SubstationInstance)
    return instance


def random_substation(seed: int, trains: int = 2, steps: int = 6, *, zones: bool = False) -> SubstationInstance:
    """Trains whose departures, caps, distances and masses are drawn; some draws are infeasible.

    With ``zones`` each step of a train has a cap of its own.
    """
    rng = random.Random(seed)
    own = [
        {
            "N": steps - rng.randint(0, 1), "start": rng.randint(0, 2), "mass_units": rng.randint(1, 2),
            "cap_units": rng.randint(1, 2), "D_units": rng.randint(3, 6),
        }
        for _ in range(trains)
    ]  # fmt: skip
    power_units, alpha = rng.randint(2, 9), rng.choice((0.0, 0.5, 0.8, 1.0))
    if zones:
        own = [one | {"cap_units": [rng.randint(1, 2) for _ in range(one["N"])]} for one in own]
    return substation(own, power_units, alpha)


def all_plans(instance: SubstationInstance) -> tuple[Fraction | None, int]:
    """Least Σ n_i in ½·Δv² and the number of plans that reach it, by trying every plan of every train."""
    alpha = Fraction(repr(instance.alpha))
    best, count = None, 0
    for plan in itertools.product(*(list(_plans(train.trip)) for train in instance.trains)):
        net = []
        for i in range(instance.steps):
            drawn = offered = Fraction(0)
            for train, v in zip(instance.trains, plan, strict=True):
                if 0 <= i - train.start < train.trip.steps:
                    before, after = v[i - train.start], v[i - train.start + 1]
                    gained = train.mass_units * (after**2 - before**2)
                    drawn, offered = drawn + max(0, gained), offered + max(0, -gained)
            net.append(max(Fraction(0), drawn - alpha * offered))
        if max(net) > instance.power_units:
            continue
        total = sum(net, Fraction(0))
        if best is None or total < best:
            best, count = total, 0
        count += total == best
    return best, count


def _plans(trip: Any) -> Any:
    for moves in itertools.product((-1, 0, 1), repeat=trip.steps):
        v = list(itertools.accumulate(moves, initial=0))
        within = all(0 <= one <= cap for one, cap in zip(v[1:], trip.cap_units, strict=True))
        if within and v[-1] == 0 and sum(v) == trip.distance_units:
            yield v
