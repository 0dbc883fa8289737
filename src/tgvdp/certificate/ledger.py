"""How a bound comes about: cell by cell."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tgvdp.certificate.cell_bounds import UNIT_ROUNDOFF
from tgvdp.certificate.speed_bound import Caps
from tgvdp.line.cells import Cells

_Floats = NDArray[np.float64]


class Ledger(NamedTuple):
    """How one bound came about, per unit of inertia: E + λT ≥ inertia·(total − error).

    Attributes
    ----------
    bound : (K,) float64
        Lower bound of each cell.
    doubt : (K,) float64
        Bounds of their rounding errors, in units of 2⁻⁵³.
    left, right : (K,) float64
        Costate at the two ends of each cell.
    cells : Cells
        The cells; ``limit_w`` is the squared speed that no run passes.
    caps : Caps
        The same below the speed bounds.
    w : (K + 1,) float64
        Squared speeds of the run that the costate comes from, m²/s².
    label : (K,) int8
        Its regimes (`certificate.regimes`).
    """

    bound: _Floats
    doubt: _Floats
    left: _Floats
    right: _Floats
    cells: Cells
    caps: Caps
    w: _Floats
    label: NDArray[np.int8]

    @property
    def total(self) -> float:
        """The bound: the sum over the cells."""
        return float(self.bound.sum())

    @property
    def error(self) -> float:
        """Bound of its rounding error."""
        adding = (len(self.bound) + 4.0) * float(np.abs(self.bound).sum())
        return (float(self.doubt.sum()) + adding) * UNIT_ROUNDOFF
