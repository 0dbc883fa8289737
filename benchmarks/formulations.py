"""The examples of the formulations: ``python -m benchmarks formulations`` writes results/formulations."""

import io
import json
import sys
import time
from pathlib import Path

import numpy as np

from benchmarks.timing import ROOT
from tgvdp.formulations.problem.alstom import braking_n, energy_faults, power_w, traction_n
from tgvdp.formulations.problem.instances import BinaryInstance, DemandInstance
from tgvdp.formulations.problem.three_phase import three_phase_run
from tgvdp.formulations.program.approximations import Fit, joint_fits, phantom_drag_n, split_fits
from tgvdp.report import make_provenance
from tgvdp.report.files import write_files
from tgvdp.report.formulation_plots import Curve, plot_curves, schedule_curve
from tgvdp.report.plain import markdown_table
from tgvdp.solvers.registry import solve

DISTANCE_M, TIME_S = 100e3, 1800.0
STEPS = 60
DEMAND = DemandInstance(
    id="first-results", steps=40, dt_s=15.0, levels=tuple(j / 4 for j in range(-4, 5)), mass_kg=3e5,
    rotating_factor=1.08, davis=(1770.0, 35.4, 6.6), vmax_mps=160 / 3.6, distance_m=20e3, tol_m=30.0,
    end_speed_max_mps=1.5, p_max_w=9.8e6, cost_ref_mps=220 / 3.6, alpha=0.3,
)  # fmt: skip


def three_phase():
    run = three_phase_run(DISTANCE_M, TIME_S, 0.3, 0.5)
    t = np.linspace(0.0, TIME_S, 2000)
    marks = (run.end_of_traction_s / 60, run.start_of_braking_s / 60)
    figure = plot_curves(
        [Curve("speed", t / 60, 3.6 * run.speed_mps(t))], "Time (min)", "Speed (km/h)", "Three phases",
        f"100 km in 30 min, a = 0.3, a' = 0.5 m/s²: V = {3.6 * run.cruising_speed_mps:.1f} km/h, "
        f"t1 = {run.end_of_traction_s:.1f} s, t2 = {run.start_of_braking_s:.1f} s", marks,
    )  # fmt: skip
    return figure, run


def binary_trip(model):
    """The flat trip of 100 km in 30 min in 60 steps of 30 s; the distance is rounded to whole Δv·Δt = 150 m."""
    dt_s, dv_mps = TIME_S / STEPS, 5.0
    return BinaryInstance(
        id=f"flat-100km-{model}", model=model, steps=STEPS, dt_s=dt_s, dv_mps=dv_mps, acc_units=1, dec_units=1,
        cap_units=(17,) * STEPS, distance_units=round(DISTANCE_M / (dt_s * dv_mps)), tol_units=0.0, alpha=0.3,
        eta0=0.9, deta=0.02,
    )  # fmt: skip


def binary():
    curves, rows = [], []
    for index, model in enumerate(("constant", "kinetic", "efficiency")):
        trip = binary_trip(model)
        solution = solve(trip, "dp")
        speeds = [trip.dv_mps * v for v in solution.schedule.speeds]
        curves.append(schedule_curve(model, speeds, trip.dt_s, dashed=index > 0))
        rows.append(
            {
                "instance": trip.id,
                "objective": solution.objective,
                "unit": trip.objective_unit,
                "optima": str(solution.n_optimal),
                "replay": "feasible" if solution.replay["feasible"] else "infeasible",
                "energy_j_per_kg": float(solution.replay["energy"]),
                "distance_m": float(solution.replay["distance_m"]),
            }
        )
    detail = f"100 km (667 · 150 m) in 30 min, N = {STEPS}, Δt = 30 s, Δv = 5 m/s: one optimum of each model"
    return plot_curves(curves, "Time (min)", "Speed (km/h)", "Binary formulation", detail), rows


def demand():
    solution = solve(DEMAND, "dp")
    detail = f"20 km in 10 min, 9 notches: {solution.objective / 3.6e6:.1f} kWh by the cost map, " + (
        "optimal, proved" if solution.optimal else "best found"
    )
    speed = schedule_curve("speed (km/h)", solution.schedule.speeds, DEMAND.dt_s)
    minutes = np.arange(DEMAND.steps + 1) * DEMAND.dt_s / 60
    held = np.append(solution.schedule.controls, solution.schedule.controls[-1])
    notch = Curve("demand (%)", np.repeat(minutes, 2)[1:], 100 * np.repeat(held, 2)[:-1])
    return plot_curves([speed, notch], "Time (min)", "km/h, %", "Demand model: first results", detail), solution


