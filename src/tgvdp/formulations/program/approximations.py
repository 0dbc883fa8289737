"""Quadratic approximations of the demand model, by least squares over a Vandermonde matrix, with their errors.

After the Alstom formulation: quadratic solvers take no exponentials and no cubic curves. Two ways:

- ``split``: traction p ≥ 0 and braking q ≥ 0 apart. F₊ ≈ a0 + a1·v, F₋ ≈ b0 + b1·v, cost map ≈ c1·v·p + c2·p. Zero
  demand means zero force and zero cost, exactly.
- ``joint``: one polynomial a·v + b·d + c·v·d of speed and demand for the force, and one for the cost. Its term a·v acts
  at zero demand: kilonewtons of phantom drag.

Errors are those of the fit alone. What a solution is worth only its replay on the true curves tells.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tgvdp.formulations.problem.alstom import Floats, braking_n, force_n, power_w, traction_n
from tgvdp.formulations.problem.instances import DemandInstance

_SPEEDS, _DEMANDS = 221, 41


@dataclass(frozen=True)
class Fit:
    """A polynomial fitted to samples.

    Attributes
    ----------
    name : str
    terms : tuple of str
        Such as ``1``, ``v``, ``v·d``; v in m/s.
    coefficients : tuple of float
        N or W per unit of each term.
    unit : str
    rms, worst : float
        Root mean square and largest magnitude of the error over the samples.
    scale : float
        Largest magnitude of what was fitted.
    """

    name: str
    terms: tuple[str, ...]
    coefficients: tuple[float, ...]
    unit: str
    rms: float
    worst: float
    scale: float


def _fit(name: str, columns: dict[str, Floats], values: Floats, unit: str) -> Fit:
    matrix = np.column_stack([np.broadcast_to(column, values.shape).ravel() for column in columns.values()])
    # Columns of very different size: scale them, solve, and scale back.
    size = np.abs(matrix).max(axis=0)
    scaled = np.linalg.lstsq(matrix / size, values.ravel(), rcond=None)[0]
    error = matrix @ (scaled / size) - values.ravel()
    return Fit(
        name,
        tuple(columns),
        tuple((scaled / size).tolist()),
        unit,
        float(np.sqrt(np.mean(error**2))),
        float(np.abs(error).max()),
        float(np.abs(values).max()),
    )


class SplitFits(NamedTuple):
    """Approximations with traction and braking apart: F₊, F₋ and the cost map of a demand of 0..1."""

    traction: Fit
    braking: Fit
    cost: Fit


class JointFits(NamedTuple):
    """Approximations by a·v + b·d + c·v·d, for demands of −1..1: force, and cost with its sign."""

    force: Fit
    cost: Fit


def split_fits(instance: DemandInstance) -> SplitFits:
    """Fit up to the instance's speed limit; the cost over the positive demands that the instance allows."""
    v = np.linspace(0.0, instance.vmax_mps, _SPEEDS)
    line = {"1": np.ones_like(v), "v": v}
    p = _demands(instance, 0.0)
    speed, demand = np.meshgrid(v, p, indexing="ij")
    power = power_w(speed, demand, instance.p_max_w, instance.cost_ref_mps, 0.0)
    return SplitFits(
        _fit("traction", line, traction_n(v), "N"),
        _fit("braking", line, braking_n(v), "N"),
        _fit("cost", {"v·p": speed * demand, "p": demand}, power, "W"),
    )


def joint_fits(instance: DemandInstance) -> JointFits:
    """Fit one polynomial of speed and demand up to the instance's speed limit."""
    v = np.linspace(0.0, instance.vmax_mps, _SPEEDS)
    speed, demand = np.meshgrid(v, _demands(instance, -1.0), indexing="ij")
    columns = {"v": speed, "d": demand, "v·d": speed * demand}
    power = power_w(speed, demand, instance.p_max_w, instance.cost_ref_mps, instance.alpha)
    return JointFits(_fit("force", columns, force_n(speed, demand), "N"), _fit("cost", columns, power, "W"))


def phantom_drag_n(fits: JointFits, speed_mps: float) -> float:
    """Resistance that the joint force polynomial invents at zero demand: −a·v, N."""
    return -fits.force.coefficients[0] * speed_mps


def _demands(instance: DemandInstance, least: float) -> Floats:
    if instance.levels is None:
        return np.linspace(least, 1.0, _DEMANDS)
    return np.array([level for level in instance.levels if level >= least])
