"""Judge a solution of an instance; needs Python alone: ``python check.py INSTANCE.json SOLUTION.sol``.

A solution is one control a line: the change of speed of each step in Δv (binary), or the demand. Prints the objective
and every violation; the exit code is 1 where one is. Written from docs/formulations.md, without any code of tgvdp.
"""

import json
import math
import sys
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any


def exact(value: float) -> Fraction:
    """The number that a decimal means: 0.1 is 1/10."""
    return Fraction(repr(value))


def check_binary(p: Any, controls: list[int]) -> tuple[float, list[str]]:
    """Objective in (m/s)² or J/kg, and violations."""
    a, b, n, alpha = p["acc_units"], p["dec_units"], p["N"], exact(p.get("alpha", 0.0))
    caps = p["cap_units"] if isinstance(p["cap_units"], list) else [p["cap_units"]] * n
    v = [0]
    for u in controls:
        v.append(v[-1] + u)
    broken = [f"step {k}: {u} is neither {a}, 0 nor {-b}" for k, u in enumerate(controls, 1) if u not in (a, 0, -b)]
    broken += [f"after step {k}: speed {v[k]} is outside 0..{caps[k - 1]}" for k in range(1, min(n, len(controls)) + 1)
               if not 0 <= v[k] <= caps[k - 1]]  # fmt: skip
    off = abs(Fraction(sum(v[:-1]) + sum(v[1:]), 2) - exact(p["D_units"])) - exact(p.get("tol_units", 0.0))
    broken += [f"distance misses its tolerance by {float(off)}"] if off > 0 else []
    broken += [f"the speed at the end is {v[-1]}"] if v[-1] else []
    if p["model"] == "constant":
        cost: Any = sum(u * u if u > 0 else -alpha * u * u for u in controls)
    elif p["model"] == "kinetic":
        gains = [Fraction(after**2 - before**2, 2) for before, after in pairwise(v)]
        cost = sum(gain if gain > 0 else alpha * gain for gain in gains)
    else:
        cost = sum(exact(p["eta0"]) * x - exact(p["deta"]) * x * x for x in v[1:])
    return float(cost * exact(p["dv_mps"]) ** 2), broken


TRACTION = ((50, (2.44e5, -354.1, 0, 0)), (60, (2.704e5, -881.3, 0, 0)), (220, (4.566e5, -5603, 28.78, -0.05265)))
BRAKING = ((20, (1.243, 9925, 0, 0)), (100, (1.985e5, 0, 0, 0)), (220, (4.012e5, -2583, 5.389, 0)))


def force(pieces: Any, v: float) -> Any:
    """Largest force in N at v in m/s."""
    kmh = min(max(3.6 * v, 0.0), 220.0)
    c = next(c for end, c in pieces if kmh <= end * (1 + 1e-12))
    return c[0] + kmh * (c[1] + kmh * (c[2] + kmh * c[3]))


def value_at(rows: Any, s: float) -> Any:
    """Value of [from, value] rows at s, None before the first."""
    return next((value for start, value in reversed(rows) if start <= s), None)


def check_demand(p: Any, demands: list[float]) -> tuple[float, list[str]]:
    """Objective in J, and violations."""
    v = s = cost = 0.0
    broken: list[str] = []
    (a, b, c), dt = p["davis_SI"], p["dt_s"]
    notches, limit, ref = p["notches"], p["vmax_kmh"] / 3.6, p["cost_ref_kmh"] / 3.6
    levels = [j / notches for j in range(-notches, notches + 1)] if isinstance(notches, int) else notches
    for k, d in enumerate(demands, 1):
        near = min(abs(d - level) for level in levels) if levels else max(0.0, abs(d) - 1.0)
        broken += [f"step {k}: demand {d} is not allowed"] if near > 1e-9 else []
        radius = value_at(p.get("curves_m", []), s)
        slope = (value_at(p.get("gradients_permil", []), s) or 0.0) + (800.0 / radius if radius else 0.0)
        pull = d * force(TRACTION if d >= 0 else BRAKING, v)
        drag = a + b * v + c * v * v + p["mass_kg"] * 9.81 * slope / 1000.0
        after = max(0.0, v + (pull - drag) * dt / (p["rot"] * p["mass_kg"]))
        mean = (v + after) / 2
        shape = -math.expm1(-mean / ref) * math.tanh(100 * abs(d)) * -math.expm1(-abs(d))
        cost += (1.0 if d >= 0 else -p.get("alpha", 0.0)) * p["P_max_W"] * dt * shape / (
            math.expm1(-1.0) ** 2 * math.tanh(100))  # fmt: skip
        v, s = after, s + mean * dt
        broken += [f"after step {k}: speed {v} m/s is above {limit} m/s"] if v > limit * (1 + 1e-9) else []
    off = abs(s - p["D_m"]) - p["tol_m"]
    broken += [f"distance misses its tolerance by {off} m"] if off > 1e-9 * p["D_m"] else []
    broken += [f"the speed at the end is {v} m/s"] if v > p["v_end_max_mps"] + 1e-9 * limit else []
    return cost, broken


def main(instance: str, solution: str) -> int:
    """Check one file against the other."""
    params = json.loads(Path(instance).read_text(encoding="utf-8"))["params"]
    binary = params.get("kind", "binary") == "binary"
    controls = [float(line) for line in Path(solution).read_text(encoding="utf-8").splitlines() if line]
    objective, broken = check_binary(params, [*map(int, controls)]) if binary else check_demand(params, controls)
    broken += [f"{len(controls)} controls, not {params['N']}"] if len(controls) != params["N"] else []
    print("\n".join([f"objective {objective!r}", *broken, "infeasible" if broken else "feasible"]))
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