def fits():
    v = np.linspace(0.0, DEMAND.vmax_mps, 400)
    split, joint = split_fits(DEMAND), joint_fits(DEMAND)
    kmh = 3.6 * v
    (t0, t1), (b0, b1), (c1, c2) = split.traction.coefficients, split.braking.coefficients, split.cost.coefficients
    pictures = {
        "traction": [Curve("F₊", kmh, traction_n(v) / 1e3), Curve("least squares", kmh, (t0 + t1 * v) / 1e3, True)],
        "braking": [Curve("F₋", kmh, braking_n(v) / 1e3), Curve("least squares", kmh, (b0 + b1 * v) / 1e3, True)],
        "cost": [
            curve
            for p in (0.5, 1.0)
            for curve in (
                Curve(f"map, d = {p}", kmh, power_w(v, p, DEMAND.p_max_w, DEMAND.cost_ref_mps, 0.0) / 1e6),
                Curve(f"least squares, d = {p}", kmh, (c1 * v * p + c2 * p) / 1e6, True),
            )
        ],
    }
    units = {"traction": "Force (kN)", "braking": "Force (kN)", "cost": "Power (MW)"}
    figures = {}
    for fit in (split.traction, split.braking, split.cost):
        detail = f"error: rms {fit.rms:.4g} {fit.unit}, worst {fit.worst:.4g} {fit.unit}"
        figures[f"{fit.name}_fit"] = plot_curves(
            pictures[fit.name], "Speed (km/h)", units[fit.name], f"Approximation: {fit.name}", detail
        )
    return figures, [fit_row("split", fit) for fit in split] + [fit_row("joint", fit) for fit in joint], joint


def fit_row(form: str, fit: Fit) -> dict[str, object]:
    polynomial = " + ".join(f"{c:.5g}·{term}" for c, term in zip(fit.coefficients, fit.terms, strict=True))
    errors = {"unit": fit.unit, "rms": fit.rms, "worst": fit.worst}
    return {"form": form, "fit": fit.name, "polynomial": polynomial, **errors}


def main(folder: Path) -> None:
    """Compute all examples and write page, pictures and provenance."""
    started = time.perf_counter()
    figures = {}
    figures["three_phase"], run = three_phase()
    figures["binary"], rows = binary()
    figures["demand"], solved = demand()
    more, fit_rows, joint = fits()
    figures |= more
    faults = energy_faults(DEMAND.p_max_w, DEMAND.cost_ref_mps, DEMAND.alpha, DEMAND.vmax_mps, DEMAND.levels)
    replayed, fine = solved.replay, solved.replay["fine"]
    options = {"distance_m": DISTANCE_M, "time_s": TIME_S, "steps": STEPS}
    provenance = make_provenance(options, {}, time.perf_counter() - started)
    page = f"""# The examples of the formulations

Made by `python -m benchmarks formulations` with tgvdp {provenance["tgvdp"]}, {provenance["utc"]}.

## Three phases

![three phases](three_phase.png)

V = {run.cruising_speed_mps:.4f} m/s, t1 = {run.end_of_traction_s:.2f} s, t2 = {run.start_of_braking_s:.2f} s,
{run.energy_j():.1f} J/kg.

## Binary formulation: flat, 100 km

![binary](binary.png)

{markdown_table(rows)}
All proved by the exact dynamic program; optima are counted exactly. Of the objectives only that of the kinetic model is
an energy.

## Demand model

![demand](demand.png)

{"Optimal, proved" if solved.optimal else "Best found"}: {solved.objective:.6g} J by the cost map; lower bound before
search {solved.details["bound"]:.6g} J. Replay by the model's step: distance {replayed["distance_error_m"]:+.2f} m; by
steps 200 times as fine: {fine["distance_error_m"]:+.1f} m, end speed {fine["end_speed_error_mps"]:.2f} m/s,
{"feasible" if fine["feasible"] else "not feasible"}: the coarse step is part of the model.
The map draws less than the wheels get on {100 * faults.traction_part:.0f} % of the grid of speeds and notches
(P_max at least {faults.least_p_max_w / 1e6:.2f} MW avoids it), and gives back more than braking takes on
{100 * faults.braking_part:.0f} %.

## Approximations

{markdown_table(fit_rows)}
The joint force polynomial fitted up to 160 km/h drags with {phantom_drag_n(joint, 100 / 3.6) / 1e3:.1f} kN
at 100 km/h and zero demand (6.5 kN where it is fitted up to 220 km/h).

![traction](traction_fit.png)
![braking](braking_fit.png)
![cost](cost_fit.png)
"""
    files = {"formulations.md": page.encode(), "provenance.json": json.dumps(provenance, indent=1).encode() + b"\n"}
    for name, figure in figures.items():
        image = io.BytesIO()
        figure.savefig(image, format="png")
        files[f"{name}.png"] = image.getvalue()
    write_files(folder, files)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "results" / "formulations")
