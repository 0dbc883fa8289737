"""Force curves and cost map of the Alstom formulation: piecewise polynomials in V = 3.6·v km/h, jumps and all.

They stand also in the demand formulation, and were fitted to tables of Alstom. The pieces do not quite meet: traction
jumps by +40 N at 50 km/h and −4866 N at 60 km/h, braking by −1710 N at 100 km/h; at a joint the lower piece holds.
Braking is electrodynamic only, 1.2 N at standstill. The Alstom formulation prints [60; 220] for the last braking piece;
it is [100; 220]. The printed 2.039e−13·V of the middle piece is the fit's rounding, and left out.
"""

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tgvdp.formulations.problem.instances import CURVES_END_KMH
from tgvdp.units import KMH_PER_MPS

Floats: TypeAlias = NDArray[np.float64]

#: End of the curves, km/h.
TOP_KMH = CURVES_END_KMH
#: (up to V in km/h, coefficients of 1, V, V², V³ in N).
TRACTION = (
    (50.0, (2.44e5, -354.1, 0.0, 0.0)),
    (60.0, (2.704e5, -881.3, 0.0, 0.0)),
    (TOP_KMH, (4.566e5, -5603.0, 28.78, -0.05265)),
)
BRAKING = (
    (20.0, (1.243, 9925.0, 0.0, 0.0)),
    (100.0, (1.985e5, 0.0, 0.0, 0.0)),
    (TOP_KMH, (4.012e5, -2583.0, 5.389, 0.0)),
)
_ROUNDING = 1e-12
#: Steepness of the cost map at d = 0.
_STEEPNESS = 100.0
#: The map is 1 at full demand and V = V_ref.
_SCALE = (1.0 - np.exp(-1.0)) ** 2 * np.tanh(_STEEPNESS)


def _curve(pieces: tuple[tuple[float, tuple[float, ...]], ...], speed_mps: ArrayLike) -> Floats:
    v = np.clip(KMH_PER_MPS * np.asarray(speed_mps, dtype=np.float64), 0.0, TOP_KMH)
    joints = np.array([end for end, _ in pieces[:-1]]) * (1.0 + _ROUNDING)  # 60/3.6·3.6 is a little more than 60
    which = np.searchsorted(joints, v, side="left")
    c = np.array([coefficients for _, coefficients in pieces])[which]
    force: Floats = c[..., 0] + v * (c[..., 1] + v * (c[..., 2] + v * c[..., 3]))
    return force


def traction_n(speed_mps: ArrayLike) -> Floats:
    """F₊(v), largest traction force in N: (...) m/s → (...)."""
    return _curve(TRACTION, speed_mps)


def braking_n(speed_mps: ArrayLike) -> Floats:
    """F₋(v) > 0, largest braking force in N: (...) m/s → (...)."""
    return _curve(BRAKING, speed_mps)


def force_n(speed_mps: ArrayLike, demand: ArrayLike) -> Floats:
    """Force of a demand: d·F₊ for d ≥ 0, d·F₋ for d < 0, which brakes.

    (As printed, d·(δ·F₊ + (δ − 1)·F₋) pushes the train forward when it brakes; corrected to d·(δ·F₊ + (1 − δ)·F₋).)
    """
    d = np.asarray(demand, dtype=np.float64)
    force: Floats = d * np.where(d >= 0.0, traction_n(speed_mps), braking_n(speed_mps))
    return force


def power_w(speed_mps: ArrayLike, demand: ArrayLike, p_max_w: float, ref_mps: float, alpha: float) -> Floats:
    """Cost map in W: positive for traction, −α times the same map for braking.

    (P_max/S)·(1 − e^{−V/V_ref})·tanh(100·|d|)·(1 − e^{−|d|}), S = (1 − e^{−1})²·tanh(100). (The demand
    formulation misses the minus in an exponent, the Alstom formulation takes 1 − e^{−d} of a negative d.)
    """
    v, d = np.asarray(speed_mps, dtype=np.float64), np.asarray(demand, dtype=np.float64)
    size = np.abs(d)
    shape = -np.expm1(-v / ref_mps) * np.tanh(_STEEPNESS * size) * -np.expm1(-size) / _SCALE
    power: Floats = np.where(d >= 0.0, 1.0, -alpha) * p_max_w * shape
    return power


class EnergyFaults(NamedTuple):
    """Where the cost map creates energy, over speeds up to a top speed and given demands.

    Attributes
    ----------
    traction_part, braking_part : float
        Parts of the grid where traction draws less than its force does work, and where braking returns more.
    traction_worst_w, braking_worst_w : float
        Largest such excess, W.
    least_p_max_w : float
        Smallest P_max at which traction never draws too little. For full demand and V_ref = 220 km/h it is 9.8 MW,
        though the mechanical peak is 3.7 MW; as d → 0 it has no bound, because the map falls with d² and the force with
        d.
    most_p_max_w : float
        Largest P_max at which braking never returns too much; infinite where α = 0.
    """

    traction_part: float
    braking_part: float
    traction_worst_w: float
    braking_worst_w: float
    least_p_max_w: float
    most_p_max_w: float


def energy_faults(
    p_max_w: float, ref_mps: float, alpha: float, top_mps: float = TOP_KMH / KMH_PER_MPS, demand: ArrayLike = 1.0
) -> EnergyFaults:
    """Look for created energy: traction must draw at least d·F₊·v, braking return at most |d|·F₋·v."""
    d = np.unique(np.abs(np.atleast_1d(np.asarray(demand, dtype=np.float64))))
    d = d[d > 0.0]
    v = np.linspace(0.0, top_mps, 2201)[1:, None]
    shape = power_w(v, d, 1.0, ref_mps, 0.0)
    pulling, braking = d * traction_n(v) * v, d * braking_n(v) * v
    missing, invented = pulling - p_max_w * shape, alpha * p_max_w * shape - braking
    return EnergyFaults(
        float((missing > 0.0).mean()),
        float((invented > 0.0).mean()),
        float(max(0.0, missing.max())),
        float(max(0.0, invented.max())),
        float((pulling / shape).max()),
        float((braking / (alpha * shape)).min()) if alpha > 0.0 else np.inf,
    )
