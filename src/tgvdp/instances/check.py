"""Judge a solution of an instance; needs Python alone: ``python check.py INSTANCE.json SOLUTION.sol``.

A solution is one control a line, of trains one after the other: the demand, or the change of speed in Δv. Prints the
objective and every violation; the exit code is 1 where one is. Written from docs/formulations.md.
"""

import json
import math
import sys
from collections import Counter
from fractions import Fraction
from itertools import accumulate, pairwise
from pathlib import Path
from typing import Any


def exact(value: float) -> Fraction:
    """The number that a decimal means: 0.1 is 1/10."""
    return Fraction(repr(value))


def driven(p: Any, u: Any) -> tuple[list[Any], list[str]]:
    """Speeds in Δv, and violations."""
    a, b, n = p.get("acc_units", 1), p.get("dec_units", 1), p["N"]
    caps, v = p["cap_units"] if isinstance(p["cap_units"], list) else [p["cap_units"]] * n, [0, *accumulate(u)]
    broken = [f"step {k}: {one} is neither {a}, 0 nor {-b}" for k, one in enumerate(u, 1) if one not in (a, 0, -b)]
    after = enumerate(zip(v[1:], caps, strict=False), 1)
    broken += [f"after step {k}: speed {x} is not in 0..{cap}" for k, (x, cap) in after if not 0 <= x <= cap]
    off = abs(exact(0.5) * (sum(v[:-1]) + sum(v[1:])) - exact(p["D_units"])) - exact(p.get("tol_units", 0.0))
    broken += [f"tolerance missed by {float(off)}"] if off > 0 else []
    return v, broken + ([f"the speed at the end is {v[-1]}"] if v[-1] else [])


def check_binary(p: Any, u: Any) -> tuple[float, list[str]]:
    """Objective in (m/s)² or J/kg, and violations."""
    (v, broken), alpha = driven(p, u), exact(p.get("alpha", 0.0))
    if p["model"] == "constant":
        cost: Any = sum(x * x if x > 0 else -alpha * x * x for x in u)
    elif p["model"] == "kinetic":
        cost = sum(max(x, alpha * x) for x in (y * y - x * x for x, y in pairwise(v))) * exact(0.5)
    else:
        cost = sum(exact(p["eta0"]) * x - exact(p["deta"]) * x * x for x in v[1:])
    return float(cost * exact(p["dv_mps"]) ** 2), broken


def check_substation(p: Any, u: Any) -> tuple[float, list[str]]:
    """Objective in J per kg of a train of mass 1, and violations."""
    broken, drawn, offered, first = list[str](), Counter[Any](), Counter[Any](), 0
    for number, train in enumerate(p["trains"], 1):
        v, own = driven(train, u[first : (first := first + train["N"])])
        broken += [f"train {number}, {text}" for text in own]
        for step, (before, after) in enumerate(pairwise(v), 1 + train.get("start", 0)):
            (drawn if after > before else offered)[step] += train.get("mass_units", 1) * abs(after**2 - before**2)
    net = {step: max(Fraction(0), drawn[step] - exact(p.get("alpha", 0.0)) * offered[step]) for step in drawn}
    broken += [f"step {step}: the substation gives {float(one)}" for step, one in net.items() if one > p["power_units"]]
    return float(sum(net.values()) * exact(p["dv_mps"]) ** 2 / 2), broken


TRACTION = ((50, (2.44e5, -354.1, 0, 0)), (60, (2.704e5, -881.3, 0, 0)), (220, (4.566e5, -5603, 28.78, -0.05265)))
BRAKING = ((20, (1.243, 9925, 0, 0)), (100, (1.985e5, 0, 0, 0)), (220, (4.012e5, -2583, 5.389, 0)))


def check_demand(p: Any, demands: list[float]) -> tuple[float, list[str]]:
    """Objective in J, and violations."""
    v, s, cost, broken = 0.0, 0.0, 0.0, list[str]()
    (a, b, c), dt, notches = p["davis_SI"], p["dt_s"], p["notches"]
    limit, ref = p["vmax_kmh"] / 3.6, p["cost_ref_kmh"] / 3.6
    levels = [j / notches for j in range(-notches, notches + 1)] if isinstance(notches, int) else notches
    for k, d in enumerate(demands, 1):
        near = min(abs(d - level) for level in levels) if levels else max(0.0, abs(d) - 1.0)
        broken += [f"step {k}: demand {d} is not allowed"] if near > 1e-9 else []
        radius, slope = (next((one for start, one in reversed(p.get(name, [])) if start <= s), None)
                         for name in ("curves_m", "gradients_permil"))  # fmt: skip
        kmh = min(3.6 * v, 220.0)
        f = next(f for end, f in (TRACTION if d >= 0 else BRAKING) if kmh <= end * (1 + 1e-12))
        climb = p["mass_kg"] * 9.81 * ((slope or 0.0) + (800.0 / radius if radius else 0.0)) / 1000.0
        pull = d * (f[0] + kmh * (f[1] + kmh * (f[2] + kmh * f[3]))) - (a + b * v + c * v * v + climb)
        after = max(0.0, v + pull * dt / (p["rot"] * p["mass_kg"]))
        mean, scale = (v + after) / 2, p["P_max_W"] * dt / (math.expm1(-1.0) ** 2 * math.tanh(100))
        shape = -math.expm1(-mean / ref) * math.tanh(100 * abs(d)) * -math.expm1(-abs(d))
        cost, v, s = cost + (1.0 if d >= 0 else -p.get("alpha", 0.0)) * scale * shape, after, s + mean * dt
        broken += [f"after step {k}: speed {v} m/s is above {limit} m/s"] if v > limit * (1 + 1e-9) else []
    broken += [f"tolerance missed by {off} m"] if (off := abs(s - p["D_m"]) - p["tol_m"]) > 1e-9 * p["D_m"] else []
    return cost, broken + ([f"the speed at the end is {v} m/s"] if v > p["v_end_max_mps"] + 1e-9 * limit else [])


def main(instance: str, solution: str) -> int:
    """Check one file against the other."""
    p = json.loads(Path(instance).read_text(encoding="utf-8"))["params"]
    check: Any = {"demand": check_demand, "substation": check_substation}.get(p.get("kind"), check_binary)
    controls = [*map(float if check is check_demand else Fraction, Path(solution).read_text(encoding="utf-8").split())]
    (objective, broken), steps = check(p, controls), sum(one["N"] for one in p.get("trains", [p]))
    broken += [f"{len(controls)} controls, not {steps}"] if len(controls) != steps else []
    print(f"objective {objective!r}", *broken, "infeasible" if broken else "feasible", sep="\n")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
